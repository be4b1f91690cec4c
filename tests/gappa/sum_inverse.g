# (b +- error + sqrt(D +- E)) / a (1 -+ sum) from inside (section 3), of terms of one sign: sum = (11 + 6 a) u. The
# relative error of |d|^2 is k u, k = (2 + 6 s)/(1 + s), and 6 a >= k + 4.
#: bound 11
#: too small 9.9
#: sum q = start right down error root
f = (1 + 0.5 * under) * (1 + 4.6 * rooted) * @q(root) * (1 + 2.5 * inverse) * (1 + each) * (1 + product) / (1 + k * a);
{ k in [2,6] /\ |a| <= 1b-23 /\ |under| <= 1b-23 /\ |rooted| <= 1b-23 /\ |inverse| <= 1b-23 /\ |each| <= 1b-23
  /\ |product| <= 1b-23 /\ |one| <= 1b-23 /\ @sums
  -> f * ((1 - (@bound + 4 + k) * 1b-23) * (1 + one)) <= 1 /\ f * ((1 + (@bound + 4 + k) * 1b-23) * (1 + one)) >= 1 }
$ k in 8;
