# S3a: a triangle that the first look passes has |U E^-1| < 1.
# code src/certificate/chart_holds.cpp
#   hn::StoreU(hn::Sub(at, uv), d, changes + k);
#   const auto first = hn::Sub(corner(1), from), second = hn::Sub(corner(2), from);
#   const auto square = hn::Add(hn::Mul(first, first), hn::Mul(second, second));
#   const auto sum = hn::Add(square, hn::Shuffle2301(square));
#   if (HWY_LIKELY(hn::AllTrue(d, hn::Lt(hn::Mul(sum, weight), limit)))) continue;
#   return static_cast<float>(larger * (1 + 0x1p-20));
#
# V is at - uv before its rounding, for a vertex as for a corner of the square: at most 2^18 (kMaxMapped) + 2 * 32000. |E^-1| <= sqrt(2) / h with h >= 4.

# constant src/certificate/chart_holds.cpp: kMaxSquaredChange = {};
kMaxSquaredChange = 0.878;
# constant src/certificate/chart_holds.cpp: kMinAltitude = {};
kMinAltitude = 4;

# An entry of U.
v1 = float<ieee_32, ne>(V1);
v0 = float<ieee_32, ne>(V0);
entry = float<ieee_32, ne>(v1 - v0);

# Four such entries change |U| by at most twice as much. The sum of squares has a factor of four roundings, the weight of
# its own three and 2^-20, and the limit is a float.
limit = float<ieee_32, ne>(kMaxSquaredChange);
change = sqrt(limit * k) + 2 * 0.077 * 1.41422 / kMinAltitude;

{ |V1| <= 326200 /\ |V0| <= 326200 /\ k in [0.99999,1.00001]
  -> |entry - (V1 - V0)| <= 0.077 /\ change <= 0.993 }

entry - (V1 - V0) -> (entry - (v1 - v0)) + (v1 - V1) - (v0 - V0);
