# Format, layers, proofs, and tests of the programs in tools/.
# Other versions of clang-format format otherwise.
find_program(CLANG_FORMAT clang-format-14)
if(CLANG_FORMAT)
  add_test(NAME format WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
    COMMAND sh -c "git ls-files -z '*.h' '*.cpp' | xargs -0 ${CLANG_FORMAT} --dry-run -Werror")
endif()

add_test(NAME layers COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/tools/check_layers)
add_test(NAME layers_are_checked COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/check_layers_test.py)

add_test(NAME bench_against_limits
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/bench_against_test.py)
add_test(NAME bench_tables_are_made
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/bench_tables_test.py)

# What docs/soundness.md says that machines prove: compared with the code everywhere, proven where there are the provers.
add_test(NAME proofs_match_code COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/tools/proofs --code)
add_test(NAME proofs_are_checked COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/proofs_test.py)
find_program(GAPPA gappa)
find_program(COQC coqc)
if(GAPPA AND COQC)
  add_test(NAME proofs COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/tools/proofs)
endif()

add_test(NAME dev_refuses COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/dev_test.py)
add_test(NAME tests_have_labels
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/labels_test.py ${CMAKE_CTEST_COMMAND} ${PROJECT_BINARY_DIR})
foldproof_label(tools quick)
