# The demo, step by step: simulate the built-in house, map it, compare the map with the truth, say where to look.
# Run by the target `demo` with -DBIN=<programs> -DOUT=<directory>.
cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/support/step.cmake)

simulated(${OUT}/mission house)
step("mapping it" ${BIN}/cloister replay ${OUT}/mission --out ${OUT}/out)
step("comparing the map with the truth" ${BIN}/cloister-ground-truth ${OUT}/mission ${OUT}/out
     OUTPUT_FILE ${OUT}/out/ground_truth.json)
message(STATUS "demo: open ${OUT}/out/report.html")
message(STATUS "demo: the mesh is ${OUT}/out/mesh.ply")
