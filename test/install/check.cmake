# Installs the build into a fresh prefix, builds the consumer against it and runs that.
# cmake -DBUILD=<build directory> -DWORK=<scratch> -DCXX=<compiler> -DCXX_FLAGS=<flags> -DBUILD_TYPE=<type> -P check.cmake
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/build -G Ninja -DCMAKE_PREFIX_PATH=${WORK}/prefix
    -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_CXX_FLAGS=${CXX_FLAGS} -DCMAKE_BUILD_TYPE=${BUILD_TYPE})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/consumer)

foreach(program cloister cloister-simulate cloister-ground-truth)
  run(${WORK}/prefix/bin/${program} --help OUTPUT_QUIET)
endforeach()
file(GLOB_RECURSE strays ${WORK}/prefix/*test*.hpp ${WORK}/prefix/*_fuzz*)
if(strays)
  message(FATAL_ERROR "test fixtures are installed: ${strays}")
endif()
