# B2: single precision. A gap above the margin proves a distance above g.
# code src/bvh/kinetic_bvh.cpp
#   return hn::DemoteTo(hn::Rebind<float, D>(), hn::Mul(hn::Sub(x, center), scale));
#   const double margin = distance * frame.scale * (1 + 0x1p-50) + kRounding;
#   return std::nextafter(static_cast<float>(margin), std::numeric_limits<float>::infinity());
# code src/bvh/traverse.cpp
#   const auto above = hn::Min(hn::Add(load(b, 0, 0), load(a, 0, 1)), hn::Add(load(b, 1, 0), load(a, 1, 1)));
#
# The scale is a power of two: it changes exponents alone, so x - c is rounded as if it were y = (x - c) s. The product
# is exact, unless it is denormal.

# constant src/bvh/kinetic_bvh.cpp: kRounding = {};
kRounding = 0x1.1p-22;
# constant src/bvh/kinetic_bvh.cpp: distance * frame.scale * ({}) +
kEnlarged = 1125899906842625b-50;

@any = float<53, -3000, ne>;
@f64 = float<ieee_64, ne>;
@f32 = float<ieee_32, ne>;
lower = f32(f64(any(Lower)));  # of box b
upper = f32(f64(any(Upper)));  # of box a
gap f32= lower - upper;

scaled f64= distance * scale;
enlarged f64= scaled * kEnlarged;
margin64 f64= enlarged + kRounding;
margin = float<ieee_32, up>(margin64);  # at most the next float above the nearest

G = distance * scale;

# Beyond G = 4 the margin exceeds 2 and every gap.
{ |Lower| <= 1 /\ |Upper| <= 1 /\ G in [0,4]
  -> |lower - Lower| <= 268435457b-53 /\ |gap - (Lower - Upper)| <= 268435457b-51 /\ margin - G >= 1b-22 }

margin - G -> (margin - margin64) + (margin64 - (enlarged + kRounding)) + (enlarged - scaled * kEnlarged)
  + (scaled - G) * kEnlarged + G * (kEnlarged - 1) + kRounding;
