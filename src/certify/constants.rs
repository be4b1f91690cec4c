//! The constants of the proof, derived in docs/certificate.md. shaders/certify/constants.wgsl has the same names, and
//! gpu/layout.rs compares the values.

macro_rules! constants {
    ($($(#[$doc:meta])* const $name:ident = $value:literal;)*) => {
        $($(#[$doc])* pub(crate) const $name: f32 = $value;)*

        /// All constants by their WGSL names.
        #[cfg(test)]
        pub(crate) const ALL: &[(&str, f32)] = &[$((stringify!($name), $name)),*];
    };
}

constants! {
    /// 2^-23: in WGSL rounding may go in either direction.
    const UNIT = 1.192_092_9e-7;
    /// 2^-48: error of the host's f64 rotation in a component of p of a general sphere.
    const HOST = 3.552_713_7e-15;
    /// Number of these errors in p.d and in a component of p x d, per unit of |d|_1.
    const HOST_PARTS = 2.0;
    /// 2^-43: relative error of the host in the depth of a projected sphere.
    const DEPTH = 1.136_868_4e-13;
    /// 1 + 2^-10: covers the rounding of the bounds, which are computed in f32 too.
    const INFLATE = 1.000_976_6;
    /// 2^-100: bound of the error from flushed subnormals, times |d|^2.
    const VANISH = 7.888_609e-31;
    /// The depth of a miss: above every lower bound, and so far below the largest f32 that no sum with a depth
    /// overflows. Lower bounds are below 2^124, since a frame spans 2^240 and its unit is in the middle.
    const BEYOND = 8.507_059e37;
    /// Above the depth of every point of a sphere in the unit of its record: |p| and r are below 2 in every component.
    const FAR = 8.0;
    /// The promised angle of normals in radians, less the rounding of the unit vector.
    const NORMAL = 0.97e-3;
    /// The fraction of the smallest root that a difference with it has to exceed for its sign to be certain.
    const CLEAR = 0.75;

    // The error of each term in units of the last place. Names end in _SLANT per unit of |d|^2 - 1, in _A per unit of
    // |d|^2.

    /// |d|^2 rho^2 of a projected sphere's discriminant.
    const RHO2 = 9.0;
    /// The same per unit of |d|^2 - 1.
    const RHO2_SLANT = 13.0;
    /// The square of the offset in that discriminant.
    const OFFSET2 = 10.0;
    /// The same per unit of |d|^2 - 1.
    const OFFSET2_SLANT = 17.2;
    /// The depth of a projected sphere, by the total: |slope along the offset| + root.
    const TOTAL = 12.0;
    /// The same per unit of |d|^2 - 1.
    const TOTAL_SLANT = 6.0;
    /// The depth of a projected sphere, by the slope along the offset, as the sum of the sizes of its two products.
    const ALONG = 6.0;
    /// The depth of a projected sphere, by the root.
    const ROOT = 6.2;
    /// The depth of a projected sphere, by the size of its centre's depth relative to the reference.
    const CENTER = 3.5;
    /// The normal of a projected sphere.
    const TURN = 4.0;
    /// A normal from which rays leave: its parts, the unit vector, its rotation into the world; and a point from there.
    #[cfg(test)]
    const SURFACE = 40.0;
    /// The way from the eye to a point from which rays leave, relative to its length.
    #[cfg(test)]
    const WAY = 18.0;
    /// p.d of a general sphere: the start value.
    const START = 2.5;
    /// p.d of a general sphere: the increment.
    const STEP = 3.5;
    /// b^2 in the discriminant b^2 - a c.
    const B2 = 3.0;
    /// |a c| in that discriminant, per unit of |d|^2.
    const AC_A = 6.0;
    /// The same, constant part.
    const AC = -0.5;
    /// a r^2 in the discriminant a r^2 - g.g, per unit of |d|^2.
    const AR2_A = 7.0;
    /// The same, constant part.
    const AR2 = 2.0;
    /// g.g in that discriminant.
    const GG = 5.0;
    /// A component of g = p x d.
    const G = 4.0;
    /// The depth of a general sphere as the quotient c/q.
    const QUOTIENT = 15.0;
    /// As a sum of b and the root, times the reciprocal of |d|^2, per unit of |d|^2.
    const SUM_A = 6.0;
    /// The same, constant part.
    const SUM = 11.0;
    /// The depth of a plane as a quotient, and the product with an error.
    const PLANE_QUOTIENT = 4.0;
}

/// The constants for given rays on devices. On the host only tests use them. shaders/certify/given_constants.wgsl has
/// the same names.
#[cfg(test)]
pub(crate) mod given {
    constants! {
        /// Error of p.d and of the components of g = p x d of a given ray, relative to |p| |d|.
        const GIVEN_CROSS = 8.0;
        /// The same by the blur of places, in multiples of blur times |d|, not of UNIT.
        const GIVEN_BLURS = 2.0;
        /// a r^2 in the discriminant a r^2 - g.g of a given ray.
        const GIVEN_AR2 = 11.0;
        /// g.g in that discriminant.
        const GIVEN_GG = 5.0;
        /// Error of the power |p|^2 - r^2, relative to |p|^2 + r^2.
        const GIVEN_POWER = 11.0;
        /// t as a quotient, with the root and the sums in it.
        const GIVEN_QUOTIENT = 18.0;
        /// Relative error of |d|^2 in the discriminant and in t, in multiples of the direction's tilt, not of UNIT.
        const GIVEN_TILTS = 3.0;
        /// 2^-28, the step of the grid on which places of given rays and of their spheres are stated.
        const GIVEN_STEP = 3.725_290_3e-9;
    }
}
