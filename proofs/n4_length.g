# N4: the length of the difference vector is wrong by less than 64 u M.
# code src/ccd/lanes.h
#   const Vector e1 = Minus(c.d[1], c.d[0]), e2 = Minus(c.d[2], c.d[0]);
#   const M within = N == 4 ? hn::And(hn::Le(beta, across2), hn::Le(gamma, across2)) : hn::Le(hn::Add(beta, gamma), across2);
#   best.difference = Plus(Plus(c.d[0], Times(e1, best.u)), Times(e2, best.v));
#   best.distance = hn::Sqrt(Dot(best.difference, best.difference));
#   const Vector candidate = Choose(hn::Lt(s, one), Plus(p, Times(along, s)), q);
#
# In units of M, along one axis. Any point of the patch bounds the distance from above, so only the weights b and g
# that were computed count. They are at least 0, and what the code demands of them holds up to 3 u: the exact point
# lies within 6 u of the patch. A point on the border has g = 0 and less error.

e1 = sub_rel<53>(c1, c0);
e2 = sub_rel<53>(c2, c0);
e1b = mul_rel<53>(e1, b); e1bh = e1b + h1;
e2g = mul_rel<53>(e2, g); e2gh = e2g + h2;
first = add_rel<53>(c0, e1bh);
point = add_rel<53>(first, e2gh);
Point = c0 + (c1 - c0) * b + (c2 - c0) * g;

{ |c0| <= 1 /\ |c1| <= 1 /\ |c2| <= 1 /\ b in [0,1] /\ g in [0,1] /\ |h1| <= 1b-960 /\ |h2| <= 1b-960 /\
  |c0 + (c1 - c0) * b| <= 1 /\ |Point| <= 1.001
  -> |point - Point| <= 12b-53 /\
     # With the corners (n_corners.g) and the 6 u; the length itself is off by less than 4 u of at most sqrt(3).
     1.7321 * (12b-53 + 9b-54 + 6b-53 + 4b-53) <= 64b-53 }

e1bh - (c1 - c0) * b -> (e1b - (c1 - c0) * b) + h1;
e2gh - (c2 - c0) * g -> (e2g - (c2 - c0) * g) + h2;
