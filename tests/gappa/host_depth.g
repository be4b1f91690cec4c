# The same for a projected sphere's depth, in units of that depth: |c - e| <= 64 z, so |c - e|_1 <= 64 sqrt(3) z, within
# `DEPTH` = 2^-43, 1024 units of 2^-53.
#: bound 1024
#: too small 550
#: unit 1b-53
#: sum z = right up ahead
{ |minus| <= 1b-53 /\ |axis| <= 1b-53 /\ |product| <= 1b-53 /\ length in [0,110.86] /\ @sums
  -> length * ((1 + minus) * (1 + axis) * (1 + product) * @z(right) - 1) / (@bound * 1b-53) in [-1,1] }
