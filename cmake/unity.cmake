# ./dev compiles sources joined to a few (CMAKE_UNITY_BUILD), which takes half the time. These of src/ are compiled alone: the
# first seven since Highway compiles them once for each set of instructions, the others since they have names that others of
# their library have too (tools/check_layers knows).
set(FOLDPROOF_ALONE
  bvh/kinetic_bvh.cpp
  bvh/traverse.cpp
  ccd/conservative_advancement.cpp
  certificate/chart_holds.cpp
  certificate/separating_plane.cpp
  solver/near_boxes.cpp
  statistics/tall_skinny.cpp
  bvh/split.cpp
  solver/candidates.cpp
  statistics/k_means.cpp)
