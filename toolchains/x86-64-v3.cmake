# x86-64-v3: Intel since Haswell (2013), AMD since Excavator (2015). The kernels choose their vectors at run time in any
# build; this lets the compiler use AVX2 in all the rest. Without fused products and sums, which Eigen takes wherever it may:
# the map is to be that of any other build.
set(CMAKE_C_FLAGS_INIT "-march=x86-64-v3 -mno-fma")
set(CMAKE_CXX_FLAGS_INIT "-march=x86-64-v3 -mno-fma")
# GCC 12 sees Eigen read four numbers at once from vectors of three, in a branch that is never taken.
string(APPEND CMAKE_CXX_FLAGS_INIT " -Wno-array-bounds")
