# Cortex-A78AE: Jetson Orin, as on Spot's CORE I/O successors and most recent payload computers.
set(CMAKE_C_FLAGS_INIT "-mcpu=cortex-a78ae")
set(CMAKE_CXX_FLAGS_INIT "-mcpu=cortex-a78ae")
include(${CMAKE_CURRENT_LIST_DIR}/aarch64-linux.cmake)
