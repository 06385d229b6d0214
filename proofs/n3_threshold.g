# N3: what a coefficient is compared with exceeds its error, 138 u S of rounding and 1e-261 of underflow.
# code src/ccd/conservative_advancement.cpp
#   const V volume = hn::Mul(hn::Mul(size.x, size.y), size.z);
#   const V error = hn::Add(hn::Mul(Number(kDetError), volume), Number(kDetUnderflow));
#   patches.volume_error[lane] = kDetError * (size[0] * size[1] * size[2]) + kDetUnderflow;
#
# S = x y z of any size, so each operation has a factor k for its relative error, and products have underflow h.

# constant src/ccd/bounds.h: kDetError = {};
kDetError = 139b-53;
# constant src/ccd/bounds.h: kDetUnderflow = {};
kDetUnderflow = 1e-260;

volume = (S * k1 + h1 * z) * k2 + h2;  # x y = S / z, rounded, then times z
error = (kDetError * volume * k3 + h3 + kDetUnderflow) * k4;

{ S in [0,1b300] /\ z in [0,1b100] /\ |h1| <= 1b-1075 /\ |h2| <= 1b-1075 /\ |h3| <= 1b-1075 /\
  k1 - 1 in [-1b-53,1b-53] /\ k2 - 1 in [-1b-53,1b-53] /\ k3 - 1 in [-1b-53,1b-53] /\ k4 - 1 in [-1b-53,1b-53]
  -> error - (138b-53 * S + 1e-261) >= 0 }

error - (138b-53 * S + 1e-261) ->
  S * (kDetError * k1 * k2 * k3 * k4 - 138b-53) + kDetError * (h1 * z * k2 + h2) * k3 * k4 + h3 * k4
  + (kDetUnderflow * k4 - 1e-261);
