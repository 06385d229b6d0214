# F1, rounding: a vertex whose computed deviation is within r_a = 0.577 r - 2^-20 on each axis lies within r.
# code src/bvh/kinetic_bvh.cpp
#   const auto displacement = hn::Sub(hn::Load(df, vertices[i].x + 4 + lane), start);
#   const auto deviation0 = hn::Sub(to_frame(p0), hn::Add(start, hn::Mul(time0, displacement)));
# code src/check/look_ahead.cpp
#   slack_ = static_cast<float>(slack * scale * kAlongAxis - kRounding);
#
# start and end are floats of the frame, and the motion y(time) leads straight from one to the other. X is the vertex.

# constant src/check/look_ahead.cpp: kRounding = {};
kRounding = 1b-20;
# constant src/check/look_ahead.cpp: kAlongAxis = {};
kAlongAxis = 0.577;
# constant src/check/look_ahead.cpp: kMinSlack = {};
kMinSlack = 1b-16;

@any = float<53, -3000, ne>;
@f32 = float<ieee_32, ne>;
x = f32(float<ieee_64, ne>(any(X)));
displacement f32= end - start;
moved f32= time * displacement;
at f32= start + moved;
deviation f32= x - at;
Deviation = X - (start + time * (end - start));

{ |X| <= 1.0625 /\ |start| <= 1 /\ |end| <= 1 /\ time in [0,1] /\ |deviation| <= 1 /\
  |start + time * (end - start)| <= 1
  -> |deviation - Deviation| <= 1b-21 /\
     # The slack as a float, and sqrt(3) times it.
     1.7320509 * kAlongAxis <= 1 /\ kMinSlack * kAlongAxis - kRounding >= 1b-17 }

deviation - Deviation -> (deviation - (x - at)) + (x - X)
  - ((at - (start + moved)) + (moved - time * displacement) + time * (displacement - (end - start)));
