//! The source of the colours of particles.

use super::paint::Paint;
use super::scale::Scale;
use halfline::error::{Error, Result};
use halfline::quote::setting::{COLOR, COLOR_BY, LOG, MAP, NAN_COLOR, RANGE};

/// The source of the colours.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Coloring {
    /// The file's colours, else the elements' colours, else none.
    #[default]
    File,
    /// The elements' colours, even if the file has colours.
    Element,
    /// One linear RGB for all.
    One([f32; 3]),
    /// A column of numbers through a colour map.
    Column(Scale),
}

impl Coloring {
    /// The colours that options ask for: one for all, or colours of columns with commas between them, by the map, the range and the
    /// logarithm of a scale.
    ///
    /// # Errors
    /// [`Error::Settings`] for one colour and columns, and for a map, a range or a logarithm without columns.
    pub fn of(all: Option<Paint>, columns: Option<&str>, scale: Scale) -> Result<Self> {
        let given = [
            (MAP, scale.map.is_some()),
            (RANGE, scale.range.is_some()),
            (LOG, scale.log),
            (NAN_COLOR, scale.nan_color.is_some()),
        ];
        if let (None | Some("element"), Some((option, _))) =
            (columns, given.into_iter().find(|(_, is_given)| *is_given))
        {
            let problem = format!("{option} belongs to the colours of a column");
            return Err(Error::settings(problem, format!("add {COLOR_BY} COLUMN, or remove {option}")));
        }
        if scale.range.is_some_and(|[low, high]| low == high) {
            return Err(Error::settings(format!("the ends of {RANGE} are equal"), "give two different ones"));
        }
        Ok(match (all, columns) {
            (Some(_), Some(_)) => {
                let problem = format!("{COLOR} for all spheres and {COLOR_BY} exclude each other");
                let mend = format!("remove one of them, or colour selected spheres with {COLOR} 'EXPR=COLOR'");
                return Err(Error::settings(problem, mend));
            }
            (Some(Paint::One(color)), None) => Self::One(color),
            (Some(Paint::Element), None) | (None, Some("element")) => Self::Element,
            (None, Some(names)) => {
                let columns = names.split(',').map(|name| name.trim().to_owned()).collect();
                Self::Column(Scale { columns, ..scale })
            }
            (None, None) => Self::File,
        })
    }
}
