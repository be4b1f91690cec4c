# |o|^2 in D (section 2).
#: bound 10
#: too small 9
#: sum d = ball right up across error
{ |o| <= 5b-24 /\ |square| <= 1b-23 /\ @sums
  -> ((1 + o) * (1 + o) * (1 + square) * @d(right) - 1) / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
