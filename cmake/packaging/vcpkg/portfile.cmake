# An overlay port that builds this source tree: vcpkg install oncollide --overlay-ports=cmake/packaging/vcpkg
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
vcpkg_check_features(OUT_FEATURE_OPTIONS FEATURE_OPTIONS FEATURES fcl ONCOLLIDE_FCL octomap ONCOLLIDE_OCTOMAP gl ONCOLLIDE_GL)
vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}" OPTIONS ${FEATURE_OPTIONS}
  -DONCOLLIDE_TOOLS=OFF -DONCOLLIDE_TESTS=OFF -DONCOLLIDE_PYTHON=OFF -DONCOLLIDE_GDAL=OFF -DONCOLLIDE_HDF5=OFF -DONCOLLIDE_XML=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(PACKAGE_NAME oncollide CONFIG_PATH lib/cmake/oncollide)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
