# Installs oncollide::oncollide, so that find_package(oncollide) works from any prefix.
include(CMakePackageConfigHelpers)

add_library(oncollide INTERFACE)
add_library(oncollide::oncollide ALIAS oncollide)
target_link_libraries(oncollide INTERFACE oncollide_pipeline oncollide_files)
install(TARGETS oncollide EXPORT oncollide)

set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/oncollide)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/oncollideConfig.cmake.in
  ${PROJECT_BINARY_DIR}/oncollideConfig.cmake INSTALL_DESTINATION ${config_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/oncollideConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/oncollideConfig.cmake ${PROJECT_BINARY_DIR}/oncollideConfigVersion.cmake
        DESTINATION ${config_dir})
install(EXPORT oncollide NAMESPACE oncollide:: DESTINATION ${config_dir} FILE oncollideTargets.cmake)
