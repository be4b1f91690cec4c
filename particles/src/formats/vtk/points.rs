//! The points of a data set, and the arrays of their numbers.

use crate::npy::header::{Scalar, bits, levels};
use crate::particles::bytes::DAMAGED;
use crate::particles::frame::Particles;
use crate::particles::frame_time::FrameTime;
use crate::particles::layout::{Layout, is_requested};
use crate::particles::meaning::{FieldKind, NamedField, is_known, meanings};
use crate::particles::request::Request;
use crate::particles::vectors::component;
use halfline_ground::error::{Error, Place, Result, relocate};
use halfline_ground::memory::{check, check_ids};
use halfline_ground::quote::quote;

/// The most numbers of an array for each point.
pub(super) const MOST_COMPONENTS: u64 = 4096;

/// An array: so many numbers for each point.
#[derive(Debug, Clone)]
pub(super) struct Array {
    pub(super) name: String,
    pub(super) components: usize,
    pub(super) scalar: Scalar,
    pub(super) numbers: Vec<f64>,
}

/// The points of a piece of a data set.
#[derive(Debug, Default)]
pub(super) struct Piece {
    pub(super) count: usize,
    /// Three coordinates for each point.
    pub(super) points: Option<Array>,
    pub(super) arrays: Vec<Array>,
    /// The names of the arrays that were not needed, or that have no numbers.
    pub(super) others: Vec<String>,
}

/// The pieces of a data set.
#[derive(Debug, Default)]
pub(super) struct Pieces {
    pub(super) all: Vec<Piece>,
    pub(super) when: FrameTime,
}

/// Whether the numbers of an array are needed.
pub(super) fn is_needed(request: &Request, name: &str, components: usize) -> bool {
    let is_listed = |name: &str| is_requested(&request.columns, name);
    is_known(&name.to_lowercase()) || is_listed(name) || (0..components).any(|k| is_listed(&component(name, k)))
}

/// The number of points or of an array's numbers, which must fit into memory.
///
/// # Errors
/// [`Error::Limits`].
pub(super) fn total(points: u64, components: usize) -> Result<usize> {
    check_ids(points)?;
    let total = points.saturating_mul(components as u64);
    check(total.saturating_mul(8), || format!("an array of {total} numbers"))?;
    Ok(total as usize)
}

impl Pieces {
    /// The particles: the points of all pieces, one after the other.
    ///
    /// # Errors
    /// [`Error::Scene`] for pieces that lack points or arrays, and for a coordinate, a radius or a colour that is not valid;
    /// [`Error::Limits`].
    pub(super) fn particles(mut self, file: &Place, request: &Request) -> Result<Particles> {
        self.all.retain(|piece| piece.count > 0);
        let Some(first) = self.all.first() else {
            return Ok(Particles { when: self.when, ..Particles::default() });
        };
        let mut layout = Layout::whole(request);
        let fields = fields(first);
        let meanings = meanings(&fields.iter().map(|(name, array)| named(name, array)).collect::<Vec<_>>());
        let packed = meanings.packed;
        layout
            .add_fields(meanings)
            .map_err(|problem| Error::scene(file.clone().named("PointData"), problem, DAMAGED))?;
        let mut particles = layout.begin();
        particles.has.extend(first.others.iter().map(|name| name.to_lowercase()));
        let names: Vec<&str> = fields.iter().map(|(name, _)| *name).collect();
        let mut before = 0;
        for piece in &self.all {
            let arrays = arrays_of(piece, &names, file)?;
            add_points(&layout, &arrays, packed, before, file, &mut particles)?;
            before += piece.count;
        }
        particles.tell_left_out();
        particles.when = self.when;
        Ok(particles)
    }
}

/// The name and the array of each field of a point: first its coordinates.
fn fields(piece: &Piece) -> Vec<(&str, &Array)> {
    let has =
        |name: &str| piece.arrays.iter().any(|array| array.name.eq_ignore_ascii_case(name) && array.components == 1);
    // The coordinates come from the points, whatever the arrays are called.
    let is_axis = |name: &str| ["x", "y", "z"].iter().any(|axis| name.eq_ignore_ascii_case(axis));
    let has_axes = ["x", "y", "z"].into_iter().all(has);
    let arrays = piece.arrays.iter().filter(|array| !(has_axes && is_axis(&array.name)));
    piece.points.iter().map(|points| (POINTS, points)).chain(arrays.map(|array| (&array.name[..], array))).collect()
}

/// The field of the coordinates, whose name comes before all others that mean positions.
const POINTS: &str = "positions";

fn named<'a>(name: &'a str, array: &Array) -> NamedField<'a> {
    NamedField { name, count: array.components, kind: FieldKind::Binary(array.scalar) }
}

/// The arrays of a piece in the order of these names.
fn arrays_of<'a>(piece: &'a Piece, names: &[&str], file: &Place) -> Result<Vec<&'a Array>> {
    let found = fields(piece);
    let of = |name: &&str| {
        found.iter().find(|(known, _)| known == name).map(|(_, array)| *array).ok_or_else(|| {
            let problem = format!("a piece has no array {}, which the first one has", quote(name));
            Error::scene(file.clone().named("Piece"), problem, "give all pieces the same arrays")
        })
    };
    names.iter().map(of).collect()
}

/// Adds the points of a piece; the first has the number `before`.
fn add_points(
    layout: &Layout,
    arrays: &[&Array],
    packed: Option<usize>,
    before: usize,
    file: &Place,
    particles: &mut Particles,
) -> Result<()> {
    let count = arrays.first().map_or(0, |points| points.numbers.len() / 3);
    let mut row = Vec::with_capacity(layout.len());
    for n in 0..count {
        row.clear();
        for (k, array) in arrays.iter().enumerate() {
            let numbers = &array.numbers[n * array.components..(n + 1) * array.components];
            match packed == Some(k) {
                true => row.extend(levels(bits(numbers[0], array.scalar))),
                false => row.extend_from_slice(numbers),
            }
        }
        layout.checked_numbers(&row, particles, |error| {
            relocate(error, |field| file.clone().named(format!("point {} {field}", before + n)))
        })?;
    }
    Ok(())
}
