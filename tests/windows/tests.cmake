# What runs in Wine. Left out: tests that need CGAL (its exact numbers need GMP), that watch memory or processes by what Windows
# has otherwise, and those of what is not offered there.
set(FOLDPROOF_NOT_ON_WINDOWS "/(static_agreement|static_predicates|hostile_test|linear_test|locale_test|new_directory_test|pipe_test|real_data_test|writer_test)\\.cpp$")
find_package(nlohmann_json REQUIRED)
find_package(ZLIB REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(FOLDPROOF_HWY REQUIRED IMPORTED_TARGET libhwy)
pkg_check_modules(FOLDPROOF_LIBZIP REQUIRED IMPORTED_TARGET libzip)
link_libraries(PkgConfig::FOLDPROOF_HWY)
foldproof_module_tests(base foldproof nlohmann_json::nlohmann_json)  # first, as the others use its precompiled header
foldproof_module_tests(platforms foldproof foldproof_oracle)  # answers whose hashes are stored, the same on every system
foldproof_module_tests(arithmetic foldproof_model foldproof_oracle)
foldproof_module_tests(mesh foldproof)
foldproof_module_tests(ccd foldproof foldproof_oracle)
foldproof_module_tests(bvh foldproof foldproof_oracle)
foldproof_module_tests(certificate foldproof foldproof_oracle)
foldproof_module_tests(check foldproof foldproof_oracle)
foldproof_module_tests(filters foldproof foldproof_oracle)
foldproof_module_tests(solver foldproof foldproof_oracle)
foldproof_module_tests(contacts foldproof foldproof_oracle)
target_sources(test_contacts PRIVATE check/animations.cpp)
foldproof_module_tests(io foldproof_io PkgConfig::FOLDPROOF_LIBZIP ZLIB::ZLIB)
foldproof_module_tests(system foldproof_io)
add_custom_target(windows_tests DEPENDS test_base test_platforms test_arithmetic test_mesh test_ccd test_bvh test_certificate
  test_check test_filters test_solver test_contacts test_io test_system test_oracle)

# The program's answers, to what the one in build/ answers here.
set(FOLDPROOF_BUILT ${PROJECT_SOURCE_DIR}/build/foldproof CACHE FILEPATH "The program, built for this machine")
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_test(NAME program_in_wine COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/program_test.py ${FOLDPROOF_BUILT}
  ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:foldproof_program>)
set_tests_properties(program_in_wine PROPERTIES TIMEOUT 1800)

# First of all tests Wine makes its home and starts its services, which keep open whatever the program that starts them writes to.
get_property(TESTS DIRECTORY PROPERTY TESTS)
set_tests_properties(${TESTS} PROPERTIES FIXTURES_REQUIRED wine)
add_test(NAME wine_starts COMMAND sh -c "\"$@\" >/dev/null 2>&1" sh ${CMAKE_CROSSCOMPILING_EMULATOR} wineboot)
set_tests_properties(wine_starts PROPERTIES FIXTURES_SETUP wine)
foldproof_label(windows quick foldproof_program)
