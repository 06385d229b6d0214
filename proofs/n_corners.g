# Narrow phase, rounding of corners: a corner at a time t is off by at most 4.5 u M on each axis.
# code src/ccd/lanes.h
#   return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
#   const V s = hn::Sub(Number(1), t);
#   for (int k = 0; k < N; ++k) c.d[k] = Plus(Times(a.d[k], s), Times(e.d[k], t));
# code src/ccd/conservative_advancement.cpp
#   const Corners<N> ends[2] = {Differences<N>(pairs.x[0], lane), Differences<N>(pairs.x[1], lane)};
#
# Lengths are in units of M, any real number: operations are known by their relative errors, and a product by
# an error h of underflow besides. It is below 2^-1075 / M, and M >= 1e-30 / 4 where a projection exceeds D.
# Sums do not underflow.

A = P0 - Q0;  # a corner at both ends of the step
E = P1 - Q1;
D = A * (1 - t) + E * t;

a = sub_rel<53>(P0, Q0);
e = sub_rel<53>(P1, Q1);
s = sub_rel<53>(1, t);
as = mul_rel<53>(a, s);
et = mul_rel<53>(e, t);
ash = as + h0;
eth = et + h1;
d = add_rel<53>(ash, eth);

# |A| <= 1 + 2 u, as |a| <= 1.
{ |A| <= 9007199254740994b-53 /\ |E| <= 9007199254740994b-53 /\ t in [0,1] /\
  |h0| <= 1b-960 /\ |h1| <= 1b-960
  -> |d - D| <= 9b-54 }

ash - A * (1 - t) -> (as - A * (1 - t)) + h0;
eth - E * t -> (et - E * t) + h1;
$ t in 32;
