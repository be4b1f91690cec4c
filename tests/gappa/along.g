# b = p.d of a general sphere (section 3): start + columns * by[0] + rows * by[1]. The error of a step; start has
# one unit less.
#: bound 3.5
#: too small 3
#: sum b = start right down
{ |rounded| <= 1b-23 /\ |product| <= 1b-23 /\ @sums
  -> ((1 + 0.5 * rounded) * (1 + product) * @b(right) - 1) / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1]
  /\ ((1 + 0.5 * rounded) * @b(start) - 1) / (2.5 * 1b-23 * (1 + 1b-10)) in [-1,1] }
