//! The constants of the proof, derived in docs/certificate.md: each comment names the section, and the table "Constants" there lists them
//! all (tests/constants.rs compares both). shaders/certify/constants.wgsl has the same names, and gpu/layout.rs compares the values.

macro_rules! constants {
    ($($(#[$doc:meta])* const $name:ident = $value:literal;)*) => {
        $($(#[$doc])* pub(crate) const $name: f32 = $value;)*

        /// All constants by their WGSL names.
        #[cfg(test)]
        pub(crate) const ALL: &[(&str, f32)] = &[$((stringify!($name), $name)),*];
    };
}

constants! {
    /// 2^-23: in WGSL rounding may go in either direction. Section "The model of f32".
    const UNIT = 1.192_092_9e-7;
    /// 2^-48: error of the host's f64 rotation in a component of p of a general sphere. Section 3.
    const HOST = 3.552_713_7e-15;
    /// Number of these errors in p.d and in a component of p x d, per unit of |d|_1. Section 3.
    const HOST_PARTS = 2.0;
    /// 2^-43: relative error of the host in the depth of a projected sphere. Section 2.
    const DEPTH = 1.136_868_4e-13;
    /// 1 + 2^-10: covers the rounding of the bounds, which are computed in f32 too. Section "The model of f32".
    const INFLATE = 1.000_976_6;
    /// 2^-100: bound of the error from flushed subnormals, times |d|^2. Section "The model of f32".
    const VANISH = 7.888_609e-31;
    /// The depth of a miss: above every lower bound, and so far below the largest f32 that no sum with a depth
    /// overflows. Lower bounds are below 2^124, since a frame spans 2^240 and its unit is in the middle. Section 4.
    const BEYOND = 8.507_059e37;
    /// Above the depth of every point of a sphere in the unit of its record: |p| is below 2 sqrt 3 and r below 2.
    /// Section 3.
    const FAR = 8.0;
    /// The promised angle of normals in radians, less the rounding of the unit vector. Section 2.
    const NORMAL = 0.97e-3;
    /// The fraction of the smallest root that a difference with it has to exceed for its sign to be certain. Section 3.
    const CLEAR = 0.75;

    // The error of each term in units of the last place. Names end in _SLANT per unit of |d|^2 - 1, in _A per unit of
    // |d|^2.

    /// |d|^2 rho^2 of a projected sphere's discriminant. Section 2.
    const RHO2 = 9.0;
    /// |d|^2 rho^2 there, per unit of |d|^2 - 1. Section 2.
    const RHO2_SLANT = 13.0;
    /// The square of the offset in that discriminant. Section 2.
    const OFFSET2 = 10.0;
    /// The square of the offset there, per unit of |d|^2 - 1. Section 2.
    const OFFSET2_SLANT = 17.2;
    /// The depth of a projected sphere, by the total: |slope along the offset| + root. Section 2.
    const TOTAL = 12.0;
    /// The depth of a projected sphere, by the total, per unit of |d|^2 - 1. Section 2.
    const TOTAL_SLANT = 6.0;
    /// The depth of a projected sphere, by the slope along the offset, as the sum of the sizes of its two products.
    /// Section 2.
    const ALONG = 6.0;
    /// The depth of a projected sphere, by the root. Section 2.
    const ROOT = 6.2;
    /// The depth of a projected sphere, by the size of its centre's depth relative to the reference. Section 2.
    const CENTER = 3.5;
    /// The normal of a projected sphere. Section 2.
    const TURN = 4.0;
    /// A normal from which rays leave: its parts, the unit vector, its rotation into the world; and a point from there.
    /// Section 13.
    #[cfg(test)]
    const SURFACE = 40.0;
    /// The way from the eye to a point from which rays leave, relative to its length. Section 13.
    #[cfg(test)]
    const WAY = 18.0;
    /// p.d of a general sphere: the start value. Section 3.
    const START = 2.5;
    /// p.d of a general sphere: the increment. Section 3.
    const STEP = 3.5;
    /// b^2 in the discriminant b^2 - a c. Section 3.
    const B2 = 3.0;
    /// |a c| in that discriminant, per unit of |d|^2. Section 3.
    const AC_A = 6.0;
    /// |a c| in that discriminant, constant part. Section 3.
    const AC = -0.5;
    /// a r^2 in the discriminant a r^2 - g.g, per unit of |d|^2. Section 3.
    const AR2_A = 7.0;
    /// a r^2 in that discriminant, constant part. Section 3.
    const AR2 = 2.0;
    /// g.g in that discriminant. Section 3.
    const GG = 5.0;
    /// A component of g = p x d. Section 3.
    const G = 4.0;
    /// The depth of a general sphere as the quotient c/q. Section 3.
    const QUOTIENT = 15.0;
    /// The depth of a general sphere as a sum of b and the root, times the reciprocal of |d|^2, per unit of |d|^2.
    /// Section 3.
    const SUM_A = 6.0;
    /// The depth of a general sphere as that sum, constant part. Section 3.
    const SUM = 11.0;
    /// The depth of a plane as a quotient, and the product with an error. Section 9a.
    const PLANE_QUOTIENT = 4.0;
}

/// The constants for given rays on devices. On the host only tests use them. shaders/certify/given_constants.wgsl has
/// the same names.
#[cfg(test)]
pub(crate) mod given {
    constants! {
        /// Error of p.d and of the components of g = p x d of a given ray, relative to |p| |d|. Section 9.
        const GIVEN_CROSS = 8.0;
        /// Error of p.d and of the components of g by the blur of places, in multiples of blur times |d|, not of UNIT.
        /// Section 9.
        const GIVEN_BLURS = 2.0;
        /// a r^2 in the discriminant a r^2 - g.g of a given ray. Section 9.
        const GIVEN_AR2 = 11.0;
        /// g.g in that discriminant. Section 9.
        const GIVEN_GG = 5.0;
        /// Error of the power |p|^2 - r^2, relative to |p|^2 + r^2. Section 9.
        const GIVEN_POWER = 11.0;
        /// t as a quotient, with the root and the sums in it. Section 9.
        const GIVEN_QUOTIENT = 18.0;
        /// Relative error of |d|^2 in the discriminant and in t, in multiples of the direction's tilt, not of UNIT.
        /// Section 13.
        const GIVEN_TILTS = 3.0;
        /// 2^-28, the step of the grid on which places of given rays and of their spheres are stated. Section 9.
        const GIVEN_STEP = 3.725_290_3e-9;
    }
}
