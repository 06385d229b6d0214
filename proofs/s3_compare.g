# S3: K11 K22 nearly_four > K12^2 as computed proves 4 K11 K22 > K12^2 of the same numbers.
# code src/certificate/chart_holds.cpp
#   const auto product = hn::Mul(hn::Mul(k, hn::Shuffle01(k)), nearly_four);
#   positive = hn::And(positive, hn::And(hn::Gt(k, zero), hn::Gt(product, hn::Mul(k12, k12))));
#
# Entries of K are sums of products of integers and floats, so neither product underflows.

# constant src/certificate/chart_holds.cpp: kNearlyFour = {};
kNearlyFour = 1125899906842620b-48;

# The factors of relative errors: of both products on the left, and of the square.
{ k1 - 1 in [-1b-53,1b-53] /\ k2 - 1 in [-1b-53,1b-53] /\ k3 - 1 in [-1b-53,1b-53]
  -> kNearlyFour * k1 * k2 / k3 <= 4 }
