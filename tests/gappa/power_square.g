# b^2 in D = b^2 - a c +- E (section 3): the square and two sums.
#: bound 3
#: too small 2
#: sum d = bb ac error
{ |square| <= 1b-23 /\ @sums -> ((1 + square) * @d(bb) - 1) / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
