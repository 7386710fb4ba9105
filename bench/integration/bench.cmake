# Every world from its simulation to the plot. Run by the target `bench-integration` with
#   -DBIN=<programs> -DWORK=<directory for missions> -DRESULTS=<directory of the results> -DTREE=<source tree>
# and, to change what it does, -DWORLDS=<list> -DMINUTES=<length of each mission> -DOCTOMAP_SECONDS=<CPU time for OctoMap
# on each mission>.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/../support/step.cmake)

if(NOT WORLDS)
  set(WORLDS house small-rooms three-storey campus)
endif()
if(NOT MINUTES)
  set(MINUTES 1)
endif()
if(NOT OCTOMAP_SECONDS)
  set(OCTOMAP_SECONDS 60)
endif()

# What is measured is what is in the tree now, not what was there when it was configured.
execute_process(COMMAND git describe --always --dirty --exclude=* WORKING_DIRECTORY ${TREE}
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT commit)
  set(commit unknown)
endif()

# Results become those of the tree only when all of them are there.
file(MAKE_DIRECTORY ${WORK} ${RESULTS})
file(REMOVE ${WORK}/integration.csv)
foreach(world IN LISTS WORLDS)
  set(mission ${WORK}/${world}_${MINUTES}min)
  simulated(${mission} ${world} --minutes ${MINUTES})
  step("integrating ${world}" ${BIN}/cloister-bench-integration ${mission} --octomap-seconds ${OCTOMAP_SECONDS}
       --commit ${commit} --out ${WORK}/integration.csv --scans-csv ${WORK}/${world}.scans.csv)
endforeach()
step("drawing the plot" ${BIN}/cloister-bench-plot ${WORK}/integration.csv --out ${WORK}/integration.svg)
file(COPY ${WORK}/integration.csv ${WORK}/integration.svg DESTINATION ${RESULTS})
message(STATUS "bench: ${RESULTS}/integration.csv and ${RESULTS}/integration.svg")
