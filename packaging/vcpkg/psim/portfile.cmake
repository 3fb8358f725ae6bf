# The library alone. PSIM_ARCHIVE names a local archive of the sources.
if(NOT EXISTS "$ENV{PSIM_ARCHIVE}")
  message(FATAL_ERROR "psim: PSIM_ARCHIVE must name an archive of the sources (packaging/README.md)")
endif()
vcpkg_extract_source_archive(SOURCE_PATH ARCHIVE "$ENV{PSIM_ARCHIVE}")

# The static library or the shared one, as the triplet says.
string(COMPARE EQUAL "${VCPKG_LIBRARY_LINKAGE}" "dynamic" PSIM_SHARED)
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS
    -DPSIM_BUILD_PROGRAMS=OFF
    -DPSIM_BUILD_BENCH=OFF
    -DPSIM_BUILD_TESTS=OFF
    -DPSIM_BUILD_SHARED=${PSIM_SHARED}
)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/psim)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
