# The arrows between the rooms, read off the #include lines. cmake -DTREE=<source tree> -P check.cmake
cmake_minimum_required(VERSION 3.25)

set(violations "")

# forbid(FILES <regex of paths> INCLUDES <regex of what is between the quotes or brackets> [EXCEPT <regex of paths>]
#        BECAUSE <reason>)
function(forbid)
  cmake_parse_arguments(arg "" "FILES;INCLUDES;EXCEPT;BECAUSE" "" ${ARGN})
  foreach(file IN LISTS sources)
    if(NOT file MATCHES "${arg_FILES}" OR (arg_EXCEPT AND file MATCHES "${arg_EXCEPT}"))
      continue()
    endif()
    file(STRINGS ${TREE}/${file} lines REGEX "^[ \t]*#[ \t]*include")
    foreach(line IN LISTS lines)
      if(line MATCHES "[<\"](${arg_INCLUDES})")
        string(APPEND violations "  ${file}: ${line}: ${arg_BECAUSE}\n")
      endif()
    endforeach()
  endforeach()
  set(violations "${violations}" PARENT_SCOPE)
endfunction()

set(sources "")
foreach(room mapping firmware_interface runtime bench test)
  file(GLOB_RECURSE found RELATIVE ${TREE} ${TREE}/${room}/*.hpp ${TREE}/${room}/*.cpp)
  list(APPEND sources ${found})
endforeach()
list(LENGTH sources num_sources)
if(num_sources LESS 100)
  message(FATAL_ERROR "layering: only ${num_sources} sources below ${TREE}")
endif()

forbid(FILES "^mapping/" INCLUDES "runtime/|firmware_interface/"
       BECAUSE "mapping/ knows nobody")
forbid(FILES "^mapping/" EXCEPT "_test\\.cpp$"
       INCLUDES "(thread|mutex|shared_mutex|condition_variable|atomic|future|chrono|fstream|iostream|filesystem)>|sys/|unistd|netinet/|arpa/|fcntl|(oneapi/)?tbb/|boost/lockfree|dds/|pcap|stdio\\.h|cstdio>"
       BECAUSE "mapping/ has no thread, clock, file or socket")
forbid(FILES "^runtime/" EXCEPT "^runtime/app/" INCLUDES "firmware_interface/"
       BECAUSE "only the program sees both neighbours")
forbid(FILES "^firmware_interface/" INCLUDES "runtime/"
       BECAUSE "the sensor side does not know who calls it")
forbid(FILES "^firmware_interface/" EXCEPT "_test\\.cpp$" INCLUDES "thread>"
       BECAUSE "the sensor side starts no thread")
forbid(FILES "^(mapping|firmware_interface|runtime)/" INCLUDES "bench/"
       BECAUSE "nothing outside includes bench/")
forbid(FILES "^(mapping|firmware_interface|runtime|bench)/" EXCEPT "_test\\.cpp$" INCLUDES "test/"
       BECAUSE "only tests include test/")
forbid(FILES "^bench/simulate/" INCLUDES "firmware_interface/|runtime/"
       BECAUSE "the simulator shares nothing with the decoder it tests")
forbid(FILES "." EXCEPT "^mapping/overlap/convex_overlap\\.cpp$" INCLUDES "ccd/"
       BECAUSE "libccd has one door, mapping/overlap/convex_overlap.cpp")

if(violations)
  message(FATAL_ERROR "layering: includes against the arrows:\n${violations}")
endif()
message(STATUS "layering: ${num_sources} sources keep to the arrows")
