# B5: single precision along a diagonal. A sum of two gaps above twice the margin proves a distance above g.
# code src/bvh/touch.h
#   const Ends sum = beyond([](const Ends& x) HWY_ATTR { return x + x.Next(); });
#   const Ends difference = beyond([](const Ends& x) HWY_ATTR { return x - x.Next(); });
#   return (axis.Above(Ends::Number(margin)) | Ends::Max(sum, difference).Above(Ends::Number(2 * margin))) != 0;
#
# x and y are coordinates of a corner, off by what b2_boxes.g bounds; a difference is a sum with -y. The distance
# along the diagonal is (X + Y) / sqrt(2). The margin exceeds g by 2^-22 (b2_boxes.g); no sum exceeds 8.

@f32 = float<ieee_32, ne>;
x = f32(x_any);
y = f32(y_any);
sum f32= x + y;

{ |x| <= 2 /\ |y| <= 2 /\ |x - X| <= 268435457b-51 /\ |y - Y| <= 268435457b-51 /\
  margin - G in [1b-22,8] /\ sum - 2 * margin in [0,8]
  -> X + Y - 2 * G >= 1b-24 }

X + Y - 2 * G -> (sum - 2 * margin) + 2 * (margin - G) - (sum - (x + y)) - (x - X) - (y - Y);
