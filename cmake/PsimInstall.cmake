# cmake --install: the library, its public headers, find_package(psim) and pkg-config.
# Scene reading (psim/scene.h) belongs to the programs and is not part of the library.
include(CMakePackageConfigHelpers)

set(_config_dir "${CMAKE_INSTALL_LIBDIR}/cmake/psim")

install(TARGETS psim_core EXPORT psimTargets
  ARCHIVE COMPONENT psim_library
  LIBRARY COMPONENT psim_library
  RUNTIME COMPONENT psim_library)
install(DIRECTORY include/psim DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT psim_library
  FILES_MATCHING PATTERN "*.h" PATTERN "scene.h" EXCLUDE)
install(EXPORT psimTargets NAMESPACE psim:: DESTINATION "${_config_dir}" COMPONENT psim_library)

# A static libpsim leaves cpu_features and threads for its user to link; a shared one holds them.
if(BUILD_SHARED_LIBS)
  set(PSIM_CONFIG_DEPENDENCIES "")
  set(PSIM_PC_LIBS "")
else()
  set(PSIM_CONFIG_DEPENDENCIES
      "include(CMakeFindDependencyMacro)\nfind_dependency(Threads)\nfind_dependency(CpuFeatures CONFIG)\n")
  set(PSIM_PC_LIBS " -lcpu_features -pthread")
endif()

configure_package_config_file(cmake/psimConfig.cmake.in "${PROJECT_BINARY_DIR}/psimConfig.cmake"
  INSTALL_DESTINATION "${_config_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/psimConfigVersion.cmake"
  VERSION ${PROJECT_VERSION} COMPATIBILITY SameMajorVersion)
install(FILES "${PROJECT_BINARY_DIR}/psimConfig.cmake" "${PROJECT_BINARY_DIR}/psimConfigVersion.cmake"
  DESTINATION "${_config_dir}" COMPONENT psim_library)

# The .pc file finds its prefix from its own place, so that an installation may be moved.
file(RELATIVE_PATH PSIM_PC_PREFIX
  "${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig" "${CMAKE_INSTALL_PREFIX}")
configure_file(cmake/psim.pc.in "${PROJECT_BINARY_DIR}/psim.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/psim.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig"
  COMPONENT psim_library)
