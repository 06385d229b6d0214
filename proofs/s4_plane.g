# S4: the computed distance of two sets along n is off by at most 27 * 2^-24 |n|.
# code src/certificate/separating_plane.cpp
#   const float projection = (x[0] * n[0] + x[2] * n[2]) + (x[1] * n[1] + x[3] * n[3]);
#   for (int end = 0; end < 2; ++end) s.distance[end] = s.a.projection[end] + s.b.projection[end];
#
# In units of |n|, so that no coordinate of n exceeds 1. x[3] = 0, so its product and sum are exact. Underflow h is
# below 2^-150 / 1e-15. The document bounds the three axes together and finds 23 * 2^-24.

# One set.
x0 = mul_rel<24>(p0, n0); x0h = x0 + h0;
x1 = mul_rel<24>(p1, n1); x1h = x1 + h1;
x2 = mul_rel<24>(p2, n2); x2h = x2 + h2;
even = add_rel<24>(x0h, x2h);
projection = add_rel<24>(even, x1h);
Projection = P0 * n0 + P2 * n2 + P1 * n1;

# Both sets.
distance = add_rel<24>(a, b);

{ |P0| <= 1 /\ |P1| <= 1 /\ |P2| <= 1 /\ |n0| <= 1 /\ |n1| <= 1 /\ |n2| <= 1 /\
  |p0 - P0| <= 268435457b-53 /\ |p1 - P1| <= 268435457b-53 /\ |p2 - P2| <= 268435457b-53 /\
  |h0| <= 1b-90 /\ |h1| <= 1b-90 /\ |h2| <= 1b-90 /\
  |A| <= 3 /\ |B| <= 3 /\ |a - A| <= 10b-24 /\ |b - B| <= 10b-24
  -> |projection - Projection| <= 10b-24 /\ |distance - (A + B)| <= 27b-24 }

x0h - P0 * n0 -> (x0 - P0 * n0) + h0;
x1h - P1 * n1 -> (x1 - P1 * n1) + h1;
x2h - P2 * n2 -> (x2 - P2 * n2) + h2;
distance - (A + B) -> (distance - (a + b)) + (a - A) + (b - B);
