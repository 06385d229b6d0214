# N1, length: a direction that is divided by its length has length 1 up to 5 u.
# code src/ccd/lanes.h
#   return Choose(hn::Ge(square, Number(kMinSquare)), Over(along, hn::Sqrt(square)), {Number(1), zero, zero});
#   best.normal = Times(across, hn::Div(sign, hn::Sqrt(across2)));
#
# Every coordinate of the computed direction is that of the exact one up to a factor, so its length is, too.
# Scaled such that the square is about 1: from kMinSquare on, underflow is below 2^-170 of it. A coordinate below
# 2^-1200 of the length, or zero, has no part in it.

# constant src/ccd/bounds.h: kMinSquare = {};
kMinSquare = 1b-900;

@rounded = float<53, -5000, ne>;
xx rounded= x * x;
yy rounded= y * y;
zz rounded= z * z;
xy = add_rel<53>(xx, yy);
square0 = add_rel<53>(xy, zz);  # square: with underflow
length rounded= sqrt(square);
over rounded= x / length;
reciprocal rounded= 1 / length;
times rounded= x * reciprocal;

Square = x * x + y * y + z * z;
Length = sqrt(Square);

{ |x| in [1b-1200,2] /\ |y| in [1b-1200,2] /\ |z| in [1b-1200,2] /\ x * x + y * y <> 0 /\
  x * x / (x * x + y * y) in [0,1] /\ (x * x + y * y) / Square in [0,1] /\
  square in [1,4] /\ Square in [0.5,8] /\ square -/ square0 in [-1b-170,1b-170]
  -> over -/ (x / Length) in [-5b-53,5b-53] /\ times -/ (x * (1 / Length)) in [-5b-53,5b-53] /\
     3b-1075 / kMinSquare <= 1b-170 }
