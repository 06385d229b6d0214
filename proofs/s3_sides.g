# S3: a coordinate of eta is off by at most 17 * 2^-24 (w r + 32000 lambda), between vertices of the patch.
# code src/certificate/chart_holds.cpp
#   const auto at = hn::Sub(hn::LoadU(d, mapped + k), hn::Mul(margin, uv));
#   hn::Sub(hn::Load(df, rows[t[k]].x + lane), hn::Load(df, rows[t[0]].x + lane))
#
# In units of w r + 32000 lambda. Y is pulled back exactly from where the vertex is in the frame, L is lambda p; y is off
# by s3_pull_back.g. The positions themselves are off by 2^-24 (1 + 2^-28) w more.

# constant src/certificate/parametrize.h: { {{{}, 32000}, {-32000, 32000},
kLargestUv = 32000;

la = mul_rel<24>(margin, pa);
lb = mul_rel<24>(margin, pb);
La = margin * pa;
Lb = margin * pb;
at_a = sub_rel<24>(ya, la);
at_b = sub_rel<24>(yb, lb);
eta = sub_rel<24>(at_a, at_b);

{ |La| <= 1 /\ |Lb| <= 1 /\ |ya - Ya| <= 5b-24 /\ |yb - Yb| <= 5b-24 /\
  |Ya - La| <= 1 /\ |Yb - Lb| <= 1
  -> |eta - ((Ya - La) - (Yb - Lb))| <= 17b-24 /\ kLargestUv <= 32000 }
