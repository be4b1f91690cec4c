# A component of g = p x d (section 3): the error of each product.
#: bound 4
#: too small 3.5
{ |p| <= 1b-23 /\ |slope| <= 3b-24 /\ |product| <= 1b-23 /\ |minus| <= 1b-23
  -> ((1 + 0.5 * p) * (1 + slope) * (1 + product) * (1 + minus) - 1) / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
