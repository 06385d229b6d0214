# The module under Debian's Python; the examples; and what pip installs.
set(MODULE_PATH PYTHONPATH=${PROJECT_BINARY_DIR}/python PYTHONDONTWRITEBYTECODE=1 MPLBACKEND=Agg)
set(PYTHON_SOURCE ${PROJECT_SOURCE_DIR}/python)

add_test(NAME python COMMAND ${Python3_EXECUTABLE} -m pytest -q -p no:cacheprovider ${PYTHON_SOURCE}/tests)
set_tests_properties(python PROPERTIES TIMEOUT 600
  ENVIRONMENT "${MODULE_PATH};FOLDPROOF_PROGRAM=$<TARGET_FILE:foldproof_program>")

file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/python_examples)
file(GLOB PYTHON_EXAMPLES CONFIGURE_DEPENDS ${PYTHON_SOURCE}/examples/*.py)
foreach(EXAMPLE ${PYTHON_EXAMPLES})
  get_filename_component(NAME ${EXAMPLE} NAME_WE)
  add_test(NAME python_example_${NAME} COMMAND ${Python3_EXECUTABLE} ${EXAMPLE}
    WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/python_examples)
  file(STRINGS ${EXAMPLE} PRINTS REGEX "^# Prints: ")
  if(NOT PRINTS MATCHES "^# Prints: (.+)$")
    message(FATAL_ERROR "${EXAMPLE}: no line says '# Prints: ...'")
  endif()
  string(REGEX REPLACE "([][+.*()^$?|\\])" "\\\\\\1" PRINTS "${CMAKE_MATCH_1}")
  string(REGEX REPLACE "[\\]*;" "." PRINTS "${PRINTS}")  # a semicolon would end a list's item
  set_tests_properties(python_example_${NAME} PROPERTIES ENVIRONMENT "${MODULE_PATH}"
    PASS_REGULAR_EXPRESSION "(^|\n)${PRINTS}\n" FAIL_REGULAR_EXPRESSION "Traceback")
endforeach()

# Types of the package and of its examples, as pyproject.toml asks for.
find_program(MYPY mypy)
if(MYPY)
  add_test(NAME python_types COMMAND ${MYPY} --config-file ${PROJECT_SOURCE_DIR}/pyproject.toml
    --cache-dir ${CMAKE_CURRENT_BINARY_DIR}/mypy ${PYTHON_SOURCE}/foldproof ${PYTHON_SOURCE}/examples)
endif()

add_test(NAME python_pip COMMAND sh ${PYTHON_SOURCE}/tests/pip.sh ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}
  ${CMAKE_CURRENT_BINARY_DIR}/python_pip ${PROJECT_BINARY_DIR})
set_tests_properties(python_pip PROPERTIES PASS_REGULAR_EXPRESSION "installed and works: 0 0.600")

add_test(NAME python_wheel COMMAND sh ${PYTHON_SOURCE}/tests/wheel.sh ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}
  ${CMAKE_CURRENT_BINARY_DIR}/python_wheel ${PROJECT_BINARY_DIR})
set_tests_properties(python_wheel PROPERTIES SKIP_RETURN_CODE 77)

add_test(NAME python_sdist COMMAND sh ${PYTHON_SOURCE}/tests/sdist.sh ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}
  ${CMAKE_CURRENT_BINARY_DIR}/python_sdist ${PROJECT_BINARY_DIR})
set_tests_properties(python_sdist PROPERTIES SKIP_RETURN_CODE 77)
