# The root's share of the depth z_c - (m + sqrt(D +- E)) length - blur (section 2), before what |d|^2 is off by: 12 - 2 of the whole
# and 6.2 of the root. Half of the unit of D +- E is in the root, and WGSL's sqrt is within 4.6 u.
#: bound 16.2
#: too small 14.5
#: sum t = right up root
#: sum z = center reach blur
length = (1 + 0.5 * center) * (1 + size) * (1 + 2.5 * inverse) * (1 + each);
{ |under| <= 1b-23 /\ |root| <= 1b-23 /\ |center| <= 1b-23 /\ |size| <= 1b-23 /\ |inverse| <= 1b-23 /\ |each| <= 1b-23
  /\ |product| <= 1b-23 /\ @sums
  -> ((1 + 0.5 * under) * (1 + 4.6 * root) * @t(root) * length * (1 + product) * @z(reach) - 1)
     / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
