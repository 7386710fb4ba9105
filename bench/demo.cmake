# The demo, step by step: simulate the built-in house, map it, compare the map with the truth, say where to look.
# Run by the target `demo` with -DBIN=<programs> -DOUT=<directory>.
cmake_minimum_required(VERSION 3.25)

# step(WHAT COMMAND...): runs one program, its output on the terminal, and stops the demo when it fails.
function(step what)
  message(STATUS "demo: ${what}")
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "demo: failed (${status}): ${what}")
  endif()
endfunction()

# The mark is made once the simulator has succeeded: a mission that was cut short is made again.
if(EXISTS ${OUT}/mission.done)
  message(STATUS "demo: the mission is there already: ${OUT}/mission")
else()
  step("simulating a walk through a house of two storeys" ${BIN}/cloister simulate house --out ${OUT}/mission)
  file(TOUCH ${OUT}/mission.done)
endif()
step("mapping it" ${BIN}/cloister replay ${OUT}/mission --out ${OUT}/out)
step("comparing the map with the truth" ${BIN}/cloister-ground-truth ${OUT}/mission ${OUT}/out
     OUTPUT_FILE ${OUT}/out/ground_truth.json)
message(STATUS "demo: open ${OUT}/out/report.html")
message(STATUS "demo: the mesh is ${OUT}/out/mesh.ply")
