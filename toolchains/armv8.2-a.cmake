# Any ARMv8.2-A with half floats and dot products. It serves Jetson Xavier NX, whose Carmel cores GCC 12 does not know.
set(CMAKE_C_FLAGS_INIT "-march=armv8.2-a+fp16+dotprod")
set(CMAKE_CXX_FLAGS_INIT "-march=armv8.2-a+fp16+dotprod")
include(${CMAKE_CURRENT_LIST_DIR}/aarch64-linux.cmake)
