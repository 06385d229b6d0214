# B4: boxes of features in bytes. A feature that lies beyond another one's enlarged box is farther away than g.
# code src/bvh/grid.h
#   hn::StoreU(cell(hn::Sub(lower, m)), d8, out.x[0] + lane);
#   hn::StoreU(cell(hn::Add(upper, m)), d8, out.x[1] + lane);
# code src/bvh/traverse.cpp
#   HWY_INLINE float ClampedMargin(const Traversal& traversal) { return std::min(traversal.margin, 4.0f); }
#
# Cells are a monotone function of coordinates (b4_cells.v). So what is left is lower > upper + margin, in floats, where
# the sum is at most 1, as lower is; and lower - margin > upper, where the difference is at least -1. b2_boxes.g bounds
# the errors of coordinates and shows that margin >= G + 2^-22.

# constant src/bvh/traverse.cpp: std::min(traversal.margin, {});
kLargest = 4;

sum = float<ieee_32, ne>(upper_a + margin);
difference = float<ieee_32, ne>(lower_a - margin);

{ |Upper| <= 1 /\ |Lower| <= 1 /\ margin in [1b-22,4] /\
  |lower - Lower| <= 268435457b-53 /\ |upper - Upper| <= 268435457b-53 /\
  |lower_a - Lower_a| <= 268435457b-53 /\ |upper_a - Upper_a| <= 268435457b-53 /\
  |upper_a| <= 1 /\ |lower_a| <= 1 /\ |sum| <= 1 /\ |difference| <= 1 
  -> |(sum - lower) - (Upper_a + margin - Lower)| <= 268435457b-51 /\
     |(difference - upper) - (Lower_a - margin - Upper)| <= 268435457b-51 /\ 268435457b-51 <= 1b-22 /\
     kLargest - 2 >= 1b-22 }

(sum - lower) - (Upper_a + margin - Lower) ->
  (sum - (upper_a + margin)) + (upper_a - Upper_a) - (lower - Lower);
(difference - upper) - (Lower_a - margin - Upper) ->
  (difference - (lower_a - margin)) + (lower_a - Lower_a) - (upper - Upper);
