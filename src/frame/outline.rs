//! The lines that silhouettes draw.

use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::{OUTLINE_COLOR, OUTLINE_WIDTH, SILHOUETTE};
use serde::Serialize;

/// Width and colour of the lines of silhouettes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Outline {
    /// The width in pixels of the full frame. A line narrower than [`Outline::LEAST_FULL`] is that wide and paler.
    pub width: f64,
    /// Linear RGB.
    pub color: [f32; 3],
}

impl Outline {
    /// The least and the largest width, pixels.
    pub const WIDTHS: [f64; 2] = [0.1, 40.0];

    /// The width of the narrowest line in its full colour, pixels, and the default.
    pub const LEAST_FULL: f64 = 1.3;

    /// The outline with this width and this colour, where they are given.
    #[must_use]
    pub fn of(width: Option<f64>, color: Option<[f32; 3]>) -> Self {
        let usual = Self::default();
        Self { width: width.unwrap_or(usual.width), color: color.unwrap_or(usual.color) }
    }

    /// Checks the width and the colour.
    ///
    /// # Errors
    /// [`Error::Settings`] for a width out of range, and for a colour that is negative or not finite.
    pub fn check(&self) -> Result<()> {
        let [least, most] = Self::WIDTHS;
        if !(least..=most).contains(&self.width) {
            let problem = format!("{OUTLINE_WIDTH} is {}", self.width);
            return Err(Error::settings(problem, format!("give a number of pixels from {least} to {most}")));
        }
        if !self.color.iter().all(|c| c.is_finite() && *c >= 0.0) {
            return Err(Error::settings(
                format!("{OUTLINE_COLOR} is negative or not finite"),
                "give linear RGB, 0 or more",
            ));
        }
        Ok(())
    }

    /// Warnings about a width and a colour that are given where no outline is drawn: in a picture without silhouettes, or
    /// without a picture.
    #[must_use]
    pub fn idle([width, color]: [bool; 2], has_picture: bool, silhouette: bool) -> Vec<String> {
        let why = match (has_picture, silhouette) {
            (true, true) => return Vec::new(),
            (true, false) => format!("the picture has no {SILHOUETTE}"),
            (false, _) => "no picture is requested".to_owned(),
        };
        let given = [(width, OUTLINE_WIDTH), (color, OUTLINE_COLOR)].into_iter().filter(|(given, _)| *given);
        given.map(|(_, setting)| format!("{setting} changes nothing: {why}")).collect()
    }
}

impl Default for Outline {
    fn default() -> Self {
        Self { width: Self::LEAST_FULL, color: [0.0; 3] }
    }
}
