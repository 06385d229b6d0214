# E1: the filter of orient2d.
# code src/ccd/exact.cpp
#   const double ax = a.x - c.x, ay = a.y - c.y, bx = b.x - c.x, by = b.y - c.y;
#   const double sx = std::max(std::abs(ax), std::abs(bx)), sy = std::max(std::abs(ay), std::abs(by));
#   const double det = ax * by - ay * bx;
#   const double error = 16 * 0x1p-53 * sx * sy;
#
# Along each axis in units of its size, so that sx = sy = 1. A product is off by underflow h besides: by at most
# 2^-1075 / (sx sy).

# constant src/ccd/bounds.h: kSmallestFiltered = {},
kSmallest = 1e-97;
# constant src/ccd/exact.cpp: error = {} * sx * sy;
kFilter = 16b-53;

AX = Xa - Xc;
AY = Ya - Yc;
BX = Xb - Xc;
BY = Yb - Yc;
Det = AX * BY - AY * BX;

ax = sub_rel<53>(Xa, Xc);
ay = sub_rel<53>(Ya, Yc);
bx = sub_rel<53>(Xb, Xc);
by = sub_rel<53>(Yb, Yc);
axby = mul_rel<53>(ax, by);
aybx = mul_rel<53>(ay, bx);
axbyh = axby + h0;
aybxh = aybx + h1;
det = sub_rel<53>(axbyh, aybxh);

scaled = mul_rel<53>(kFilter, 1);  # 16 u sx; 16 u is a constant
scaledh = scaled + h2;
product = mul_rel<53>(scaledh, 1);
error = product + h3;

# |AX| <= 1 + 2 u, as |ax| <= 1.
{ |AX| <= 9007199254740994b-53 /\ |AY| <= 9007199254740994b-53 /\ |BX| <= 9007199254740994b-53 /\
  |BY| <= 9007199254740994b-53 /\ |h0| <= 1b-400 /\ |h1| <= 1b-400 /\ |h2| <= 1b-400 /\ |h3| <= 1b-400
  -> error - |det - Det| >= 4b-53 /\ 1b-1075 / (kSmallest * kSmallest) <= 1b-400 }

axbyh - AX * BY -> (axby - AX * BY) + h0;
aybxh - AY * BX -> (aybx - AY * BX) + h1;
error - kFilter -> (product - scaledh) + (scaled - kFilter) + (h2 + h3);
