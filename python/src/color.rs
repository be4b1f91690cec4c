//! Colours of rules.

use halfline::error::Result;
use halfline_files::read::style::{self, Paint};
use pyo3::prelude::*;

/// Linear RGB, or the word for the colour of each particle's element.
#[derive(FromPyObject)]
pub(crate) enum Color {
    One([f32; 3]),
    Element(String),
}

impl Color {
    pub(crate) fn paint(&self) -> Result<Paint> {
        match self {
            Self::One(color) => Ok(Paint::One(*color)),
            Self::Element(word) if word == "element" => Ok(Paint::Element),
            Self::Element(name) => style::color(name).map(Paint::One),
        }
    }
}
