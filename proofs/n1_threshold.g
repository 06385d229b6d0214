# N1, N5: what is computed above A proves a distance above D, if it is off by at most 22 u M. A projection is off by 16
# (n1_projection.g), a middle coefficient by 20 (n5_middle.g).
# code src/ccd/conservative_advancement.cpp
#   min_projection_ = hn::Add(hn::Mul(thickness, Number(1 + 8 * kUnit)), hn::Mul(Number(kDotError), Row(lanes.patch.extent)));
#
# In units of M; D <= 2, as no projection exceeds 2.

# constant src/ccd/conservative_advancement.cpp: hn::Mul(thickness, Number({}))
kEnlarged = 9007199254741000b-53;
# constant src/ccd/bounds.h: kDotError = {};
kDotError = 23b-53;

thickness = mul_rel<53>(D, kEnlarged);
thicknessh = thickness + h0;
error = mul_rel<53>(kDotError, 1);
errorh = error + h1;
A = add_rel<53>(thicknessh, errorh);

# What exceeds A - 22 u exceeds D (1 + 6 u). Divided by |n| <= 1 + 5 u this exceeds D.
{ D in [0,2] /\ |h0| <= 1b-960 /\ |h1| <= 1b-960
  -> A - (D * 9007199254740998b-53 + 22b-53) >= 0 }

A - (D * 9007199254740998b-53 + 22b-53) ->
  (A - (thicknessh + errorh)) + (thickness - D * kEnlarged) + (error - kDotError) + h0 + h1
  + (D * 2b-53 + 1b-53);
$ D in 32;
