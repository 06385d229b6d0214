# What is installed, and Debian packages of it (`./dev package`): foldproof, the program; libfoldproof-dev, library and headers.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

if(BUILD_SHARED_LIBS AND TARGET foldproof_app)
  set_target_properties(foldproof_app PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
endif()
if(TARGET foldproof_app)
  install(TARGETS foldproof_app RUNTIME COMPONENT program)
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/foldproof RENAME copyright COMPONENT program)
endif()

# With the program lies a shared library; everything else is for those who build with it.
install(TARGETS foldproof EXPORT foldproof-targets
  LIBRARY COMPONENT program NAMELINK_COMPONENT development
  ARCHIVE COMPONENT development)
file(GLOB HEADERS CONFIGURE_DEPENDS include/foldproof/*.h)
list(FILTER HEADERS EXCLUDE REGEX "/page\\.h$")  # of the program's own library, which is not installed
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

# A static library hands on what it is linked with.
set(LINKED "fmt libhwy libpng libzip tbb zlib")
set(REQUIRES "Requires: eigen3 ${LINKED}")
if(BUILD_SHARED_LIBS)
  set(REQUIRES "Requires: eigen3\nRequires.private: ${LINKED}")
endif()
file(RELATIVE_PATH UP /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(cmake/foldproof.pc.in foldproof.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/foldproof.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

set(CPACK_PACKAGE_NAME foldproof)
set(CPACK_PACKAGE_CONTACT "Foldproof maintainers <maintainers@foldproof.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_GENERATOR DEB)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL development)
if(TARGET foldproof_app)
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
  "libeigen3-dev, libexpected-dev, libfmt-dev, libhwy-dev, libpng-dev, libtbb-dev, libzip-dev, pkgconf, zlib1g-dev")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "The C++ library foldproof and its headers, for CMake and pkg-config.")
if(BUILD_SHARED_LIBS)
  set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
  set(CPACK_COMPONENT_DEVELOPMENT_DEPENDS program)
endif()
include(CPack)
