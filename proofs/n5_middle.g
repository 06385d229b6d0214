# N5: the middle coefficient of a turning plane is off by at most 20 u M; n1_threshold.g allows 22.
# code src/ccd/conservative_advancement.cpp
#   const V middle = hn::Mul(hn::Add(Dot(normal, then.d[k]), Dot(other, now_.d[k])), Number(0.5));
#
# In units of M. Each projection is off by n1_projection.g; halving is exact, or its underflow vanishes beside u M.

sum = add_rel<53>(p, q);
middle = sum * 0.5 + h;
Middle = (P + Q) * 0.5;

{ |P| <= 3.1 /\ |Q| <= 3.1 /\ |p - P| <= 16b-53 /\ |q - Q| <= 16b-53 /\ |h| <= 1b-960
  -> |middle - Middle| <= 20b-53 }

middle - Middle -> ((sum - (p + q)) + ((p - P) + (q - Q))) * 0.5 + h;
