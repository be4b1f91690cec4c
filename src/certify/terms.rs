//! The constants of the bounds, as the kernel and its twin use them.

use super::constants::{
    AC, AC_A, ALONG, AR2, AR2_A, B2, CENTER, G, GG, OFFSET2, OFFSET2_SLANT, QUOTIENT, RHO2, RHO2_SLANT, ROOT, START,
    STEP, SUM, SUM_A, TOTAL, TOTAL_SLANT,
};

/// The constants of the bounds, in multiples of UNIT = 2^-23 (docs/certificate.md). A test removes each in turn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Terms {
    /// |d|^2 rho^2 of a projected sphere: constant part, and part per unit of |d|^2 - 1.
    pub(crate) rho2: [f32; 2],
    /// The square of the offset, likewise.
    pub(crate) offset2: [f32; 2],
    /// The depth of a projected sphere: total, total per unit of |d|^2 - 1, slope along the offset, root, centre.
    pub(crate) depth: [f32; 5],
    /// p.d of a general sphere: the start value, and the increment.
    pub(crate) along: [f32; 2],
    /// b^2; |a c| per unit of |d|^2 and constant.
    pub(crate) power: [f32; 3],
    /// a r^2 per unit of |d|^2 and constant; g.g; a component of g.
    pub(crate) cross: [f32; 4],
    /// t of a general sphere as c/q; as (b + sqrt D)/a, per unit of |d|^2 and constant.
    pub(crate) root: [f32; 3],
    /// Rounding on the host: projected centres, in units of their own last place.
    pub(crate) host: f32,
}

/// The derived constants.
pub(crate) const TERMS: Terms = Terms {
    rho2: [RHO2, RHO2_SLANT],
    offset2: [OFFSET2, OFFSET2_SLANT],
    depth: [TOTAL, TOTAL_SLANT, ALONG, ROOT, CENTER],
    along: [START, STEP],
    power: [B2, AC_A, AC],
    cross: [AR2_A, AR2, GG, G],
    root: [QUOTIENT, SUM_A, SUM],
    host: 1.0,
};
