# foldproof_once_per_set(RESULT SOURCE...): those that Highway compiles once for each set of instructions. They are not compiled
# as one with others (CMAKE_UNITY_BUILD).
function(foldproof_once_per_set RESULT)
  set(FOUND)
  foreach(SOURCE ${ARGN})
    file(STRINGS ${SOURCE} ONCE_PER_SET REGEX "hwy/foreach_target.h")
    if(ONCE_PER_SET)
      list(APPEND FOUND ${SOURCE})
    endif()
  endforeach()
  set(${RESULT} ${FOUND} PARENT_SCOPE)
endfunction()
