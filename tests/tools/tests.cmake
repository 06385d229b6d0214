# Tests of ./dev and of the programs in tools/.
add_test(NAME layers COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/tools/check_layers)
add_test(NAME layers_are_checked COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/check_layers_test.py)

add_test(NAME checks_are_reported COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/checks_test.py)

add_test(NAME bench_against_limits
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/bench_against_test.py)
add_test(NAME bench_tables_are_made
  COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/bench_tables_test.py)
add_test(NAME tidy_reads_what_changed COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/tidy_test.py)

# What docs/soundness.md says that machines prove: compared with the code everywhere, proven where there are the provers.
add_test(NAME proofs_match_code COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/tools/proofs --code)
add_test(NAME proofs_are_checked COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/proofs_test.py)
find_program(GAPPA gappa)
find_program(COQC coqc)
if(GAPPA AND COQC)
  add_test(NAME proofs COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/tools/proofs)
endif()

add_test(NAME dev_refuses_copies COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/dev_test.py)
add_test(NAME tests_are_selected COMMAND Python3::Interpreter ${CMAKE_CURRENT_LIST_DIR}/select_tests_test.py)
