# The engine alone, meshgauge::engine; docs/packaging.md says how this port was tried. SHA512 is that of the tag's archive, which
# vcpkg prints when it differs.
vcpkg_from_github(
  OUT_SOURCE_PATH SOURCE_PATH
  REPO OWNER/meshgauge
  REF "v${VERSION}"
  SHA512 0)
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS -DMESHGAUGE_BUILD_SERVICE=OFF -DMESHGAUGE_BUILD_TESTS=OFF -DMESHGAUGE_WERROR=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/meshgauge)
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
