# The same where the terms of b are added one by one, all of one sign. Where they cancel: docs/certificate.md, section 3.
#: bound 15
#: too small 13
#: sum q = start right down error root
q = (1 + 0.5 * under) * (1 + 4.6 * rooted) * @q(root);
c = (1 + 0.5 * power) * (1 + 2.5 * quotient) * (1 + product);
{ |under| <= 1b-23 /\ |rooted| <= 1b-23 /\ |power| <= 1b-23 /\ |quotient| <= 1b-23 /\ |product| <= 1b-23 /\ |one| <= 1b-24
  /\ @sums -> c * ((1 - @bound * 1b-23) * (1 + one)) / q <= 1 /\ c * ((1 + @bound * 1b-23) * (1 + one)) / q >= 1 }
