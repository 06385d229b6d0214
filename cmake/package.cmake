# What is installed, and Debian packages of it (the target `package`): foldproof, the program; libfoldproof-dev, library and headers.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

if(BUILD_SHARED_LIBS AND TARGET foldproof_program)
  set_target_properties(foldproof_program PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
endif()
if(TARGET foldproof_program)
  install(TARGETS foldproof_program RUNTIME COMPONENT program)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/share/ DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT program)
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/foldproof RENAME copyright COMPONENT program)
endif()

# What Blender installs. All times in it are one, so that the same sources make the same file.
file(GLOB ADDON CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}/blender blender/foldproof_addon/*.py)
list(TRANSFORM ADDON PREPEND ${PROJECT_SOURCE_DIR}/blender/ OUTPUT_VARIABLE ADDON_FILES)
add_custom_command(OUTPUT foldproof_addon.zip DEPENDS ${ADDON_FILES} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}/blender
  COMMAND ${CMAKE_COMMAND} -E tar cf ${PROJECT_BINARY_DIR}/foldproof_addon.zip --format=zip --mtime=2000-01-01 ${ADDON})
add_custom_target(blender_addon ALL DEPENDS ${PROJECT_BINARY_DIR}/foldproof_addon.zip)

# A page per header, with its example. What Doxygen warns of is an error.
add_custom_target(docs WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} COMMENT "Writing out/docs"
  COMMAND ${CMAKE_COMMAND} -E make_directory out COMMAND doxygen docs/Doxyfile)

# With the program lies a shared library; everything else is for those who build with it.
set(LIBRARIES foldproof foldproof_io foldproof_model)
install(TARGETS ${LIBRARIES} EXPORT foldproof-targets
  LIBRARY COMPONENT program NAMELINK_COMPONENT development
  ARCHIVE COMPONENT development)
file(GLOB HEADERS CONFIGURE_DEPENDS include/foldproof/*.h)
install(FILES ${HEADERS} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/foldproof COMPONENT development)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libfoldproof-dev RENAME copyright COMPONENT development)

set(SHARED FALSE)
if(BUILD_SHARED_LIBS)
  set(SHARED TRUE)
endif()
set(CONFIG_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/foldproof)
install(EXPORT foldproof-targets NAMESPACE foldproof:: DESTINATION ${CONFIG_DIR} COMPONENT development)
configure_package_config_file(cmake/foldproof-config.cmake.in foldproof-config.cmake INSTALL_DESTINATION ${CONFIG_DIR})
write_basic_package_version_file(foldproof-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/foldproof-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/foldproof-config-version.cmake
  DESTINATION ${CONFIG_DIR} COMPONENT development)

# pkg_config_file(NAME DESCRIPTION REQUIRED LINKED [FLAGS]): `LINKED`, what a static library hands on.
file(RELATIVE_PATH UP /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
function(pkg_config_file NAME DESCRIPTION REQUIRED LINKED)
  set(THREAD_FLAG)
  set(FLAGS "${ARGN}")
  if(BUILD_SHARED_LIBS)
    set(REQUIRES "Requires: ${REQUIRED}\nRequires.private: ${LINKED}")
  else()
    set(REQUIRES "Requires: ${REQUIRED} ${LINKED}")
    if(FOLDPROOF_THREADS STREQUAL "std")
      set(THREAD_FLAG " -pthread")
    endif()
  endif()
  configure_file(cmake/foldproof.pc.in ${NAME}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${NAME}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
endfunction()
set(LINKED "fmt libhwy")
if(FOLDPROOF_THREADS STREQUAL "tbb")
  string(APPEND LINKED " tbb")
endif()
pkg_config_file(foldproof "${PROJECT_DESCRIPTION}" "" "${LINKED}")
pkg_config_file(foldproof_io "Files of meshes and motions, for Foldproof" "foldproof = ${PROJECT_VERSION}" "libzip pugixml zlib")
pkg_config_file(foldproof_model "Models learned from example poses, for Foldproof" "foldproof_io = ${PROJECT_VERSION} eigen3" ""
  " -DEIGEN_MAX_ALIGN_BYTES=64")

set(CPACK_PACKAGE_NAME foldproof)
set(CPACK_PACKAGE_CONTACT "Foldproof maintainers <maintainers@foldproof.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_GENERATOR DEB)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL development)
if(TARGET foldproof_program)
  list(PREPEND CPACK_COMPONENTS_ALL program)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME foldproof)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION graphics)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "The program foldproof: checks, trains, predicts and draws.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libfoldproof-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libeigen3-dev, libexpected-dev, libfmt-dev, libhwy-dev, libpugixml-dev, libzip-dev, pkgconf, zlib1g-dev")
if(FOLDPROOF_THREADS STREQUAL "tbb")
  string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", libtbb-dev")
endif()
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "The C++ library foldproof and its headers, for CMake and pkg-config.")
if(BUILD_SHARED_LIBS)
  set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
  set(CPACK_COMPONENT_DEVELOPMENT_DEPENDS program)
endif()
include(CPack)
