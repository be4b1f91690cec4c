# a r^2 in the same sum, before the error of |d|^2: 7 a + 2 >= (2 + 6 s) + 7 (1 + s) in units of r^2 a / (1 + s).
#: bound 7
#: too small 6
#: sum d = ball gx gy gz error
{ |r| <= 1b-23 /\ |square| <= 1b-23 /\ |product| <= 1b-23 /\ @sums
  -> ((1 + 0.5 * r) * (1 + 0.5 * r) * (1 + square) * (1 + product) * @d(ball) - 1)
     / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
