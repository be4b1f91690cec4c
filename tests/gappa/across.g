# (x o_y - y o_x)^2 in D (section 2), in units of w^2, w = |x o_y| + |y o_x|. A is the exact difference, F its error:
# slope 1.5 u, offset 2.5 u, product and difference 1 u each, times w.
#: bound 17.2
#: too small 16
#: sum d = ball right up across error
c = (1 + square) * @d(across);
real = A * A;
seen = (A + F * (1 + 1b-12)) * (A + F * (1 + 1b-12)) * c;
{ A in [-1,1] /\ F in [-6b-23,6b-23] /\ |square| <= 1b-23 /\ @sums
  -> (seen - real) / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
seen - real -> A * A * (c - 1) + (2 * A * (F * (1 + 1b-12)) + F * (1 + 1b-12) * (F * (1 + 1b-12))) * c;
