# ./dev compiles sources joined to a few (CMAKE_UNITY_BUILD), which takes half the time. These of src/ are compiled alone, as
# Highway compiles them once for each set of instructions.
set(FOLDPROOF_ALONE
  bvh/kinetic_bvh.cpp
  bvh/traverse.cpp
  ccd/conservative_advancement.cpp
  certificate/chart_holds.cpp
  certificate/separating_plane.cpp
  solver/near_boxes.cpp
  statistics/tall_skinny.cpp)
