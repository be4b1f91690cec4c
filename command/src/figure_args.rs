//! Figures without pixels as options: their groups and their detail.

use super::typed::Typed;
use clap::Args;
use halfline::quote::setting::{DETAIL, GROUP};
use halfline_drawing::figure::FigureStyle;

/// The options for figures without pixels.
#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(super) struct FigureArgs {
    #[command(flatten)]
    typed: Typed,
    /// Divides the paths of a figure (.svg, .pdf) into groups by a column, such as residue, chain or element; several give groups of all
    /// their values. With --shade flat all of one colour in a group is one path [default: a path for each sphere].
    #[arg(long, value_name = "COLUMN")]
    pub(super) group: Vec<String>,
    /// Leaves out of a figure what is smaller than so many pixels [default: 0.1].
    #[arg(long, value_name = "PIXELS", value_parser = detail, allow_negative_numbers = true)]
    detail: Option<f64>,
}

/// The largest detail, pixels.
const MOST_DETAIL: f64 = 100.0;

fn detail(text: &str) -> Result<f64, String> {
    let pixels = text.parse().ok().filter(|pixels| (0.0..=MOST_DETAIL).contains(pixels));
    pixels.ok_or_else(|| format!("expected a number of pixels from 0 to {MOST_DETAIL}"))
}

impl FigureArgs {
    /// The columns of the groups.
    pub(super) fn groups(&self) -> &[String] {
        let is_sphere = self.group.iter().all(|word| word.eq_ignore_ascii_case("sphere"));
        if is_sphere { &[] } else { &self.group }
    }

    /// The detail, pixels.
    pub(super) fn detail(&self) -> f64 {
        self.detail.unwrap_or(FigureStyle::DETAIL)
    }

    /// The option that is given on the command line, if one is.
    pub(super) fn given(&self) -> Option<&'static str> {
        [("group", GROUP), ("detail", DETAIL)].into_iter().find(|(id, _)| self.typed.has(id)).map(|(_, option)| option)
    }
}
