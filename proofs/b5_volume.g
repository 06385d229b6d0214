# B5: three times a Bernstein coefficient of the volume, in single precision, is off by at most 115 * 2^-24 S.
# code src/bvh/touch.h
#   HWY_INLINE Ends Sum(const Ends& e) { return e + e.Next() + e.Next().Next(); }
#   HWY_INLINE Ends CrossNext(const Ends& a, const Ends& b) { return a * b.Next() - a.Next() * b; }
#   const Ends cross = CrossNext(d1, d2);
#   const Ends mixed = CrossNext(d1, d2.Swapped()) + CrossNext(d1.Swapped(), d2);
#   const Ends outer = Sum(first * cross);
#   const Ends inner = Sum(first.Swapped() * cross + first * mixed);
#
# Along each axis in units of its M. The corners are taken as they are computed. `inner` is shown; `outer` is a part of it.

# constant src/bvh/touch.h: Ends::Number({}f) * (faces
kRounding = 0x1p-16;

# CrossNext(d1, d2.Swapped())
px1 = mul_rel<24>(a1y, e2z); px2 = mul_rel<24>(a1z, e2y); px = sub_rel<24>(px1, px2);
py1 = mul_rel<24>(a1z, e2x); py2 = mul_rel<24>(a1x, e2z); py = sub_rel<24>(py1, py2);
pz1 = mul_rel<24>(a1x, e2y); pz2 = mul_rel<24>(a1y, e2x); pz = sub_rel<24>(pz1, pz2);
PX = a1y * e2z - a1z * e2y;
PY = a1z * e2x - a1x * e2z;
PZ = a1x * e2y - a1y * e2x;
# CrossNext(d1.Swapped(), d2)
qx1 = mul_rel<24>(e1y, a2z); qx2 = mul_rel<24>(e1z, a2y); qx = sub_rel<24>(qx1, qx2);
qy1 = mul_rel<24>(e1z, a2x); qy2 = mul_rel<24>(e1x, a2z); qy = sub_rel<24>(qy1, qy2);
qz1 = mul_rel<24>(e1x, a2y); qz2 = mul_rel<24>(e1y, a2x); qz = sub_rel<24>(qz1, qz2);
QX = e1y * a2z - e1z * a2y;
QY = e1z * a2x - e1x * a2z;
QZ = e1x * a2y - e1y * a2x;
# mixed
mx = add_rel<24>(px, qx); my = add_rel<24>(py, qy); mz = add_rel<24>(pz, qz);
# cross
cx1 = mul_rel<24>(a1y, a2z); cx2 = mul_rel<24>(a1z, a2y); cx = sub_rel<24>(cx1, cx2);
cy1 = mul_rel<24>(a1z, a2x); cy2 = mul_rel<24>(a1x, a2z); cy = sub_rel<24>(cy1, cy2);
cz1 = mul_rel<24>(a1x, a2y); cz2 = mul_rel<24>(a1y, a2x); cz = sub_rel<24>(cz1, cz2);
CX = a1y * a2z - a1z * a2y;
CY = a1z * a2x - a1x * a2z;
CZ = a1x * a2y - a1y * a2x;
# Sum(...)
fx = mul_rel<24>(e0x, cx); fy = mul_rel<24>(e0y, cy); fz = mul_rel<24>(e0z, cz);
gx = mul_rel<24>(a0x, mx); gy = mul_rel<24>(a0y, my); gz = mul_rel<24>(a0z, mz);
hx = add_rel<24>(fx, gx); hy = add_rel<24>(fy, gy); hz = add_rel<24>(fz, gz);
hxy = add_rel<24>(hx, hy); inner = add_rel<24>(hxy, hz);
INNER = (e0x * CX + a0x * (PX + QX)) + (e0y * CY + a0y * (PY + QY)) + (e0z * CZ + a0z * (PZ + QZ));

{ |a0x| <= 1 /\ |a0y| <= 1 /\ |a0z| <= 1 /\ |a1x| <= 1 /\ |a1y| <= 1 /\ |a1z| <= 1 /\
  |a2x| <= 1 /\ |a2y| <= 1 /\ |a2z| <= 1 /\ |e0x| <= 1 /\ |e0y| <= 1 /\ |e0z| <= 1 /\
  |e1x| <= 1 /\ |e1y| <= 1 /\ |e1z| <= 1 /\ |e2x| <= 1 /\ |e2y| <= 1 /\ |e2z| <= 1
  -> |inner - INNER| <= 115b-24 /\ 3 * kRounding - 115b-24 >= 3b-17 }
