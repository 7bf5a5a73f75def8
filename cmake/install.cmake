# cmake --install: headers, libraries, programs, and scree-config.cmake, which gives find_package(scree) its targets.
include(CMakePackageConfigHelpers)

set(SCREE_INSTALLED_LIBRARIES "")
foreach(target scree_runtime scree_threads scree_draco scree_bake)
  if(TARGET ${target})
    list(APPEND SCREE_INSTALLED_LIBRARIES ${target})
  endif()
endforeach()
# Before 1.0 a minor version may break the API.
set_target_properties(${SCREE_INSTALLED_LIBRARIES} PROPERTIES VERSION ${PROJECT_VERSION}
  SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
install(TARGETS ${SCREE_INSTALLED_LIBRARIES} EXPORT scree-targets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY include/scree DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
foreach(program scree-bake scree-info scree-scatter scree-view)
  if(TARGET ${program})
    install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  endif()
endforeach()

set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/scree)
install(EXPORT scree-targets NAMESPACE scree:: DESTINATION ${config_dir})
configure_package_config_file(cmake/scree-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/scree-config.cmake
  INSTALL_DESTINATION ${config_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/scree-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/scree-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/scree-config-version.cmake
  DESTINATION ${config_dir})
