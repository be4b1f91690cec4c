// The constants of the proof: docs/certificate.md derives them. src/certify/constants.rs has the same names, and a test
// compares the values.

const UNIT: f32 = 1.1920928955078125e-7;      // 2^-23: WGSL rounds either way
const HOST: f32 = 3.552713678800501e-15;      // 2^-48: error of the host's f64 rotation in a component of p
const HOST_PARTS: f32 = 2.0;                  // multiples of HOST in p.d and in a component of p x d, times |d|_1
const DEPTH: f32 = 1.1368683772161603e-13;    // 2^-43: relative error of the host in a projected sphere's depth
const INFLATE: f32 = 1.0009765625;            // 1 + 2^-10: the bounds are computed in f32 themselves
const VANISH: f32 = 7.888609052210118e-31;    // 2^-100: error of flushed subnormals, times |d|^2
const BEYOND: f32 = 8.507059173023462e37;     // 2^126, the depth of a miss: above every lower bound, but no sum with a depth
                                              // overflows
const FAR: f32 = 8.0;                         // above the depth of every point of a sphere in its record's unit
const NORMAL: f32 = 0.97e-3;                  // promised angle in radians, less the roundings of the unit vector
const CLEAR: f32 = 0.75;                      // fraction of the least root that a difference with it must keep

// The error of each term in multiples of UNIT. Names end in _SLANT if it is times |d|^2 - 1, in _A if times |d|^2.

// The discriminant of a projected sphere: |d|^2 rho^2, and the offset's square.
const RHO2: f32 = 9.0;
const RHO2_SLANT: f32 = 13.0;
const OFFSET2: f32 = 10.0;
const OFFSET2_SLANT: f32 = 17.2;
// Its depth: the total, the slope along the offset, the root, the centre; and its normal.
const TOTAL: f32 = 12.0;
const TOTAL_SLANT: f32 = 6.0;
const ALONG: f32 = 6.0;
const ROOT: f32 = 6.2;
const CENTER: f32 = 3.5;
const TURN: f32 = 4.0;
// A normal from the hit: its parts, the unit vector, its rotation into the world; and a point from there: section 13.
const SURFACE: f32 = 40.0;
// The way from the eye to the hit, of its length.
const WAY: f32 = 18.0;
// p.d of a general sphere: the start value, and the steps from there.
const START: f32 = 2.5;
const STEP: f32 = 3.5;
// Its discriminant by b^2 - a c.
const B2: f32 = 3.0;
const AC_A: f32 = 6.0;
const AC: f32 = -0.5;
// Its discriminant by a r^2 - g.g, and a component of g = p x d.
const AR2_A: f32 = 7.0;
const AR2: f32 = 2.0;
const GG: f32 = 5.0;
const G: f32 = 4.0;
// Its depth: the quotient c/q; and a sum of b and the root times the reciprocal of |d|^2.
const QUOTIENT: f32 = 15.0;
const SUM_A: f32 = 6.0;
const SUM: f32 = 11.0;
// The depth of a plane: a quotient, and the product with an error.
const PLANE_QUOTIENT: f32 = 4.0;
