# V4: what is subtracted from a proven separation is at least the closing distance, and what is left is a bound below.
# code src/solver/candidate_lists.cpp
#   for (double& d : corner) d = std::isfinite(d) ? d - std::abs(d) * kDisplacementRounding : -kInfinity;
#   change = std::min(change, a[0][axis] + b[1][axis]);
#   return -change * kUp;
#   return (min_separation - closing_distance(node_a, node_b)) * kDown;
#   return std::min(separation(boxes_[node_a], boxes_[node_b]), std::numeric_limits<double>::max()) * kDown;
#   required_ = inflation * (1 + 0x1p-40) + std::numeric_limits<double>::min();
#
# k is the factor of an operation's relative error. Sums are exact where they are denormal. A product that may be has an
# error h of its own, at most 2^-1075; then a result that counts is at least `required_`, above 2^-1022.

# constant src/solver/candidate_lists.cpp: kDown = {}, kUp
kDown = 1125899906842623b-50;
# constant src/solver/candidate_lists.cpp: kUp = {}, kDisplacementRounding
kUp = 1125899906842625b-50;
# constant src/solver/candidate_lists.cpp: kDisplacementRounding = {};
kDisplacementRounding = 1b-51;
# constant src/solver/candidate_lists.cpp: inflation * ({})
kRequired = 1099511627777b-40;

# A displacement d, positive or negative, is computed as d k1. What is stored is below d.
stored_positive = (k1 - k1 * kDisplacementRounding * k2) * k3;
stored_negative = (k1 + k1 * kDisplacementRounding * k2) * k3;  # times -|d|

# A sum of two stored numbers is -c, with the closing distance c > 0.
closing = k1 * kUp * k2;
# A separation s > 0 that is left after it, and one of two boxes.
left = k1 * kDown * k2;

{ k1 - 1 in [-1b-53,1b-53] /\ k2 - 1 in [-1b-53,1b-53] /\ k3 - 1 in [-1b-53,1b-53]
  -> stored_positive <= 1 /\ stored_negative >= 1 /\ closing >= 1 /\ left <= 1 /\
     # Above what is required, a separation is computed above the inflation.
     kRequired * k1 * k2 * k3 >= 1 }
