// The constants of the proof for given rays, in multiples of UNIT: docs/certificate.md, section 9, derives them.

// A component of g = p x d, and p.d, of |p| |d|; the same from the blur of places, not in UNIT.
const GIVEN_CROSS: f32 = 8.0;
const GIVEN_BLURS: f32 = 2.0;
// The discriminant a r^2 - g.g; the power |p|^2 - r^2; and a quotient with the root and its sums.
const GIVEN_AR2: f32 = 11.0;
const GIVEN_GG: f32 = 5.0;
const GIVEN_POWER: f32 = 11.0;
const GIVEN_QUOTIENT: f32 = 18.0;
// |d|^2 in the discriminant and in t, of the tilt; not in UNIT.
const GIVEN_TILTS: f32 = 3.0;
const GIVEN_STEP: f32 = 3.725290298461914e-9; // 2^-28, of the grid of places
