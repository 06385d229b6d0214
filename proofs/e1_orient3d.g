# E1: the filter of orient3d.
# code src/ccd/exact.cpp
#   const Vec3 ad = a - d, bd = b - d, cd = c - d;
#   const Vec3 size = ad.cwiseAbs().cwiseMax(bd.cwiseAbs()).cwiseMax(cd.cwiseAbs());
#   const double det = ad.x() * (bd.y() * cd.z() - bd.z() * cd.y()) - ad.y() * (bd.x() * cd.z() - bd.z() * cd.x()) + ad.z() * (bd.x() * cd.y() - bd.y() * cd.x());
#   const double error = kVolumeError * (size.x() * size.y() * size.z());
# code src/check/separated_triangles.cpp
#   const Vector b = Minus(s[1].x, s[0].x), c = Minus(s[2].x, s[0].x), normal = Cross(b, c);
#   const Vector sides = Max(Abs(b), Abs(c));
#   const Vector a = Minus(corner.x, s[0].x), size = Max(Abs(a), sides);
#   const V det = Dot(a, normal), error = hn::Mul(rounding, hn::Mul(hn::Mul(size.x, size.y), size.z));
#
# Cross and Dot (src/ccd/lanes.h) do the same in the same order, but for the sign of y and of its product, which are exact.
# Along each axis in units of its size. A product is off by underflow h besides: inside the parentheses by at most
# 2^-1075 / 1e-97^2, outside by 2^-1075 / 1e-97^3.

# constant src/ccd/bounds.h: kSmallestFiltered = {},
kSmallest = 1e-97;
# constant src/ccd/bounds.h: kVolumeError = {};
kFilter = 64b-53;

ax = sub_rel<53>(XA, XD); ay = sub_rel<53>(YA, YD); az = sub_rel<53>(ZA, ZD);
bx = sub_rel<53>(XB, XD); by = sub_rel<53>(YB, YD); bz = sub_rel<53>(ZB, ZD);
cx = sub_rel<53>(XC, XD); cy = sub_rel<53>(YC, YD); cz = sub_rel<53>(ZC, ZD);
AX = XA - XD; AY = YA - YD; AZ = ZA - ZD;
BX = XB - XD; BY = YB - YD; BZ = ZB - ZD;
CX = XC - XD; CY = YC - YD; CZ = ZC - ZD;

bycz = mul_rel<53>(by, cz); bzcy = mul_rel<53>(bz, cy); x = sub_rel<53>(bycz + h1, bzcy + h2);
bxcz = mul_rel<53>(bx, cz); bzcx = mul_rel<53>(bz, cx); y = sub_rel<53>(bxcz + h3, bzcx + h4);
bxcy = mul_rel<53>(bx, cy); bycx = mul_rel<53>(by, cx); z = sub_rel<53>(bxcy + h5, bycx + h6);
axx = mul_rel<53>(ax, x); ayy = mul_rel<53>(ay, y); azz = mul_rel<53>(az, z);
xy = sub_rel<53>(axx + h7, ayy + h8);
det = add_rel<53>(xy, azz + h9);
X = BY * CZ - BZ * CY;
Y = BX * CZ - BZ * CX;
Z = BX * CY - BY * CX;
Det = AX * X - AY * Y + AZ * Z;

sxsy = mul_rel<53>(1, 1) + g1;
volume = mul_rel<53>(sxsy, 1) + g2;
product = mul_rel<53>(kFilter, volume);
error = product + g3;

{ |AX| <= 9007199254740994b-53 /\ |AY| <= 9007199254740994b-53 /\ |AZ| <= 9007199254740994b-53 /\
  |BX| <= 9007199254740994b-53 /\ |BY| <= 9007199254740994b-53 /\ |BZ| <= 9007199254740994b-53 /\
  |CX| <= 9007199254740994b-53 /\ |CY| <= 9007199254740994b-53 /\ |CZ| <= 9007199254740994b-53 /\
  |h1| <= 1b-400 /\ |h2| <= 1b-400 /\ |h3| <= 1b-400 /\ |h4| <= 1b-400 /\ |h5| <= 1b-400 /\ |h6| <= 1b-400 /\
  |h7| <= 1b-100 /\ |h8| <= 1b-100 /\ |h9| <= 1b-100 /\ |g1| <= 1b-400 /\ |g2| <= 1b-100 /\ |g3| <= 1b-100
  -> |det - Det| <= 48b-53 /\ error >= 60b-53 /\
     1b-1075 / (kSmallest * kSmallest) <= 1b-400 /\ 1b-1075 / (kSmallest * kSmallest * kSmallest) <= 1b-100 }

(bycz + h1) - BY * CZ -> (bycz - BY * CZ) + h1;
(bzcy + h2) - BZ * CY -> (bzcy - BZ * CY) + h2;
(bxcz + h3) - BX * CZ -> (bxcz - BX * CZ) + h3;
(bzcx + h4) - BZ * CX -> (bzcx - BZ * CX) + h4;
(bxcy + h5) - BX * CY -> (bxcy - BX * CY) + h5;
(bycx + h6) - BY * CX -> (bycx - BY * CX) + h6;
(axx + h7) - AX * X -> (axx - AX * X) + h7;
(ayy + h8) - AY * Y -> (ayy - AY * Y) + h8;
(azz + h9) - AZ * Z -> (azz - AZ * Z) + h9;
