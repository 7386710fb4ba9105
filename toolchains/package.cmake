# The Debian package: the program, its services and their settings. What a developer needs (libraries, headers, the
# simulator) is not in it. What the files are for is told in package/DEPLOYMENT.md.
set(package_files ${PROJECT_SOURCE_DIR}/toolchains/package)
set(robot_only COMPONENT robot EXCLUDE_FROM_ALL)
install(FILES ${package_files}/cloister.service ${package_files}/cloister-roudi.service
        DESTINATION lib/systemd/system ${robot_only})
install(FILES ${package_files}/cloister.toml ${package_files}/cyclonedds.xml
              ${PROJECT_SOURCE_DIR}/firmware_interface/dds/roudi.toml
        DESTINATION /etc/cloister ${robot_only})
install(DIRECTORY ${package_files}/spot DESTINATION ${CMAKE_INSTALL_DATADIR}/cloister ${robot_only})
install(FILES ${PROJECT_SOURCE_DIR}/runtime/LIVE.md ${package_files}/DEPLOYMENT.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR} ${robot_only})

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "Cloister's developers")
set(CPACK_INSTALL_CMAKE_PROJECTS ${PROJECT_BINARY_DIR} cloister robot /)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS iceoryx)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${package_files}/conffiles)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
