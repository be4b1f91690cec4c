# The root's share in the depth z_c - (m + sqrt(D +- E)) length - blur (section 2), before the error of |d|^2: 12 - 2 of
# the total and 6.2 of the root. The root contains half of the unit of D +- E, and WGSL's sqrt is within 4.6 u.
#: bound 16.2
#: too small 14.5
#: sum t = right up root
#: sum z = center reach blur
length = (1 + 0.5 * center) * (1 + size) * (1 + 2.5 * inverse) * (1 + each);
{ |under| <= 1b-23 /\ |root| <= 1b-23 /\ |center| <= 1b-23 /\ |size| <= 1b-23 /\ |inverse| <= 1b-23 /\ |each| <= 1b-23
  /\ |product| <= 1b-23 /\ @sums
  -> ((1 + 0.5 * under) * (1 + 4.6 * root) * @t(root) * length * (1 + product) * @z(reach) - 1)
     / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
