# Installs oncollide::oncollide, so that find_package(oncollide) works from any prefix: as static libraries or, with
# BUILD_SHARED_LIBS, as one shared library.
include(CMakePackageConfigHelpers)
set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/oncollide)
set(include_all ${CMAKE_CURRENT_LIST_DIR}/include/all)
install(FILES ${include_all}/oncollide/oncollide.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/oncollide COMPONENT headers)

# Static.
add_library(oncollide INTERFACE)
target_link_libraries(oncollide INTERFACE oncollide_runs oncollide_robots oncollide_files)
target_include_directories(oncollide INTERFACE $<BUILD_INTERFACE:${include_all}>)
# Generated geometry and scenes, for examples and tests.
add_library(oncollide_samples INTERFACE)
set_target_properties(oncollide_samples PROPERTIES EXPORT_NAME samples)
target_link_libraries(oncollide_samples INTERFACE oncollide oncollide_catalogue)
install(TARGETS oncollide oncollide_samples EXPORT oncollide)
install(EXPORT oncollide NAMESPACE oncollide:: DESTINATION ${config_dir} FILE oncollideTargets.cmake ${ONCOLLIDE_STATIC})

# Shared: the objects of all modules. The samples are included because they call hidden functions. The ABI is not stable,
# so each version has a name of its own (docs/stability.md).
list(TRANSFORM ONCOLLIDE_LAYERS PREPEND oncollide_ OUTPUT_VARIABLE modules)
list(TRANSFORM modules REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>" OUTPUT_VARIABLE objects)
add_library(oncollide_shared SHARED ${objects})
set_target_properties(oncollide_shared PROPERTIES OUTPUT_NAME oncollide EXPORT_NAME oncollide LINKER_LANGUAGE CXX
                      VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION})
target_link_libraries(oncollide_shared PUBLIC Eigen3::Eigen PRIVATE ${modules}) # for the libraries that these need
set(exports ${CMAKE_CURRENT_LIST_DIR}/exports.map)
target_link_options(oncollide_shared PRIVATE $<$<NOT:$<PLATFORM_ID:Darwin>>:-Wl,--version-script=${exports}>)
set_property(TARGET oncollide_shared PROPERTY LINK_DEPENDS ${exports})
target_compile_features(oncollide_shared INTERFACE cxx_std_20)
target_compile_definitions(oncollide_shared INTERFACE ${ONCOLLIDE_EIGEN_LAYOUT})
file(GLOB include_trees ${CMAKE_CURRENT_LIST_DIR}/include/*)
target_include_directories(oncollide_shared INTERFACE "$<BUILD_INTERFACE:${include_trees}>"
                           $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
add_library(oncollide_shared_samples INTERFACE)
set_target_properties(oncollide_shared_samples PROPERTIES EXPORT_NAME samples)
target_link_libraries(oncollide_shared_samples INTERFACE oncollide_shared)
target_include_directories(oncollide_shared_samples INTERFACE $<INSTALL_INTERFACE:${ONCOLLIDE_SAMPLES_INCLUDE}>)
install(TARGETS oncollide_shared oncollide_shared_samples EXPORT oncollide_shared LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
        ${ONCOLLIDE_SHARED})
install(EXPORT oncollide_shared NAMESPACE oncollide:: DESTINATION ${config_dir} FILE oncollideSharedTargets.cmake
        ${ONCOLLIDE_SHARED})

if(NOT BUILD_SHARED_LIBS AND NOT ONCOLLIDE_TESTS) # the tests use both variants
  set_target_properties(oncollide_shared PROPERTIES EXCLUDE_FROM_ALL ON)
endif()
if(BUILD_SHARED_LIBS)
  add_library(oncollide::oncollide ALIAS oncollide_shared)
  add_library(oncollide::samples ALIAS oncollide_shared_samples)
else()
  add_library(oncollide::oncollide ALIAS oncollide)
  add_library(oncollide::samples ALIAS oncollide_samples)
endif()

# The shared library's package finds Eigen alone.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/oncollideConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/oncollideConfigVersion.cmake DESTINATION ${config_dir} COMPONENT headers)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/oncollideConfig.cmake.in
  ${PROJECT_BINARY_DIR}/oncollideConfig.cmake INSTALL_DESTINATION ${config_dir})
install(FILES ${PROJECT_BINARY_DIR}/oncollideConfig.cmake DESTINATION ${config_dir} ${ONCOLLIDE_STATIC})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/oncollideSharedConfig.cmake.in
  ${PROJECT_BINARY_DIR}/shared/oncollideConfig.cmake INSTALL_DESTINATION ${config_dir})
install(FILES ${PROJECT_BINARY_DIR}/shared/oncollideConfig.cmake DESTINATION ${config_dir} ${ONCOLLIDE_SHARED})
