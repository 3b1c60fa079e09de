include(CMakePackageConfigHelpers)
install(EXPORT slamfuseTargets NAMESPACE slamfuse:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/slamfuse)
configure_package_config_file(cmake/slamfuse-config.cmake.in ${PROJECT_BINARY_DIR}/slamfuse-config.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/slamfuse)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/slamfuse-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/slamfuse-config.cmake ${PROJECT_BINARY_DIR}/slamfuse-config-version.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/slamfuse)
