# S3: sides that end in a corner of the square are covered as well, as w r >= 1400.
# code src/certificate/chart_holds.cpp
#   const float shift = mean / static_cast<float>(count) - chart.fit.mean[k];
#   const float at = (uv + shift) - w.margin * uv;
#   const double mapped = largest_sum * extent;
#   if (!(mapped >= kMinMapped && mapped < kMaxMapped && min_altitude >= kMinAltitude)) return INFINITY;
#   const double rounding = largest_sum * 0x1p-24 * (3 + 64 * extent);
#
# T is w r. A corner is pulled back to at most 64000 + T, so the difference of it and a vertex is rounded by
# 2^-24 (64000 + T) more than s3_sides.g has. The coordinates themselves are chosen and have no error. rest is the factor
# that s3_margin.g leaves for T, for which its own 17 are needed.

# constant src/certificate/chart_holds.cpp: kMinMapped = {}, kMaxMapped
kMinMapped = 1400;
# constant src/certificate/chart_holds.cpp: 0x1p-24 * (3 + {} * extent)
kPullBack = 64;
# constant src/certificate/chart_holds.cpp: + {} * rounding + 0x1p-13)
kThree = 3;
# constant src/certificate/chart_holds.cpp: / min_altitude * {};
kMore = 1.03;

rest = kMore * k - 2.8285 * 17b-24 * 32000 * kMore * k / h;

{ T in [1400,1048576] /\ h in [4,64000] /\ k in [0.9999,1.0001]
  -> T * (kThree * kPullBack * rest - 2.8285 * 17) - 2.8285 * (64000 + T) >= 0 /\ kMinMapped >= 1400 }

T * (kThree * kPullBack * rest - 2.8285 * 17) - 2.8285 * (64000 + T) ->
  T * (kThree * kPullBack * rest - 2.8285 * 18) - 2.8285 * 64000 { h <> 0 };
