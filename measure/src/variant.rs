//! The methods of a measurement: each form of the quadratic alone, certified, and exact.

use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::intersect::Method;
use halfline::settings::{Accuracy, Backend, Settings, Tolerance};
use std::str::FromStr;

/// A method of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variant {
    /// One intersection method, uncertified.
    Alone(Method),
    /// f32 with a proof, and exact arithmetic for unsure pixels.
    Certified,
    /// Every pixel in exact arithmetic, on the host.
    Exact,
}

impl Variant {
    /// All methods: [`Method::ALL`], certified, exact.
    #[must_use]
    pub fn all() -> Vec<Self> {
        Method::ALL.iter().copied().map(Self::Alone).chain([Self::Certified, Self::Exact]).collect()
    }

    /// The name in records.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Alone(method) => method.name(),
            Self::Certified => Accuracy::Certified.name(),
            Self::Exact => Accuracy::Exact.name(),
        }
    }

    /// The settings that render the buffers `aovs` this way.
    pub(crate) fn settings(self, backend: Backend, tolerance: Tolerance, aovs: &[Aov]) -> Settings {
        let (method, accuracy) = match self {
            Self::Alone(method) => (Some(method), Accuracy::Fast),
            Self::Certified => (None, Accuracy::Certified),
            Self::Exact => (None, Accuracy::Exact),
        };
        let tolerance = Some(tolerance);
        Settings { backend, method, accuracy, tolerance, aovs: aovs.to_vec(), ..Settings::default() }
    }
}

impl FromStr for Variant {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self, Error> {
        halfline::error::by_name("method", name, &Self::all(), Self::name)
    }
}
