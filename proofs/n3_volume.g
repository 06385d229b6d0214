# N3: a Bernstein coefficient of the volume is off by at most 138 u S.
# code src/ccd/lanes.h
#   return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)), hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
#   const Vector aa = Cross(a.d[1], a.d[2]), ee = Cross(e.d[1], e.d[2]);
#   const Vector ae = Plus(Cross(a.d[1], e.d[2]), Cross(e.d[1], a.d[2]));
#   b[0] = Dot(a.d[0], aa);
#   b[1] = hn::Div(hn::Add(Dot(e.d[0], aa), Dot(a.d[0], ae)), three);
#   b[2] = hn::Div(hn::Add(Dot(e.d[0], ae), Dot(a.d[0], ee)), three);
#   b[3] = Dot(e.d[0], ee);
#
# Along each axis in units of its M. b[1] is shown; b[2] is the same with a and e exchanged, and b[0] and b[3] are
# parts of it. Corners are off by n_corners.g. Underflow: n3_underflow.g.

# Cross(a.d[1], e.d[2]), computed and exact
px1 = mul_rel<53>(a1y, e2z); px2 = mul_rel<53>(a1z, e2y); px = sub_rel<53>(px1, px2);
py1 = mul_rel<53>(a1z, e2x); py2 = mul_rel<53>(a1x, e2z); py = sub_rel<53>(py1, py2);
pz1 = mul_rel<53>(a1x, e2y); pz2 = mul_rel<53>(a1y, e2x); pz = sub_rel<53>(pz1, pz2);
PX = A1Y * E2Z - A1Z * E2Y;
PY = A1Z * E2X - A1X * E2Z;
PZ = A1X * E2Y - A1Y * E2X;
# Cross(e.d[1], a.d[2])
qx1 = mul_rel<53>(e1y, a2z); qx2 = mul_rel<53>(e1z, a2y); qx = sub_rel<53>(qx1, qx2);
qy1 = mul_rel<53>(e1z, a2x); qy2 = mul_rel<53>(e1x, a2z); qy = sub_rel<53>(qy1, qy2);
qz1 = mul_rel<53>(e1x, a2y); qz2 = mul_rel<53>(e1y, a2x); qz = sub_rel<53>(qz1, qz2);
QX = E1Y * A2Z - E1Z * A2Y;
QY = E1Z * A2X - E1X * A2Z;
QZ = E1X * A2Y - E1Y * A2X;
# ae
aex = add_rel<53>(px, qx); aey = add_rel<53>(py, qy); aez = add_rel<53>(pz, qz);
AEX = PX + QX; AEY = PY + QY; AEZ = PZ + QZ;
# aa
aax1 = mul_rel<53>(a1y, a2z); aax2 = mul_rel<53>(a1z, a2y); aax = sub_rel<53>(aax1, aax2);
aay1 = mul_rel<53>(a1z, a2x); aay2 = mul_rel<53>(a1x, a2z); aay = sub_rel<53>(aay1, aay2);
aaz1 = mul_rel<53>(a1x, a2y); aaz2 = mul_rel<53>(a1y, a2x); aaz = sub_rel<53>(aaz1, aaz2);
AAX = A1Y * A2Z - A1Z * A2Y;
AAY = A1Z * A2X - A1X * A2Z;
AAZ = A1X * A2Y - A1Y * A2X;
# Dot(e.d[0], aa)
fx = mul_rel<53>(e0x, aax); fy = mul_rel<53>(e0y, aay); fz = mul_rel<53>(e0z, aaz);
fxy = add_rel<53>(fx, fy); f = add_rel<53>(fxy, fz);
F = E0X * AAX + E0Y * AAY + E0Z * AAZ;
# Dot(a.d[0], ae)
gx = mul_rel<53>(a0x, aex); gy = mul_rel<53>(a0y, aey); gz = mul_rel<53>(a0z, aez);
gxy = add_rel<53>(gx, gy); g = add_rel<53>(gxy, gz);
G = A0X * AEX + A0Y * AEY + A0Z * AEZ;
sum = add_rel<53>(f, g);
third = sum / 3;  # before its rounding to b1
B1 = (F + G) / 3;

{ |A0X| <= 9007199254740994b-53 /\ |A0Y| <= 9007199254740994b-53 /\ |A0Z| <= 9007199254740994b-53 /\
  |a0x - A0X| <= 9b-54 /\ |a0y - A0Y| <= 9b-54 /\ |a0z - A0Z| <= 9b-54 /\
  |A1X| <= 9007199254740994b-53 /\ |A1Y| <= 9007199254740994b-53 /\ |A1Z| <= 9007199254740994b-53 /\
  |a1x - A1X| <= 9b-54 /\ |a1y - A1Y| <= 9b-54 /\ |a1z - A1Z| <= 9b-54 /\
  |A2X| <= 9007199254740994b-53 /\ |A2Y| <= 9007199254740994b-53 /\ |A2Z| <= 9007199254740994b-53 /\
  |a2x - A2X| <= 9b-54 /\ |a2y - A2Y| <= 9b-54 /\ |a2z - A2Z| <= 9b-54 /\
  |E0X| <= 9007199254740994b-53 /\ |E0Y| <= 9007199254740994b-53 /\ |E0Z| <= 9007199254740994b-53 /\
  |e0x - E0X| <= 9b-54 /\ |e0y - E0Y| <= 9b-54 /\ |e0z - E0Z| <= 9b-54 /\
  |E1X| <= 9007199254740994b-53 /\ |E1Y| <= 9007199254740994b-53 /\ |E1Z| <= 9007199254740994b-53 /\
  |e1x - E1X| <= 9b-54 /\ |e1y - E1Y| <= 9b-54 /\ |e1z - E1Z| <= 9b-54 /\
  |E2X| <= 9007199254740994b-53 /\ |E2Y| <= 9007199254740994b-53 /\ |E2Z| <= 9007199254740994b-53 /\
  |e2x - E2X| <= 9b-54 /\ |e2y - E2Y| <= 9b-54 /\ |e2z - E2Z| <= 9b-54 /\
  b1 -/ third in [-1b-53,1b-53]
  -> |b1 - B1| <= 138b-53 }
