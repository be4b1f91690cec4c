# The centre in a candidate's lower bound of depth (section 2): rounded to f32 to nearest, and subtracted from.
#: bound 1.5
#: too small 1.25
#: sum low = center error
{ |center| <= 1b-23 /\ @sums -> ((1 + 0.5 * center) * @low(center) - 1) / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
