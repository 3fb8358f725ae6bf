# cmake --install: both libraries, the public headers, find_package(psim) and pkg-config.
# Scene reading (psim/scene.h) belongs to the programs and is not part of the library.
include(CMakePackageConfigHelpers)

set(_config_dir "${CMAKE_INSTALL_LIBDIR}/cmake/psim")

# Two exports: who links the shared library needs nothing else, who links the static one needs
# cpu_features and threads.
install(TARGETS psim_core EXPORT psimStaticTargets ARCHIVE COMPONENT psim_library)
install(EXPORT psimStaticTargets NAMESPACE psim:: DESTINATION "${_config_dir}"
  COMPONENT psim_library)
if(TARGET psim_shared)
  install(TARGETS psim_shared EXPORT psimSharedTargets
    LIBRARY COMPONENT psim_library NAMELINK_COMPONENT psim_library
    RUNTIME COMPONENT psim_library ARCHIVE COMPONENT psim_library)
  install(EXPORT psimSharedTargets NAMESPACE psim:: DESTINATION "${_config_dir}"
    COMPONENT psim_library)
endif()

install(DIRECTORY include/psim DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT psim_library
  FILES_MATCHING PATTERN "*.h" PATTERN "scene.h" EXCLUDE)
install(FILES include/psim.h DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT psim_library)

configure_package_config_file(cmake/psimConfig.cmake.in "${PROJECT_BINARY_DIR}/psimConfig.cmake"
  INSTALL_DESTINATION "${_config_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/psimConfigVersion.cmake"
  VERSION ${PROJECT_VERSION} COMPATIBILITY ${PSIM_COMPATIBILITY})
install(FILES "${PROJECT_BINARY_DIR}/psimConfig.cmake" "${PROJECT_BINARY_DIR}/psimConfigVersion.cmake"
  DESTINATION "${_config_dir}" COMPONENT psim_library)

# pkg-config --libs links libpsim.so, pkg-config --static --libs names what libpsim.a needs. Where
# there is only libpsim.a everybody needs it. The file finds its prefix from its own place, so that
# an installation may be moved.
set(_static_libs "-lstdc++ -lm -pthread")
if(PSIM_CPU_FEATURES)
  string(PREPEND _static_libs "-lcpu_features ")
endif()
if(TARGET psim_shared)
  set(PSIM_PC_LIBS "")
  set(PSIM_PC_LIBS_PRIVATE "${_static_libs}")
else()
  set(PSIM_PC_LIBS " ${_static_libs}")
  set(PSIM_PC_LIBS_PRIVATE "")
endif()
file(RELATIVE_PATH PSIM_PC_PREFIX
  "${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig" "${CMAKE_INSTALL_PREFIX}")
configure_file(cmake/psim.pc.in "${PROJECT_BINARY_DIR}/psim.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/psim.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig"
  COMPONENT psim_library)
