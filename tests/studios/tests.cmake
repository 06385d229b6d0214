# What studios open: VTK's own reader and Blender judge it. Both are skipped, and say so, where they are not installed.
if(TARGET foldproof_program)
  # Debian's Python, whatever else comes first in PATH, as Debian's VTK is for no other.
  find_program(FOLDPROOF_VTK_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
  if(FOLDPROOF_VTK_PYTHON)
    add_test(NAME vtk_reader COMMAND ${FOLDPROOF_VTK_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/vtk_test.py $<TARGET_FILE:foldproof_program>)
    set_tests_properties(vtk_reader PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 120)
  endif()
  add_test(NAME blender COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/blender/run.sh $<TARGET_FILE:foldproof_program> ${PROJECT_SOURCE_DIR})
  set_tests_properties(blender PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 300 LABELS blender)
endif()
