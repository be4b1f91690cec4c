//! The header of LAMMPS data.

use crate::input::Input;
use crate::lines::{Lines, Words};
use halfline_ground::Cell;
use halfline_ground::error::Result;
use halfline_ground::quote::quote;

/// The content of the header.
#[derive(Default)]
pub(super) struct DataHeader {
    pub(super) atoms: Option<u64>,
    pub(super) types: u64,
    /// Whether the file has ellipsoids, lines, triangles or bodies, whose atoms have different columns.
    pub(super) shaped: bool,
    low: [f64; 3],
    high: [f64; 3],
    tilt: [f64; 3],
    bounded: bool,
    general: [Option<[f64; 3]>; 4],
}

impl DataHeader {
    /// The header, up to the line of the first section, which becomes the current one.
    pub(super) fn read(lines: &mut Lines<Input>) -> Result<Self> {
        let mut head = Self::default();
        while lines.advance()? {
            let line = body(lines);
            if line.starts_with(|c: char| c.is_ascii_uppercase()) {
                break;
            }
            let words: Vec<&str> = line.split_whitespace().take(8).collect();
            let finite = |n: usize| -> Result<[f64; 3]> {
                let mut numbers = [0.0; 3];
                for (number, word) in numbers[..n].iter_mut().zip(Words::of(lines)) {
                    *number = word.finite("header")?;
                }
                Ok(numbers)
            };
            let whole = || {
                words[0].parse().map_err(|_| {
                    let problem = format!("{} is not a number of {}", quote(words[0]), words[1..].join(" "));
                    lines.fail(0, "header", problem, "use a whole number")
                })
            };
            match words[..] {
                [_, "atoms"] => head.atoms = Some(whole()?),
                [_, "atom", "types"] => head.types = whole()?,
                [_, "ellipsoids" | "lines" | "triangles" | "bodies"] => head.shaped = whole()? > 0,
                [_, _, low @ ("xlo" | "ylo" | "zlo"), _] => {
                    let axis = usize::from(low.as_bytes()[0] - b'x');
                    [head.low[axis], head.high[axis], _] = finite(2)?;
                    head.bounded = true;
                }
                [_, _, _, "xy", "xz", "yz"] => head.tilt = finite(3)?,
                [_, _, _, "avec"] => head.general[0] = Some(finite(3)?),
                [_, _, _, "bvec"] => head.general[1] = Some(finite(3)?),
                [_, _, _, "cvec"] => head.general[2] = Some(finite(3)?),
                [_, _, _, "abc", "origin"] => head.general[3] = Some(finite(3)?),
                _ => {}
            }
        }
        Ok(head)
    }

    pub(super) fn cell(&self) -> Option<Cell> {
        if let [Some(a), Some(b), Some(c), origin] = self.general {
            return Some(Cell { origin: origin.unwrap_or_default(), edges: [a, b, c] });
        }
        let side = |k: usize| self.high[k] - self.low[k];
        let [xy, xz, yz] = self.tilt;
        let edges = [[side(0), 0.0, 0.0], [xy, side(1), 0.0], [xz, yz, side(2)]];
        self.bounded.then_some(Cell { origin: self.low, edges })
    }
}

/// The current line without its comment.
pub(super) fn body(lines: &Lines<Input>) -> &str {
    let text = lines.text();
    text.split_once('#').map_or(text, |(body, _)| body).trim()
}
