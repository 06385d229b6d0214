# N1: a computed projection is off by at most 16 u M.
# code src/ccd/lanes.h
#   return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
#
# In units of M. A corner (dx, dy, dz) is off by 4.5 u on each axis (n_corners.g), so by 4.5 sqrt(3) u < 7.8 u in all; by
# Cauchy and Schwarz this contributes at most 7.8 u (1 + 5 u), as the direction is as computed, |n| <= 1 + 5 u
# (n1_length.g).

x = mul_rel<53>(nx, dx);
y = mul_rel<53>(ny, dy);
z = mul_rel<53>(nz, dz);
xh = x + hx;  # with underflow
yh = y + hy;
zh = z + hz;
xy = add_rel<53>(xh, yh);
dot = add_rel<53>(xy, zh);

Dot = nx * DX + ny * DY + nz * DZ;
corners = nx * (dx - DX) + ny * (dy - DY) + nz * (dz - DZ);

{ |nx| <= 9007199254740997b-53 /\ |ny| <= 9007199254740997b-53 /\ |nz| <= 9007199254740997b-53 /\
  |dx| <= 9007199254740999b-53 /\ |dy| <= 9007199254740999b-53 /\ |dz| <= 9007199254740999b-53 /\
  |corners| <= 125b-57 /\
  |hx| <= 1b-960 /\ |hy| <= 1b-960 /\ |hz| <= 1b-960
  -> |dot - Dot| <= 16b-53 }

dot - Dot -> (dot - (xy + zh)) + (xy - (xh + yh)) + (x - nx * dx) + (y - ny * dy) + (z - nz * dz) + hx + hy + hz + corners;
