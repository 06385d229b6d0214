# Tests with VTK's reader, with Blender and of the page in Chromium; skipped where these are not installed.
if(TARGET foldproof_program)
  # Debian's Python, whatever is first in PATH: Debian's VTK works with no other.
  find_program(FOLDPROOF_VTK_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
  if(FOLDPROOF_VTK_PYTHON)
    add_test(NAME vtk_reader COMMAND ${FOLDPROOF_VTK_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/vtk_test.py $<TARGET_FILE:foldproof_program>)
    set_tests_properties(vtk_reader PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 120)
  endif()
  foldproof_label(studios package foldproof_program)

  add_test(NAME blender COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/blender/run.sh $<TARGET_FILE:foldproof_program> ${PROJECT_SOURCE_DIR}
    ${PROJECT_BINARY_DIR}/foldproof_addon.zip)
  set_tests_properties(blender PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 300)
  foldproof_label(blender package foldproof_program blender_addon)

  add_test(NAME page_in_chromium COMMAND sh ${PROJECT_SOURCE_DIR}/page/tests/run.sh $<TARGET_FILE:foldproof_program>)
  set_tests_properties(page_in_chromium PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 900 PROCESSORS 2)
  foldproof_label(browser package foldproof_program page)
endif()
