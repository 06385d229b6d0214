# Tests with VTK's reader and with Blender; skipped if these are not installed.
if(TARGET foldproof_program)
  # Debian's Python, whatever is first in PATH: Debian's VTK works with no other.
  find_program(FOLDPROOF_VTK_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
  if(FOLDPROOF_VTK_PYTHON)
    add_test(NAME vtk_reader COMMAND ${FOLDPROOF_VTK_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/vtk_test.py $<TARGET_FILE:foldproof_program>)
    set_tests_properties(vtk_reader PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 120)
  endif()
  add_test(NAME blender COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/blender/run.sh $<TARGET_FILE:foldproof_program> ${PROJECT_SOURCE_DIR})
  set_tests_properties(blender PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 300 LABELS "blender;studios")
endif()
