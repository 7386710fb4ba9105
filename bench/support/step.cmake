# step(WHAT COMMAND...): says what is done, runs one program, its output on the terminal, and stops when it fails.
function(step what)
  message(STATUS "${what}")
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "failed (${status}): ${what}")
  endif()
endfunction()

# simulated(MISSION WORLD OPTIONS...): simulates a mission unless it is there already. The mark is made once the simulator
# has succeeded: a mission that was cut short is made again.
function(simulated mission world)
  if(EXISTS ${mission}.done)
    message(STATUS "the mission is there already: ${mission}")
    return()
  endif()
  file(REMOVE_RECURSE ${mission})
  step("simulating ${world}" ${BIN}/cloister-simulate ${world} --out ${mission} ${ARGN})
  file(TOUCH ${mission}.done)
endfunction()
