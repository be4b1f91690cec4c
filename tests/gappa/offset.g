# A component of the offset from the projected centre (section 2): one subtraction, a step that the host rounded, a product.
#: bound 2.5
#: too small 2
{ |minus| <= 1b-23 /\ |step| <= 1b-23 /\ |product| <= 1b-23
  -> ((1 + minus) * (1 + 0.5 * step) * (1 + product) - 1) / (@bound * 1b-23 * (1 + 1b-10)) in [-1,1] }
