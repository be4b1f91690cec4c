# a rho^2 in D = a rho^2 - |o|^2 - (x o_y - y o_x)^2 +- E (section 2): the part that does not depend on the slopes.
#: bound 9
#: too small 8
#: sum a = one xx yy
#: sum d = ball right up across error
ball = (1 + 0.5 * rho) * (1 + 0.5 * rho) * (1 + square) * (1 + product) * @d(ball);
{ |rho| <= 1b-23 /\ |square| <= 1b-23 /\ |product| <= 1b-23 /\ @sums
  -> (@a(one) * ball - 1) / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
