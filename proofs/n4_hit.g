# N4, hit: at a hit the distance is at most D + tol.
# code src/ccd/conservative_advancement.cpp
#   hit_ = hn::Add(thickness, hn::Mul(tolerance_, Number(0.5)));
#   const M hit = hn::And(open_, hn::Le(here.distance, hit_));
#   const double tolerance = std::max(std::max(settings_.tolerance, kMinTolerance) * scale_[k], kResolution * std::max(loaded_.extent[k], thickness));
#
# In units of max(M, D). The length is wrong by at most 64 u M (n4_length.g).

# constant src/ccd/conservative_advancement.cpp: hit_ = hn::Add(thickness, hn::Mul(tolerance_, Number({}))
kHalf = 0.5;
# constant src/ccd/bounds.h: kResolution = {};
kResolution = 512b-53;

# The smallest tolerance, of max(M, D) = 1, is rounded.
least = mul_rel<53>(kResolution, 1);
half = tolerance * kHalf;  # exact
hit = add_rel<53>(D, half);

{ D in [0,1] /\ M in [0,1] /\ tolerance - least in [0,8]
  -> (D + tolerance) - (hit + 64b-53 * M) >= 0 }

(D + tolerance) - (hit + 64b-53 * M) ->
  ((tolerance - least) * kHalf - (hit - (D + half))) + ((least - kResolution) * kHalf + (kResolution * kHalf - 64b-53 * M));
