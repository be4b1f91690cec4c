# The same for a general sphere, |c - e|_1 < 6 in its own unit: within `HOST` = 2^-48, 32 units of 2^-53.
#: bound 32
#: too small 29
#: unit 1b-53
#: sum z = right up ahead
{ |minus| <= 1b-53 /\ |axis| <= 1b-53 /\ |product| <= 1b-53 /\ length in [0,6] /\ @sums
  -> length * ((1 + minus) * (1 + axis) * (1 + product) * @z(right) - 1) / (@bound * 1b-53) in [-1,1] }
