# F1: the end of an extrapolated motion is off by at most 6 u C.
# code src/bvh/kinetic_bvh.cpp
#   const auto more = hn::Set(d, steps - 1);
#   const auto p = hn::Add(p1, hn::Mul(more, hn::Sub(p1, p0)));
#
# In units of C, the largest coordinate of the motion, which n - 1 times the step does not leave. A product that is denormal
# is off by h, below u C by far, as C s >= 1/4 in the frame.

# constant src/check/motion.cpp: kMaxExtrapolatedCoordinate = {};
kMaxExtrapolatedCoordinate = 1b28;

displacement = sub_rel<53>(p1, p0);
product = mul_rel<53>(more, displacement);
producth = product + h;
end = add_rel<53>(p1, producth);
End = p1 + more * (p1 - p0);

{ |p1| <= 1 /\ |p0| <= 1 /\ |End| <= 1 /\ |more * (p1 - p0)| <= 2 /\ |h| <= 1b-100
  -> |end - End| <= 6b-53 /\ 6b-53 * kMaxExtrapolatedCoordinate <= 1b-22 }

end - End -> (end - (p1 + producth)) + (product - more * (p1 - p0)) + h;
p1 + producth -> End + (product - more * (p1 - p0)) + h;
