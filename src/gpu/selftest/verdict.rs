//! The verdict on the arithmetic of an adapter.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One check of the adapter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// The operation that was checked.
    pub name: String,
    /// Whether every case gave the expected result. Some checks may fail: a plain TwoSum fails where the compiler
    /// reassociates, which WGSL allows.
    pub passed: bool,
    /// The figures: cases, wrong results, largest errors.
    pub detail: BTreeMap<String, f64>,
}

/// The rounding direction of f32 sums.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rounding {
    /// To nearest, ties to even: IEEE 754's default.
    NearestEven,
    /// Toward zero.
    TowardZero,
    /// Neither, or not consistently.
    Other,
}

/// Whether an arithmetic wider than f32 can be used.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Usable {
    /// The implementation, if it can be used.
    pub by: Option<String>,
    /// The reason, if it cannot.
    pub reason: Option<String>,
    /// Largest observed error: for f64 in ulps from IEEE 754, for double-float in units of 2^-48 of the result.
    pub worst: f64,
}

/// The measured arithmetic of an adapter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Whether f32 satisfies what WGSL guarantees and the certificate requires: + - * rounded in either direction, no
    /// distribution of products over differences, division within 2.5 ulp, square root within 4.6 u (u = 2^-23).
    pub f32: bool,
    /// Whether the device places spheres with the bits of f64, by integers. If not, the host bins them.
    pub places: bool,
    /// Whether the production kernels give the bits of their CPU twins.
    pub strict_twin: bool,
    /// The rounding direction of f32 sums.
    pub rounding: Rounding,
    /// Largest error of f32 division, ulp.
    pub div_ulp: f64,
    /// Largest error of f32 sqrt, ulp.
    pub sqrt_ulp: f64,
    /// Largest error of f32 inverseSqrt, ulp.
    pub inverse_sqrt_ulp: f64,
    /// Whether arithmetic reads subnormals as zero or writes zero instead of them.
    pub flushes_subnormals: bool,
    /// Double-float: unevaluated sums of two f32.
    pub double_float: Usable,
    /// f64 in shaders.
    pub f64: Usable,
    /// Every check.
    pub checks: Vec<Check>,
    /// Duration of the test on the adapter and the host, in milliseconds.
    pub milliseconds: f64,
}

impl Verdict {
    /// A summary of a few lines.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let f32 = if self.f32 { "as WGSL promises" } else { "NOT AS WGSL PROMISES" };
        let twin =
            if self.strict_twin { "kernels equal their CPU twins" } else { "kernels differ from their CPU twins" };
        let places = if self.places { "" } else { "; SPHERES ARE NOT PLACED AS IN F64" };
        let rounding = match self.rounding {
            Rounding::NearestEven => "nearest-even",
            Rounding::TowardZero => "toward-zero",
            Rounding::Other => "other",
        };
        let subnormals = if self.flushes_subnormals { "flushed" } else { "kept" };
        let usable = |u: &Usable| match (&u.by, &u.reason) {
            (Some(by), _) => by.clone(),
            (None, reason) => format!("not used: {}", reason.as_deref().unwrap_or("no reason was given")),
        };
        let (div, sqrt) = (self.div_ulp, self.sqrt_ulp);
        vec![
            format!(
                "f32 {f32}, rounds {rounding}, / {div:.3} ulp, sqrt {sqrt:.3} ulp, subnormals {subnormals}; {twin}{places}"
            ),
            format!("f64 {}", usable(&self.f64)),
            format!("double-float {}", usable(&self.double_float)),
        ]
    }
}

/// The largest error of division that WGSL allows, in ulps. Section "The model of f32" of docs/certificate.md.
pub(super) const DIV_ULP: f64 = 2.5;

/// The largest error of sqrt: 1/inverseSqrt, 2 and 2.5 ulp, and their product.
/// Section "The model of f32" of docs/certificate.md.
pub(super) const SQRT_ULP: f64 = 4.6;
