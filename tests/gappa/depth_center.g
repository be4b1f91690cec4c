# The centre's depth in the same sum (section 2): rounded by the host, and added.
#: bound 3.5
#: too small 2.25
#: sum z = center reach blur
{ |center| <= 1b-23 /\ @sums -> ((1 + 0.5 * center) * @z(center) - 1) / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
