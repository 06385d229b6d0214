# S3: lambda covers the gap, the rounding of eta and the rounding of K, for charts of altitude h >= 4.
# code src/certificate/chart_holds.cpp
#   const double rounding = largest_sum * 0x1p-24 * (3 + 64 * extent);
#   const double margin = (gap * std::sqrt(square) + 3 * rounding + 0x1p-13) / min_altitude * 1.03;
#   return static_cast<float>(margin) * (1 + 0x1p-20f);
#
# W is g |W|, w the larger sum of a column and T is w r. The test must allow for W + 2 sqrt(2) times the error of an
# entry of eta, 2^-24 (1.01 w + 17 (T + 32000 lambda)), + 2^-13. All operations together have a factor k.

# constant src/certificate/chart_holds.cpp: 0x1p-24 * (3 + {} * extent)
kPullBack = 64;
# constant src/certificate/chart_holds.cpp: + {} * rounding + 0x1p-13
kThree = 3;
# constant src/certificate/chart_holds.cpp: * rounding + {}) / min_altitude
kForm = 1b-13;
# constant src/certificate/chart_holds.cpp: / min_altitude * {};
kMore = 1.03;
# constant src/certificate/chart_holds.cpp: kMinAltitude = {};
kMinAltitude = 4;

parts = W + kThree * 1b-24 * (kThree * w + kPullBack * T) + kForm;
lambda = parts / h * kMore * k;
needed = W + 2.8285 * 1b-24 * (1.01 * w + 17 * T) + kForm + 2.8285 * 17b-24 * 32000 * lambda;

{ W in [0,1b30] /\ w in [0,1b30] /\ T in [0,1b30] /\ h in [4,64000] /\ k in [0.9999,1.0001]
  -> lambda * h - needed >= 0 /\ kMinAltitude >= 4 }

lambda * h - needed ->
  W * (kMore * k - 2.8285 * 17b-24 * 32000 * kMore * k / h - 1)
  + w * 1b-24 * (kThree * kThree * (kMore * k - 2.8285 * 17b-24 * 32000 * kMore * k / h) - 2.8285 * 1.01)
  + T * 1b-24 * (kThree * kPullBack * (kMore * k - 2.8285 * 17b-24 * 32000 * kMore * k / h) - 2.8285 * 17)
  + kForm * (kMore * k - 2.8285 * 17b-24 * 32000 * kMore * k / h - 1) { h <> 0 };
