# S3: a pulled-back vertex, y - lambda p, is off by at most 5 * 2^-24 w r, before lambda.
# code src/certificate/chart_holds.cpp
#   const auto offset = hn::Sub(hn::Load(d, vertices[chart.vertices[i]].x + lane), origin);
#   return hn::Add(hn::Add(hn::Mul(x, hn::Set(d, c[0])), hn::Mul(y, hn::Set(d, c[1]))), hn::Mul(z, hn::Set(d, c[2])));
#
# In units of w r. p_k = w_k x_k with |w_0| + |w_1| + |w_2| <= w, so partial sums are at most 1. An offset and a product
# are each off by 2^-24 of themselves; the three together by a = 2 * 2^-24. Underflow h is below 2^-150 / 2^-100 each.

sum01 = add_rel<24>(p0, p1);
y = add_rel<24>(sum01, p2);

{ |p0 + p1| <= 1.000001 /\ |p0 + p1 + p2| <= 1.000001 /\ |a| <= 2097153b-44 /\ |h| <= 1b-48
  -> |(y - (p0 + p1 + p2)) + a + h| <= 5b-24 }
y - (p0 + p1 + p2) -> (y - (sum01 + p2)) + (sum01 - (p0 + p1));
