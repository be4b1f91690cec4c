# The share of m = x o_x + y o_y in the depth (section 2), before the error of |d|^2: 12 - 2 of the total and 6 of its
# own.
#: bound 16
#: too small 14.5
#: sum t = right up root
#: sum z = center reach blur
length = (1 + 0.5 * center) * (1 + size) * (1 + 2.5 * inverse) * (1 + each);
{ |slope| <= 3b-24 /\ |o| <= 5b-24 /\ |along| <= 1b-23 /\ |center| <= 1b-23 /\ |size| <= 1b-23 /\ |inverse| <= 1b-23
  /\ |each| <= 1b-23 /\ |product| <= 1b-23 /\ @sums
  -> ((1 + slope) * (1 + o) * (1 + along) * @t(right) * length * (1 + product) * @z(reach) - 1)
     / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
