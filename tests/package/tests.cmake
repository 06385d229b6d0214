# The library as others get it: installed, as a part of their build, as a Debian package. Not when it is watched, as only
# programs that are watched, too, can be linked with that.
if(FOLDPROOF_SANITIZE OR FOLDPROOF_FUZZ)
  return()
endif()
set(WORK ${CMAKE_CURRENT_BINARY_DIR}/package)
set(CONSUMER ${CMAKE_CURRENT_SOURCE_DIR}/package)
set(EXAMPLE_SOURCE ${CMAKE_CURRENT_BINARY_DIR}/readme_example.cpp)
# The version that the documentation asks for, so that it cannot be one that is no longer there.
file(STRINGS ${PROJECT_SOURCE_DIR}/docs/cpp.md DOCUMENTED_VERSION REGEX "^find_package\\(foldproof")
string(REGEX MATCH "[0-9.]+" DOCUMENTED_VERSION "${DOCUMENTED_VERSION}")
set(EXAMPLE_OUTPUT "vertex 3 meets face 0 at 0.600 of the step\n")

add_test(NAME package_install COMMAND ${CMAKE_COMMAND} --install ${PROJECT_BINARY_DIR} --prefix ${WORK}/prefix)
set_tests_properties(package_install PROPERTIES FIXTURES_SETUP installed)

# As a subdirectory the core is built once more; with FetchContent the build is the same, and is configured only.
set(CONSUMER_OPTIONS -DVERSION=${DOCUMENTED_VERSION} -DEXAMPLE=${EXAMPLE_SOURCE} -DFOLDPROOF_SOURCE=${PROJECT_SOURCE_DIR}
  -DFOLDPROOF_THREADS=${FOLDPROOF_THREADS} -DCMAKE_UNITY_BUILD=$CACHE{CMAKE_UNITY_BUILD} -DCMAKE_PREFIX_PATH=${WORK}/prefix
  -DCMAKE_BUILD_TYPE=${CMAKE_BUILD_TYPE} "-DCMAKE_CXX_FLAGS_RELEASE=${CMAKE_CXX_FLAGS_RELEASE}"
  -DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER} -DCMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER})
set(FLAGS_OF_package -DCMAKE_CXX_FLAGS=-ffast-math)  # which Foldproof takes back
foreach(FORM package subdirectory)
  add_test(NAME consumer_${FORM} COMMAND ${CMAKE_CTEST_COMMAND} --build-and-test ${CONSUMER} ${WORK}/${FORM}
    --build-generator ${CMAKE_GENERATOR} --build-options -DFORM=${FORM} ${CONSUMER_OPTIONS} ${FLAGS_OF_${FORM}}
    --test-command consumer)
  set_tests_properties(consumer_${FORM} PROPERTIES PASS_REGULAR_EXPRESSION "${EXAMPLE_OUTPUT}" TIMEOUT 900 PROCESSORS 2
    ENVIRONMENT CMAKE_BUILD_PARALLEL_LEVEL=2)
endforeach()
add_test(NAME consumer_fetch COMMAND ${CMAKE_COMMAND} -S ${CONSUMER} -B ${WORK}/fetch -G ${CMAKE_GENERATOR} -DFORM=fetch
  ${CONSUMER_OPTIONS} -DCMAKE_CXX_FLAGS=-ffast-math)
set_tests_properties(consumer_package PROPERTIES FIXTURES_REQUIRED installed FIXTURES_SETUP consumer)
add_test(NAME consumer_native COMMAND ${WORK}/package/native)
set_tests_properties(consumer_native PROPERTIES FIXTURES_REQUIRED consumer)
# The environment's CMAKE_PREFIX_PATH may say where ipc-toolkit is.
add_test(NAME consumer_ipc_toolkit COMMAND sh -c "\"${CMAKE_COMMAND}\" --build . --target in_ipc_toolkit && ./in_ipc_toolkit"
  WORKING_DIRECTORY ${WORK}/package)
set_tests_properties(consumer_ipc_toolkit PROPERTIES FIXTURES_REQUIRED consumer
  PASS_REGULAR_EXPRESSION "the point may go 0.4 of the way" SKIP_REGULAR_EXPRESSION "no ipc-toolkit is installed")

add_test(NAME consumer_pkg_config COMMAND sh ${CONSUMER}/pkg_config.sh ${CMAKE_CXX_COMPILER} ${EXAMPLE_SOURCE} ${WORK}/prefix)
set_tests_properties(consumer_pkg_config PROPERTIES FIXTURES_REQUIRED installed PASS_REGULAR_EXPRESSION "${EXAMPLE_OUTPUT}")

find_program(DPKG_SHLIBDEPS dpkg-shlibdeps)
if(DPKG_SHLIBDEPS)
  add_test(NAME package_deb COMMAND sh ${CONSUMER}/deb.sh ${CMAKE_CPACK_COMMAND} ${PROJECT_BINARY_DIR} ${WORK}/deb ${FOLDPROOF_THREADS})
  set_tests_properties(package_deb PROPERTIES PASS_REGULAR_EXPRESSION "foldproof ${PROJECT_VERSION}" RUN_SERIAL ON)
endif()
if(STANDALONE)
  add_test(NAME package_standalone COMMAND sh ${CONSUMER}/standalone.sh ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}
    $<TARGET_FILE:foldproof_program> ${WORK}/standalone)
  set_tests_properties(package_standalone PROPERTIES PASS_REGULAR_EXPRESSION "first frame")
endif()
add_custom_target(build_all COMMAND ${CMAKE_COMMAND} --build ${PROJECT_BINARY_DIR})
foldproof_label(package package build_all)
