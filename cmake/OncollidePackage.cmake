# Installs the files other than library and command: pkg-config, man pages, completion. Also makes packages with cpack.
# pkg-config: the libraries are static, so their dependencies are listed.
set(pc_requires " libpng")
list(TRANSFORM CMAKE_DL_LIBS PREPEND "-l" OUTPUT_VARIABLE dl)
set(pc_libs " -lqhull_r -pthread ${dl}")
if(ONCOLLIDE_GL)
  string(APPEND pc_requires " epoxy")
  string(APPEND pc_libs " -lmeshoptimizer")
endif()
if(ONCOLLIDE_FCL)
  string(APPEND pc_libs " -lfcl -lccd") # fcl.pc would set the language's standard
endif()
if(ONCOLLIDE_OCTOMAP)
  string(APPEND pc_libs " -loctomap -loctomath")
endif()
if(ONCOLLIDE_HDF5)
  string(APPEND pc_requires " zlib")
endif()
if(ONCOLLIDE_XML)
  string(APPEND pc_requires " expat libzip")
endif()
if(ONCOLLIDE_OPENMP)
  string(APPEND pc_libs " ${OpenMP_CXX_FLAGS}")
endif()
file(RELATIVE_PATH up_to_prefix /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
# Compilers take a folder that is given by -I and -isystem for one of the system, whose headers give no warnings.
get_target_property(pc_eigen Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
set(pc_libdir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
set(pc_libraries "-loncollide_runs -loncollide_pipeline -loncollide_narrowphase -loncollide_broadphase -loncollide_files -loncollide_scenes -loncollide_base${pc_libs}")
set(pc_requires " fmt${pc_requires}")
set(pc_samples "-L\${libdir} -loncollide_catalogue -loncollide_generators")
set(pc_folder ${PROJECT_BINARY_DIR})
foreach(variant IN ITEMS STATIC SHARED) # the shared library is linked with its dependencies, and contains the samples
  configure_file(${CMAKE_CURRENT_LIST_DIR}/oncollide.pc.in ${pc_folder}/oncollide.pc @ONLY)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/oncollide-samples.pc.in ${pc_folder}/oncollide-samples.pc @ONLY)
  install(FILES ${pc_folder}/oncollide.pc ${pc_folder}/oncollide-samples.pc DESTINATION ${pc_libdir} ${ONCOLLIDE_${variant}})
  set(pc_libraries -loncollide)
  set(pc_requires)
  set(pc_samples)
  set(pc_folder ${PROJECT_BINARY_DIR}/shared)
endforeach()

if(NOT ONCOLLIDE_TOOLS OR (CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR))
  return()
endif()
set(references ${PROJECT_BINARY_DIR}/references) # generated from the command's options
add_custom_command(OUTPUT ${references}/made
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${references}
  COMMAND ${CMAKE_COMMAND} -E make_directory ${references}/man
  COMMAND oncollide_tool reference man --out ${references}/man
  COMMAND oncollide_tool reference bash --out ${references}/oncollide
  COMMAND oncollide_tool reference zsh --out ${references}/_oncollide
  COMMAND oncollide_tool reference fish --out ${references}/oncollide.fish
  COMMAND ${CMAKE_COMMAND} -E touch ${references}/made
  DEPENDS oncollide_tool VERBATIM)
add_custom_target(oncollide_references ALL DEPENDS ${references}/made)
install(DIRECTORY ${references}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${references}/oncollide DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${references}/_oncollide DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
install(FILES ${references}/oncollide.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

if(NOT PROJECT_IS_TOP_LEVEL)
  return()
endif()
set(CPACK_GENERATOR TGZ DEB)
set(CPACK_PACKAGE_VENDOR oncollide)
set(CPACK_PACKAGE_CONTACT "The maintainers of oncollide <maintainers@oncollide.invalid>")
set(CPACK_PACKAGE_FILE_NAME oncollide-${PROJECT_VERSION}-linux-${CMAKE_SYSTEM_PROCESSOR})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libegl1, libgl1-mesa-dri, libopengl0, libjs-three")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libhdf5-103-1, libgdal32, libeigen3-dev, libexpat1-dev, libpng-dev, libzip-dev, libfmt-dev, nlohmann-json3-dev, libqhull-dev, libmeshoptimizer-dev, libfcl-dev, libccd-dev, liboctomap-dev, libepoxy-dev")
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/packaging/bundle.cmake)
include(CPack)
