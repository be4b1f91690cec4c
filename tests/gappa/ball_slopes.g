# a rho^2 in D (section 2): x^2 rho^2.
#: bound 13
#: too small 12
#: sum a = one xx yy
#: sum d = ball right up across error
x = (1 + 0.5 * slope) * (1 + step);
xx = x * x * (1 + xsquare) * @a(xx);
ball = (1 + 0.5 * rho) * (1 + 0.5 * rho) * (1 + square) * (1 + product) * @d(ball);
{ |slope| <= 1b-23 /\ |step| <= 1b-23 /\ |xsquare| <= 1b-23 /\ |rho| <= 1b-23 /\ |square| <= 1b-23 /\ |product| <= 1b-23
  /\ @sums -> (xx * ball - 1) / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
