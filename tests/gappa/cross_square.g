# g.g in D = a r^2 - g.g +- E (section 3), for the computed g.
#: bound 5
#: too small 4
#: sum d = ball gx gy gz error
{ |square| <= 1b-23 /\ @sums -> ((1 + square) * @d(gx) - 1) / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
