# S3: the rounding of K costs less than 2^-13 / h.
# code src/certificate/chart_holds.cpp
#   const auto a = hn::Mul(e1, eta1), b = hn::Mul(e2, eta2);
#   const auto c = hn::Add(hn::Mul(e1, eta2), hn::Mul(e2, eta1));
#   const auto k = hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b));
#   const auto k12 = hn::Add(hn::InterleaveLower(d, c, c), hn::InterleaveUpper(d, c, c));
#   const double mapped = largest_sum * extent;
#   if (!(mapped >= kMinMapped && mapped < kMaxMapped && min_altitude >= kMinAltitude)) return INFINITY;
#
# Sides have 17 bits and eta has 24, so products are exact. K12 + K21 is off by 2^-52 of the sum of its products'
# absolute values, which is 1 here; and K11 by less.

# constant src/certificate/chart_holds.cpp: kMaxMapped = {};
kMaxMapped = 1b18;

# e1 . eta2 + e2 . eta1
cx = add_rel<53>(p, q);
cy = add_rel<53>(r, s);
k12 = add_rel<53>(cx, cy);

# |eta| of two coordinates, each less than twice w r + 32000, or that and a corner's 2^18 + 2^16; its square in units of
# 2^40. L is the diagonal of the square.
coordinate = (2 * (kMaxMapped + 32768) + 65536) * 1b-20;

{ |p + q| <= 1 /\ |r + s| <= 1 /\ |p + q + (r + s)| <= 1 /\ L in [0,90510] /\ eta in [0,1048576] /\ h in [4,64000]
  -> |cx - (p + q)| <= 1b-53 /\ 
     2 * coordinate * coordinate <= 1 /\
     1b-52 * 4 * L * eta / (h * h) * h - 1b-13 <= 0 }
