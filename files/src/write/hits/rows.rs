//! The answers to a block of rays as columns: of numbers for archives and clouds, or as lines of text.

use crate::write::encode::plain;
use halfline::parallel;
use halfline::render::trace::echoes::{Echo, Echoes};
use halfline::render::trace::{Hits, Occlusion, Rays};
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::ops::Range;

/// The question that the rays answer, which gives a file of hits its columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Query {
    /// The nearest hit: columns `id`, `t`, `distance`, `normal` (`nx,ny,nz` in .csv) and `certainty`, as in [`Hits`], and in
    /// .npz `position`, origin + t direction in f64, NaN on a miss.
    Nearest,
    /// Whether there is any hit: columns `hit` and `certainty`, as in [`Occlusion`].
    Any,
    /// The echoes of a scanner's beams, a row for each: columns `ring`, `column`, `return_number`, `number_of_returns`, `id`,
    /// `distance`, `intensity`, `position` (`x,y,z` in .csv) and `certainty`, as in [`Echo`].
    Echoes,
}

/// The certainty of a row without a valid ray, and of an answer that is not certified.
const UNCERTIFIED: u8 = 255;

/// A column of the answers: its name in .npz, its type by NumPy's name, and its numbers per row.
pub(super) type Column = (&'static str, &'static str, u64);

const NEAREST: [Column; 6] = [
    ("id", "<i4", 1),
    ("t", "<f8", 1),
    ("distance", "<f8", 1),
    ("normal", "<f4", 3),
    ("position", "<f8", 3),
    ("certainty", "|u1", 1),
];

const ECHOES: [Column; 9] = [
    ("ring", "<u4", 1),
    ("column", "<u4", 1),
    ("return_number", "|u1", 1),
    ("number_of_returns", "|u1", 1),
    ("id", "<i4", 1),
    ("distance", "<f8", 1),
    ("intensity", "<f4", 1),
    ("position", "<f8", 3),
    ("certainty", "|u1", 1),
];

const ANY: [Column; 2] = [("hit", "|u1", 1), ("certainty", "|u1", 1)];

impl Query {
    pub(super) fn columns(self) -> &'static [Column] {
        match self {
            Self::Nearest => &NEAREST,
            Self::Any => &ANY,
            Self::Echoes => &ECHOES,
        }
    }

    pub(super) fn header(self) -> &'static str {
        match self {
            Self::Nearest => "id,t,distance,nx,ny,nz,certainty\n",
            Self::Any => "hit,certainty\n",
            Self::Echoes => "ring,column,return_number,number_of_returns,id,distance,intensity,x,y,z,certainty\n",
        }
    }
}

/// The columns of a block.
pub(super) enum Rows<'a> {
    Nearest {
        id: Cow<'a, [i32]>,
        t: Cow<'a, [f64]>,
        distance: Cow<'a, [f64]>,
        normal: Cow<'a, [[f32; 3]]>,
        position: Cow<'a, [[f64; 3]]>,
        certainty: Cow<'a, [u8]>,
    },
    Any {
        hit: Cow<'a, [u8]>,
        certainty: Cow<'a, [u8]>,
    },
    Echoes(&'a Echoes),
}

/// Rows of text that are made together, and those that a thread makes at a time.
const LINES: usize = 1 << 16;
const PART: usize = 1 << 11;

impl<'a> Rows<'a> {
    /// The nearest hits of rays, and misses at the places `invalid`; `None` for hits without normals.
    pub(super) fn nearest(rays: &Rays<'_>, hits: &'a Hits, invalid: &[u32]) -> Option<Self> {
        let position = |n: usize| if hits.id[n] < 0 { [f64::NAN; 3] } else { rays.at(n, hits.t[n]) };
        // By this thread, since the others may be tracing the next block.
        let mut position: Vec<[f64; 3]> = (0..hits.t.len()).map(position).collect();
        if !invalid.is_empty() {
            position = spread(&position, invalid, [f64::NAN; 3]).into_owned();
        }
        Some(Self::Nearest {
            id: spread(&hits.id, invalid, -1),
            t: spread(&hits.t, invalid, f64::INFINITY),
            distance: spread(&hits.distance, invalid, f64::INFINITY),
            normal: spread(hits.normal.as_ref()?, invalid, [0.0; 3]),
            position: position.into(),
            certainty: spread(&hits.certainty, invalid, UNCERTIFIED),
        })
    }

    /// Whether rays hit anything, and misses at the places `invalid`.
    pub(super) fn any(occlusion: &'a Occlusion, invalid: &[u32]) -> Self {
        Self::Any {
            hit: spread(&occlusion.hit, invalid, 0),
            certainty: spread(&occlusion.certainty, invalid, UNCERTIFIED),
        }
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Nearest { certainty, .. } | Self::Any { certainty, .. } => certainty.len(),
            Self::Echoes(echoes) => echoes.all.len(),
        }
    }

    /// The bytes of each column in .npy.
    pub(super) fn columns(&self) -> Vec<Cow<'_, [u8]>> {
        match self {
            Self::Nearest { id, t, distance, normal, position, certainty } => vec![
                plain(id, i32::to_le_bytes),
                plain(t, f64::to_le_bytes),
                plain(distance, f64::to_le_bytes),
                plain(normal.as_flattened(), f32::to_le_bytes),
                plain(position.as_flattened(), f64::to_le_bytes),
                Cow::Borrowed(certainty),
            ],
            Self::Any { hit, certainty } => vec![Cow::Borrowed(hit), Cow::Borrowed(certainty)],
            Self::Echoes(echoes) => vec![
                column(echoes, |echo| echo.ring.to_le_bytes()),
                column(echoes, |echo| echo.column.to_le_bytes()),
                column(echoes, |echo| [echo.return_number]),
                column(echoes, |echo| [echo.number_of_returns]),
                column(echoes, |echo| echo.id.to_le_bytes()),
                column(echoes, |echo| echo.distance.to_le_bytes()),
                column(echoes, |echo| echo.intensity.to_le_bytes()),
                column(echoes, |echo| echo.position.into_iter().flat_map(f64::to_le_bytes)),
                column(echoes, |echo| [echo.certainty]),
            ],
        }
    }

    pub(super) fn write_text(&self, out: &mut dyn Write) -> io::Result<()> {
        for first in (0..self.len()).step_by(LINES) {
            let last = self.len().min(first + LINES);
            let parts = parallel::blocks(first..last, PART, &|_, rows| self.text(rows));
            parts.iter().try_for_each(|text| out.write_all(text.as_bytes()))?;
        }
        Ok(())
    }

    /// Lines of CSV, each number with the fewest digits that give it again.
    fn text(&self, rows: Range<usize>) -> String {
        let mut text = String::with_capacity(64 * rows.len());
        for row in rows {
            // Writing to a String does not fail.
            let _ = match self {
                Self::Nearest { id, t, distance, normal, certainty, .. } => {
                    let (id, t, distance, certainty) = (id[row], t[row], distance[row], certainty[row]);
                    let [x, y, z] = normal[row];
                    writeln!(text, "{id},{t:?},{distance:?},{x:?},{y:?},{z:?},{certainty}")
                }
                Self::Any { hit, certainty } => writeln!(text, "{},{}", hit[row], certainty[row]),
                Self::Echoes(echoes) => {
                    let Echo { ring, column, return_number, number_of_returns, .. } = echoes.all[row];
                    let Echo { id, distance, intensity, position: [x, y, z], certainty, .. } = echoes.all[row];
                    let place = format_args!("{ring},{column},{return_number},{number_of_returns}");
                    writeln!(text, "{place},{id},{distance:?},{intensity:?},{x:?},{y:?},{z:?},{certainty}")
                }
            };
        }
        text
    }
}

/// A column of echoes as bytes of .npy.
fn column<B: IntoIterator<Item = u8>>(echoes: &Echoes, bytes: impl Fn(&Echo) -> B) -> Cow<'static, [u8]> {
    echoes.all.iter().flat_map(bytes).collect()
}

/// The values of valid rows, with `fill` at the places of the invalid ones.
fn spread<'a, T: Copy>(values: &'a [T], invalid: &[u32], fill: T) -> Cow<'a, [T]> {
    if invalid.is_empty() {
        return Cow::Borrowed(values);
    }
    let (mut values, mut invalid) = (values.iter(), invalid.iter().peekable());
    let row = |row: u32| invalid.next_if(|place| **place == row).map_or_else(|| values.next().copied(), |_| Some(fill));
    Cow::Owned((0..).map_while(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_rows_are_between_the_others() {
        assert_eq!(*spread(&[1, 2, 3], &[0, 1, 4], -1), [-1, -1, 1, 2, -1, 3]);
        assert_eq!(*spread(&[1, 2], &[2, 3], -1), [1, 2, -1, -1]);
        assert_eq!(*spread(&[], &[0], -1), [-1]);
        assert!(matches!(spread(&[1], &[], -1), Cow::Borrowed([1])));
    }
}
