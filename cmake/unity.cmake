# ./dev compiles sources joined to a few (CMAKE_UNITY_BUILD), which takes half the time.

# What Highway compiles once for each set of instructions stays by itself.
function(foldproof_keep_apart)
  foreach(SOURCE ${ARGN})
    file(STRINGS ${SOURCE} ONCE_PER_SET REGEX "hwy/foreach_target.h")
    if(ONCE_PER_SET)
      set_source_files_properties(${SOURCE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endforeach()
endfunction()
