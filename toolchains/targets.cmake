# What every target of the project shares: warnings, floating-point rules, and how a test is declared.

# Options each of our own targets is compiled with. Contraction is off so that two machines agree on the map hash.
function(cloister_target_defaults target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
                                           -ffp-contract=off)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC 12 sees overlaps in std::string's operator+ that cannot be (GCC bug 105651).
    target_compile_options(${target} PRIVATE -Wno-restrict)
  endif()
  if(CLOISTER_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
endfunction()

# Sets `result` to whether tests of this kind are built: `bench` (of what never runs on a robot, and of the tree itself),
# `robot` or `threads`. The sanitizers look at what runs on a robot, the thread sanitizer at what starts threads.
function(cloister_builds_tests kind result)
  set(all bench robot threads)
  set(robot robot threads)
  set(threads threads)
  if(CLOISTER_BUILD_TESTS AND kind IN_LIST ${CLOISTER_TESTS})
    set(${result} ON PARENT_SCOPE)
  else()
    set(${result} OFF PARENT_SCOPE)
  endif()
endfunction()

# Sets `result` to what a test starts to run this program: itself, or, where it is built for another processor, a script
# beside the tests that runs it under the emulator.
function(cloister_program_path program result)
  set(path $<TARGET_FILE:${program}>)
  get_target_property(is_imported ${program} IMPORTED)
  if(CMAKE_CROSSCOMPILING_EMULATOR AND NOT is_imported)
    list(JOIN CMAKE_CROSSCOMPILING_EMULATOR " " emulator)
    set(script ${PROJECT_BINARY_DIR}/tests/${program})
    file(CONFIGURE OUTPUT ${script} @ONLY
         CONTENT "#!/bin/sh\nexec ${emulator} ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/${program} \"$@\"\n")
    file(CHMOD ${script} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
    set(path ${script})
  endif()
  set(${result} ${path} PARENT_SCOPE)
endfunction()

# cloister_test(NAME [KIND bench|robot|threads] [LABELLED] SOURCES a_test.cpp ... LINK lib ... [PROGRAMS target ...]
#               [PROPERTIES name value ...]): one doctest executable, each case a CTest test.
# Where it is LABELLED, cases of a doctest suite get the suite's name as a label, by which presets leave them out:
# `slow` takes minutes under a sanitizer or an emulator, and runs the same code as others for longer; `slow_threads` as well,
# but is what the thread sanitizer is for; `host_kernel` asks the kernel for what an emulator does not hand on. Names of
# such cases have no commas: doctest's listing takes them apart there.
# The sources get the tree's test/data as CLOISTER_TEST_DATA, and each program's path as NAME_PROGRAM. Nothing
# is done where tests of this kind are not built.
function(cloister_test name)
  cmake_parse_arguments(arg "LABELLED" "KIND" "SOURCES;LINK;PROGRAMS;PROPERTIES" ${ARGN})
  if(NOT arg_KIND)
    set(arg_KIND robot)
  endif()
  cloister_builds_tests(${arg_KIND} is_built)
  if(NOT is_built)
    return()
  endif()
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE ${arg_LINK} cloister_test_main doctest::doctest)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_compile_definitions(${name} PRIVATE CLOISTER_TEST_DATA="${PROJECT_SOURCE_DIR}/test/data")
  foreach(program ${arg_PROGRAMS})
    string(TOUPPER ${program} variable)
    string(REPLACE "-" "_" variable ${variable})
    cloister_program_path(${program} path)
    target_compile_definitions(${name} PRIVATE ${variable}_PROGRAM="${path}")
    add_dependencies(${name} ${program})
  endforeach()
  cloister_target_defaults(${name})
  # What is tested is in the libraries: a test's own code is compiled in less time.
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  # Tests have helpers of the same names: where sources are compiled several at once, theirs are not.
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests UNITY_BUILD OFF)
  add_dependencies(tests ${name})
  set(labels)
  if(arg_LABELLED)
    set(labels ADD_LABELS 1)  # which its listing reads, as it does not TRUE
  endif()
  doctest_discover_tests(${name} TEST_PREFIX "${name}: " ${labels}
                         PROPERTIES TIMEOUT 900 ${arg_PROPERTIES})
endfunction()
