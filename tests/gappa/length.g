# |d|^2 = 1 + x^2 + y^2 (section 1): the error of x^2 is within 6 u. x is a slope that the host rounded once to nearest,
# times an integer.
#: bound 6
#: too small 5
#: sum a = one xx yy
x = (1 + 0.5 * slope) * (1 + step);
xx = x * x * (1 + square) * @a(xx);
{ |slope| <= 1b-23 /\ |step| <= 1b-23 /\ |square| <= 1b-23 /\ @sums
  -> (xx - 1) / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] /\ (@a(one) - 1) / (2 * 1b-23 * (1 + 1b-10)) in [-1,1] }
