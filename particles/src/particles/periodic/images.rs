//! The images of a periodic cell that may have neighbours of its particles.

use super::edges::Edges;
use glam::{DMat3, DVec3};
use halfline_ground::Cell;
use halfline_ground::error::{Error, Result};
use halfline_ground::parallel;

/// The most cells that a distance may span along an edge.
const MOST: f64 = 50.0;

/// A cell with the images of its particles.
pub(crate) struct Images {
    edges: Option<Edges>,
    /// Of each edge 1, or 0 where the cell does not repeat along it.
    repeats: DVec3,
    /// The moves to the images that may be near: whole numbers of edges, 0 among them.
    pub(crate) shifts: Vec<[f64; 3]>,
}

impl Images {
    /// The images within `reach` of the cell; without a cell only the particles themselves. The cell does not repeat along edges
    /// that are `open` or have no length.
    ///
    /// # Errors
    /// [`Error::Settings`] for a distance that spans more than [`MOST`] cells.
    pub(crate) fn of(cell: Option<&Cell>, open: [bool; 3], reach: f64) -> Result<Self> {
        let Some((edges, repeats)) = cell.and_then(|cell| repeating(cell, open)) else {
            return Ok(Self { edges: None, repeats: DVec3::ZERO, shifts: vec![[0.0; 3]] });
        };
        let most = (reach / edges.heights()).ceil() * repeats;
        if most.max_element() > MOST {
            let problem = format!("the distance {reach} spans more than {MOST} periodic cells");
            return Err(Error::settings(problem, "give a smaller one"));
        }
        let [a, b, c] = most.to_array().map(|most| (-(most as i32)..=most as i32).map(f64::from));
        let mut shifts = Vec::new();
        for x in a {
            for y in b.clone() {
                shifts.extend(c.clone().map(|z| (edges.edges * DVec3::new(x, y, z)).to_array()));
            }
        }
        Ok(Self { edges: Some(edges), repeats, shifts })
    }

    /// The positions in the cell, as far as it repeats. A position that is inside keeps every bit.
    pub(crate) fn wrapped(&self, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let Some(edges) = &self.edges else { return positions.to_vec() };
        let inside = |position: &[f64; 3]| {
            let fractions = edges.fractions(DVec3::from_array(*position) - edges.origin);
            edges.back(*position, fractions.floor() * self.repeats)
        };
        parallel::map(positions, inside)
    }
}

/// The edges along which a cell does not repeat, by a word for each: `F` of extended XYZ's `pbc`, and LAMMPS' kinds of boundaries
/// (docs.lammps.org/boundary.html). There `p` is periodic, and `f`, `s` and `m` are not. Other words are left out.
pub(crate) fn open_edges<'a>(words: impl Iterator<Item = &'a str>) -> [bool; 3] {
    let is_open = |word: &str| match word {
        "T" | "True" | "true" | "1" | "pp" => Some(false),
        "F" | "False" | "false" | "0" => Some(true),
        kinds if kinds.len() == 2 && kinds.bytes().all(|kind| b"fsm".contains(&kind)) => Some(true),
        _ => None,
    };
    let mut open = [false; 3];
    open.iter_mut().zip(words.filter_map(is_open)).for_each(|(edge, is_open)| *edge = is_open);
    open
}

/// The edges, and 1 for each along which the cell repeats. An edge without length, as of a plane, is replaced by one across the others.
fn repeating(cell: &Cell, open: [bool; 3]) -> Option<(Edges, DVec3)> {
    let mut edges = DMat3::from_cols_array_2d(&cell.edges);
    let is_flat = [0, 1, 2].map(|k| edges.col(k) == DVec3::ZERO);
    if let Some(k) = is_flat.iter().position(|flat| *flat) {
        *edges.col_mut(k) = edges.col((k + 1) % 3).cross(edges.col((k + 2) % 3)).normalize_or_zero();
    }
    let repeats = [0, 1, 2].map(|k| if open[k] || is_flat[k] { 0.0 } else { 1.0 });
    Some((Edges::of(&Cell { edges: edges.to_cols_array_2d(), ..*cell })?, DVec3::from_array(repeats)))
}
