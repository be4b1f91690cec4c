# a c in the same sum, before the error of |d|^2, (2 + 6 s) u: 6 a - 0.5 = 2 + 6 s + 3.5.
#: bound 3.5
#: too small 3
#: sum d = bb ac error
{ |power| <= 1b-23 /\ |product| <= 1b-23 /\ @sums
  -> ((1 + 0.5 * power) * (1 + product) * @d(ac) - 1) / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
