# S4: what exceeds the bound is farther apart along n than g.
# code src/certificate/separating_plane.cpp
#   n[0] * n[0] + n[1] * n[1] + n[2] * n[2]};
#   return s.squared_length > 1e-30f && s.distance[s.nearer_end] > gap * std::sqrt(s.squared_length);
#   const float bound = static_cast<float>(gap * (1 + 0x1p-20) + 0x1p-19);
#
# In units of |n|. The computed length is off by 3 * 2^-24 (as n1_length.g, with underflow below 2^-150 / 1e-30), what
# it is compared with by s4_plane.g. g <= 4, as nothing in the frame is farther apart than 2 sqrt(3).

# constant src/certificate/separating_plane.cpp: gap * ({})
kEnlarged = 1048577b-20;
# constant src/certificate/separating_plane.cpp: gap * (1 + 0x1p-20) + {});
kRounding = 1b-19;
# constant src/certificate/separating_plane.cpp: s.squared_length > {} &&
kShortest = 1e-30;

# Each operation has a factor for its relative error.
bound64 = (g * kEnlarged * k1 + kRounding) * k2;
bound = bound64 * k3;  # to float
limit = bound * length * k4;

{ g in [0,4] /\ length - 1 in [-3b-24,3b-24] /\ k1 - 1 in [-1b-53,1b-53] /\ k2 - 1 in [-1b-53,1b-53] /\
  k3 - 1 in [-1b-24,1b-24] /\ k4 - 1 in [-1b-24,1b-24]
  -> limit - (g + 27b-24) >= 0 /\ 3b-150 / kShortest <= 1b-48 }

limit - (g + 27b-24) ->
  g * (kEnlarged * k1 * k2 * k3 * length * k4 - 1) + (kRounding * k2 * k3 * length * k4 - 27b-24);
