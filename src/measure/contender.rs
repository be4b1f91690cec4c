//! What is measured: every form of the quadratic alone, the certified way and the exact one.

use crate::error::{Error, Result};
use crate::frame::Aov;
use crate::intersect::Method;
use crate::settings::{Accuracy, Backend, Search, Settings, Tolerance};
use std::str::FromStr;

/// A way to an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contender {
    /// One form of the quadratic and nothing else.
    Alone(Method),
    /// f32 with a proof, and better arithmetic for the rest.
    Certified,
    /// Every pixel in exact arithmetic, on the host.
    Exact,
}

impl Contender {
    /// All there are: [`Method::ALL`], certified, exact.
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

    /// Settings to render so for the buffers `aovs`. A form alone asks all spheres where `search` leaves it open, so
    /// that its errors are its own.
    pub(crate) fn settings(self, backend: Backend, tolerance: Tolerance, search: Search, aovs: &[Aov]) -> Settings {
        let (method, accuracy) = match self {
            Self::Alone(method) => (Some(method), Accuracy::Fast),
            Self::Certified => (None, Accuracy::Certified),
            Self::Exact => (None, Accuracy::Exact),
        };
        let search = if search == Search::Auto && method.is_some() { Search::All } else { search };
        let tolerance = Some(tolerance);
        Settings { backend, method, accuracy, search, tolerance, aovs: aovs.to_vec(), ..Settings::default() }
    }
}

impl FromStr for Contender {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self, Error> {
        crate::error::by_name("method", name, &Self::all(), Self::name)
    }
}
