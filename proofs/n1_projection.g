# N1: a computed projection is off by at most 22 u M.
# code src/ccd/lanes.h
#   return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
#
# In units of M, as n_corners.g, which bounds the error of the corner (dx, dy, dz). The direction is as computed,
# |n| <= 1 + 5 u (n1_length.g).

x = mul_rel<53>(nx, dx);
y = mul_rel<53>(ny, dy);
z = mul_rel<53>(nz, dz);
xh = x + hx;  # with underflow
yh = y + hy;
zh = z + hz;
xy = add_rel<53>(xh, yh);
dot = add_rel<53>(xy, zh);

Dot = nx * DX + ny * DY + nz * DZ;

{ |nx| <= 9007199254740997b-53 /\ |ny| <= 9007199254740997b-53 /\ |nz| <= 9007199254740997b-53 /\
  |DX| <= 9007199254740994b-53 /\ |DY| <= 9007199254740994b-53 /\ |DZ| <= 9007199254740994b-53 /\
  |dx - DX| <= 9b-54 /\ |dy - DY| <= 9b-54 /\ |dz - DZ| <= 9b-54 /\
  |hx| <= 1b-960 /\ |hy| <= 1b-960 /\ |hz| <= 1b-960
  -> |dot - Dot| <= 22b-53 }

xh - nx * DX -> (x - nx * DX) + hx;
yh - ny * DY -> (y - ny * DY) + hy;
zh - nz * DZ -> (z - nz * DZ) + hz;
