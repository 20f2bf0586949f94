# What `cmake --install` leaves for an engine: two libraries of which it links one, static or shared as BUILD_SHARED_LIBS says, the public
# headers, and a CMake package. Component coppice_runtime.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS coppice coppice_vulkan EXPORT coppice
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT coppice_runtime
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT coppice_runtime
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT coppice_runtime)
# What engines' shaders include.
install(FILES include/coppice/coppice_surface.glsl DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/coppice COMPONENT coppice_runtime)

set(coppice_package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/coppice)
install(EXPORT coppice NAMESPACE coppice:: FILE coppice-targets.cmake
  DESTINATION ${coppice_package_folder} COMPONENT coppice_runtime)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/coppice-config.cmake.in coppice-config.cmake
  INSTALL_DESTINATION ${coppice_package_folder})
write_basic_package_version_file(coppice-config-version.cmake VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/coppice-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/coppice-config-version.cmake
  DESTINATION ${coppice_package_folder} COMPONENT coppice_runtime)
