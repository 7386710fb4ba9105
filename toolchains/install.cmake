# What `cmake --install` puts in place: programs, libraries, headers and the CMake package `cloister`. The tools of
# bench/ install themselves.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/cloister)

install(TARGETS cloister RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT robot)
install(TARGETS cloister_mapping cloister_firmware_interface cloister_runtime EXPORT cloisterTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})

# Headers keep their folders below include/cloister, so that they are included as in the tree. The program's own
# headers and those of tests and fuzzers stay here.
install(DIRECTORY mapping firmware_interface runtime DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cloister
        FILES_MATCHING PATTERN "*.hpp"
        PATTERN "app" EXCLUDE PATTERN "fuzz" EXCLUDE
        PATTERN "test_*.hpp" EXCLUDE PATTERN "*_for_tests.hpp" EXCLUDE)

install(EXPORT cloisterTargets NAMESPACE cloister:: DESTINATION ${package_dir})
configure_package_config_file(toolchains/cloisterConfig.cmake.in ${PROJECT_BINARY_DIR}/cloisterConfig.cmake
                              INSTALL_DESTINATION ${package_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cloisterConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/cloisterConfig.cmake ${PROJECT_BINARY_DIR}/cloisterConfigVersion.cmake
        DESTINATION ${package_dir})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT robot)
