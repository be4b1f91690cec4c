//! The constants of the proof: docs/certificate.md derives them. shaders/certify/constants.wgsl has the same names, and
//! gpu/layout.rs compares each.

macro_rules! constants {
    ($($(#[$doc:meta])* const $name:ident = $value:literal;)*) => {
        $($(#[$doc])* pub(crate) const $name: f32 = $value;)*

        /// All of them, by their names in WGSL.
        #[cfg(test)]
        pub(crate) const ALL: &[(&str, f32)] = &[$((stringify!($name), $name)),*];
    };
}

constants! {
    /// 2^-23: WGSL rounds either way.
    const UNIT = 1.192_092_9e-7;
    /// 2^-48: what the host's f64 rotation leaves in a component of p of a general sphere.
    const HOST = 3.552_713_7e-15;
    /// How many of them p.d and a component of p x d hold, for each unit of |d|_1.
    const HOST_PARTS = 2.0;
    /// 2^-43: and in a projected sphere's depth, of itself.
    const DEPTH = 1.136_868_4e-13;
    /// 1 + 2^-10: the bounds are computed in f32 themselves.
    const INFLATE = 1.000_976_6;
    /// 2^-100: what flushed subnormals leave, times |d|^2.
    const VANISH = 7.888_609e-31;
    /// The depth of nothing: above every lower bound, and so far below the largest f32 that no sum with a depth overflows.
    /// Lower bounds are below 2^124: a frame spans 2^240, and its unit is in the middle.
    const BEYOND = 8.507_059e37;
    /// No point of a sphere is as deep in its record's unit: |p| and r are below 2 in every component.
    const FAR = 8.0;
    /// Radians promised, less the roundings of the unit vector.
    const NORMAL = 0.97e-3;
    /// The share of the least root that a difference with it must keep, lest its sign be open.
    const CLEAR = 0.75;

    // How many units each term is off by. Names end in _SLANT for each unit of |d|^2 - 1, in _A for each unit of |d|^2.

    /// |d|^2 rho^2 of a projected sphere's discriminant.
    const RHO2 = 9.0;
    /// Likewise.
    const RHO2_SLANT = 13.0;
    /// The offset's square in it.
    const OFFSET2 = 10.0;
    /// Likewise.
    const OFFSET2_SLANT = 17.2;
    /// The depth of a projected sphere: the whole.
    const TOTAL = 12.0;
    /// Likewise.
    const TOTAL_SLANT = 6.0;
    /// The slope along the offset.
    const ALONG = 6.0;
    /// The root.
    const ROOT = 6.2;
    /// The centre.
    const CENTER = 3.5;
    /// The normal of a projected sphere.
    const TURN = 4.0;
    /// p.d of a general sphere where it starts.
    const START = 2.5;
    /// And how it goes from there.
    const STEP = 3.5;
    /// b^2 of its discriminant b^2 - a c.
    const B2 = 3.0;
    /// |a c| of it.
    const AC_A = 6.0;
    /// Likewise.
    const AC = -0.5;
    /// a r^2 of its discriminant a r^2 - g.g.
    const AR2_A = 7.0;
    /// Likewise.
    const AR2 = 2.0;
    /// g.g of it.
    const GG = 5.0;
    /// A component of g = p x d.
    const G = 4.0;
    /// The depth of a general sphere as the quotient c/q.
    const QUOTIENT = 15.0;
    /// As a sum of b and the root, times the reciprocal of |d|^2.
    const SUM_A = 6.0;
    /// Likewise.
    const SUM = 11.0;
}
