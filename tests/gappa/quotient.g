# c/q (1 - QUOTIENT) is not above the true c/q, nor c/q (1 + QUOTIENT) below it (section 3), q = b + error + sqrt(D + E) of terms of
# one sign: the factor of error of such a sum is a mean of those of its terms, and the root's is the largest.
#: bound 15
#: too small 11
#: sum q = b error root
q = (1 + 0.5 * under) * (1 + 4.6 * rooted) * @q(root);
c = (1 + 0.5 * power) * (1 + 2.5 * quotient) * (1 + product);
{ |under| <= 1b-23 /\ |rooted| <= 1b-23 /\ |power| <= 1b-23 /\ |quotient| <= 1b-23 /\ |product| <= 1b-23 /\ |one| <= 1b-24
  /\ @sums -> c * ((1 - @bound * 1b-23) * (1 + one)) / q <= 1 /\ c * ((1 + @bound * 1b-23) * (1 + one)) / q >= 1 }
