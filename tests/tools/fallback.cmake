# A build has one fallback for machines without vectors: Highway's plain scalar code or its imitation of vectors, as the
# compiler has it. The other one is built into test programs of its own, test_<module>_fallback: its objects stand before
# the library, whose members with the same functions the linker then leaves alone. A shared library has no members.
if(BUILD_SHARED_LIBS)
  return()
endif()

include(CheckCXXSourceCompiles)
set(CMAKE_REQUIRED_QUIET ON)
check_cxx_source_compiles("#include <hwy/detect_targets.h>
#if HWY_STATIC_TARGET == HWY_SCALAR
#error
#endif
int main() {}" FOLDPROOF_LACKS_SCALAR)
set(FALLBACK HWY_COMPILE_ONLY_SCALAR)
if(NOT FOLDPROOF_LACKS_SCALAR)
  set(FALLBACK HWY_COMPILE_ONLY_EMU128 HWY_BROKEN_EMU128=0)
endif()

file(GLOB_RECURSE SOURCES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/*.cpp)
foldproof_once_per_set(FALLBACK_SOURCES ${SOURCES})
add_library(foldproof_fallback OBJECT ${FALLBACK_SOURCES} ${CMAKE_CURRENT_SOURCE_DIR}/arithmetic/ops.cpp
  ${CMAKE_CURRENT_SOURCE_DIR}/certificate/inside.cpp)
target_include_directories(foldproof_fallback PRIVATE ${PROJECT_SOURCE_DIR}/src ${CMAKE_CURRENT_SOURCE_DIR})
target_compile_definitions(foldproof_fallback PRIVATE ${FALLBACK})
target_link_libraries(foldproof_fallback PRIVATE foldproof_model foldproof_threads)

# FILTER: the tests that depend on instruction sets.
function(foldproof_fallback_tests MODULE FILTER)
  add_executable(test_${MODULE}_fallback $<TARGET_OBJECTS:foldproof_fallback>
    $<FILTER:$<FILTER:$<TARGET_OBJECTS:test_${MODULE}>,EXCLUDE,/ops\\.cpp>,EXCLUDE,/inside\\.cpp>)
  target_link_libraries(test_${MODULE}_fallback PRIVATE foldproof_model fmt::fmt GTest::gmock GTest::gtest_main hwy ${ARGN})
  foldproof_discover(test_${MODULE}_fallback ${MODULE}_fallback quick ${FILTER} TEST_PREFIX fallback/)
  # That it is in use, and alone; and that its answers are those of the other instruction sets.
  add_test(NAME fallback/${MODULE}_agrees COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM} -DPROGRAM=$<TARGET_FILE:test_${MODULE}>
    -DFALLBACK=$<TARGET_FILE:test_${MODULE}_fallback> -P ${CMAKE_CURRENT_SOURCE_DIR}/tools/same_answers.cmake)
  foldproof_label(${MODULE}_fallback quick test_${MODULE})
endfunction()

foldproof_fallback_tests(arithmetic * foldproof_oracle foldproof_threads)
foldproof_fallback_tests(bvh *:-Hierarchy* foldproof_oracle)
foldproof_fallback_tests(ccd ConservativeAdvancement* foldproof_oracle CGAL::CGAL)
foldproof_fallback_tests(certificate *InstructionSets*:*Plane* foldproof_oracle foldproof_threads)
foldproof_heavy_test(fallback/arithmetic_of_all_floats arithmetic_fallback ${CMAKE_COMMAND} -E env FOLDPROOF_ALL_FLOATS=1
  $<TARGET_FILE:test_arithmetic_fallback>)
