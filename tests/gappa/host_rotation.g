# c - e in the camera, in the host's f64 (`ROTATED`): subtraction, axis, product and two sums, each to nearest.
#: bound 5
#: too small 4.5
#: unit 1b-53
#: sum z = right up ahead
{ |minus| <= 1b-53 /\ |axis| <= 1b-53 /\ |product| <= 1b-53 /\ @sums
  -> ((1 + minus) * (1 + axis) * (1 + product) * @z(right) - 1) / (@bound * 1b-53 * (1 + 1b-10)) in [-1,1] }
