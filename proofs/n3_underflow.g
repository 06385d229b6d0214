# N3, underflow: it changes a Bernstein coefficient by less than 1e-261.
# code src/ccd/lanes.h
#   const Vector ae = Plus(Cross(a.d[1], e.d[2]), Cross(e.d[1], a.d[2]));
#   b[1] = hn::Div(hn::Add(Dot(e.d[0], aa), Dot(a.d[0], ae)), three);
#
# A number with a _ is computed with underflow; the one without it is not, but with the same relative errors, whose
# factors are k. Products and quotients are off by h besides. A coefficient is made of a few kinds of operations in
# the order of n3_volume.g. Each kind is shown once, from the bounds of those before it.

# constant src/ccd/bounds.h: kLarge = {},
kLarge = 1e30;  # coordinates stay below 2^100

cross = (a * b * k1 - c * d * k2) * k3;
cross_ = ((a_ * b_ * k1 + h1) - (c_ * d_ * k2 + h2)) * k3;
ae = (v + w) * k1;
ae_ = (v_ + w_) * k1;
x = a * r * k1;  # a part of a dot product with r, a coordinate of ae; those with aa are smaller
x_ = a_ * r_ * k1 + h1;
dot = ((x0 + x1) * k1 + x2) * k2;
dot_ = ((x0_ + x1_) * k1 + x2_) * k2;
b1 = (f + g) * k1 / 3 * k2;
b1_ = (f_ + g_) * k1 / 3 * k2 + h1;

{ |a| <= 1b100 /\ |b| <= 1b100 /\ |c| <= 1b100 /\ |d| <= 1b100 /\
  |a_ - a| <= 8b-1075 /\ |b_ - b| <= 8b-1075 /\ |c_ - c| <= 8b-1075 /\ |d_ - d| <= 8b-1075 /\
  k1 in [0.9999,1.0001] /\ k2 in [0.9999,1.0001] /\ k3 in [0.9999,1.0001] /\ |h1| <= 1b-1075 /\ |h2| <= 1b-1075 /\
  |v| <= 2049b190 /\ |w| <= 2049b190 /\ |v_ - v| <= 33b-975 /\ |w_ - w| <= 33b-975 /\
  |r| <= 4100b190 /\ |r_ - r| <= 67b-975 /\
  |x0_ - x0| <= 100b-875 /\ |x1_ - x1| <= 100b-875 /\ |x2_ - x2| <= 100b-875 /\
  |f_ - f| <= 301b-875 /\ |g_ - g| <= 301b-875
  -> 1.001 * kLarge <= 1b100 /\
     |cross| <= 2049b190 /\ |cross_ - cross| <= 33b-975 /\
     |ae| <= 4100b190 /\ |ae_ - ae| <= 67b-975 /\
     |x_ - x| <= 100b-875 /\ |dot_ - dot| <= 301b-875 /\ |b1_ - b1| <= 1e-261 }

cross_ - cross -> ((a_ * b_ - a * b) * k1 - (c_ * d_ - c * d) * k2 + (h1 - h2)) * k3;
ae_ - ae -> ((v_ - v) + (w_ - w)) * k1;
x_ - x -> (a_ * r_ - a * r) * k1 + h1;
dot_ - dot -> (((x0_ - x0) + (x1_ - x1)) * k1 + (x2_ - x2)) * k2;
b1_ - b1 -> ((f_ - f) + (g_ - g)) * k1 / 3 * k2 + h1;
