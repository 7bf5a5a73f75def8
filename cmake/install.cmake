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
# A prefix that the system does not search: the libraries lie side by side, and the programs find them from where they are.
if(BUILD_SHARED_LIBS AND UNIX AND NOT APPLE)
  file(RELATIVE_PATH to_libraries "/${CMAKE_INSTALL_BINDIR}" "/${CMAKE_INSTALL_LIBDIR}")
  set_target_properties(${SCREE_INSTALLED_LIBRARIES} PROPERTIES INSTALL_RPATH "$ORIGIN")
  foreach(program scree-bake scree-info scree-scatter scree-view)
    if(TARGET ${program})
      set_target_properties(${program} PROPERTIES INSTALL_RPATH "$ORIGIN/${to_libraries}")
    endif()
  endforeach()
endif()
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

# The same for pkg-config: scree-runtime.pc and so on. What a static library needs goes to whoever links it.
# scree_pkg_config(NAME DESCRIPTION REQUIRES STATIC-REQUIRES STATIC-LIBRARIES)
function(scree_pkg_config PC_NAME PC_DESCRIPTION PC_REQUIRES static_requires static_libraries)
  if(NOT TARGET scree_${PC_NAME})
    return()
  endif()
  set(PC_LIBS "")
  if(NOT BUILD_SHARED_LIBS)
    string(APPEND PC_REQUIRES " ${static_requires}")
    set(PC_LIBS "${static_libraries}")
  endif()
  foreach(dir LIBDIR INCLUDEDIR)
    set(PC_${dir} "\${prefix}/${CMAKE_INSTALL_${dir}}")
    if(IS_ABSOLUTE "${CMAKE_INSTALL_${dir}}")
      set(PC_${dir} "${CMAKE_INSTALL_${dir}}")
    endif()
  endforeach()
  # `cmake --install --prefix` is not known yet: pkg-config finds the prefix from where the file lies.
  file(RELATIVE_PATH up "/x/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/x")
  set(CMAKE_INSTALL_PREFIX "\${pcfiledir}/${up}")
  string(REGEX REPLACE "/$" "" CMAKE_INSTALL_PREFIX "${CMAKE_INSTALL_PREFIX}")
  configure_file(cmake/scree.pc.in ${CMAKE_CURRENT_BINARY_DIR}/scree-${PC_NAME}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/scree-${PC_NAME}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()
scree_pkg_config(runtime "Rock for games: packs, queries, scenes, streams" "" "" "-lm")
scree_pkg_config(threads "A pool of threads for scree" scree-runtime "" "-pthread")
scree_pkg_config(draco "Finer meshes of scree's packs" scree-runtime draco "-lstdc++")
if(SCREE_DRACO)
  scree_pkg_config(bake "The baker of scree's packs" scree-runtime "libcjson draco" "-lstdc++ -lm")
else()
  scree_pkg_config(bake "The baker of scree's packs" scree-runtime libcjson "-lm")
endif()
