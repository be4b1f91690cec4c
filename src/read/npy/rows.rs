//! The rows of an array as spheres: read in blocks, converted on all cores.

use crate::error::{Error, Place, Result};
use crate::memory::reserve;
use crate::read::csv::COLUMNS;
use crate::read::input::Counts;
use crate::read::particles::scalar::Scalar;
use crate::read::particles::survey::Survey;
use crate::scene::{Spheres, check_color, check_sphere, is_center, is_radius};
use rayon::prelude::*;
use std::io::{self, BufRead, ErrorKind, Read};

/// Bytes of a block, so that two of them fit into a core's cache.
const BLOCK: u64 = 1 << 20;

/// Numbers that one job tests.
const TOGETHER: usize = 1 << 12;

/// Why reading the rows stopped.
pub(super) enum Fault {
    /// The stream ended after this number of complete rows.
    Numbers(u64, io::Error),
    /// The row is not a valid sphere.
    Row(u64, Error),
}

/// The layout of an array in its file.
pub(super) struct Form<'a> {
    pub(super) rows: u64,
    pub(super) width: usize,
    pub(super) scalar: Scalar,
    pub(super) counts: &'a Counts,
    pub(super) survey: Option<&'a Survey>,
}

/// Appends the spheres of an array that is stored row by row: all cores convert a block of rows while the next is read.
pub(super) fn fill_rows(reader: &mut (impl Read + Send), form: &Form<'_>, spheres: &mut Spheres) -> Result<(), Fault> {
    let blocks = RowBlocks::new(form);
    let (mut block, mut next) = (Vec::new(), Vec::new());
    let mut done = 0;
    let mut read = blocks.read(reader, done, &mut block);
    loop {
        read.map_err(|e| Fault::Numbers(done, e))?;
        let found = blocks.complete(&block);
        if found == 0 && done < form.rows {
            return Err(Fault::Numbers(done, io::ErrorKind::UnexpectedEof.into()));
        } else if found == 0 {
            return Ok(());
        }
        form.counts.found();
        let after = done + found;
        let converted;
        (converted, read) =
            rayon::join(|| blocks.convert(&block, done, spheres), || blocks.read(reader, after, &mut next));
        converted?;
        if let Some(survey) = form.survey {
            survey.take_spheres(spheres, form.width > 3).map_err(|e| Fault::Row(done, e))?;
        }
        done = after;
        std::mem::swap(&mut block, &mut next);
    }
}

/// Appends the spheres of an array that is stored column by column: no row is complete before the last column begins.
pub(super) fn fill_columns(reader: &mut impl BufRead, form: &Form<'_>, spheres: &mut Spheres) -> Result<(), Fault> {
    let &Form { rows, width, scalar, counts, .. } = form;
    let mut columns = Vec::new();
    let mut bytes = [0; 8];
    let bytes = &mut bytes[..scalar.size()];
    for column in 0..width {
        for row in 0..rows {
            reserve(&mut columns, 1).map_err(|e| Fault::Row(row, e))?;
            reader.read_exact(bytes).map_err(|e| Fault::Numbers(if column + 1 == width { row } else { 0 }, e))?;
            columns.push(scalar.number(bytes));
            counts.found();
        }
    }
    let rows = columns.len() / width;
    for row in 0..rows {
        let mut values = [0.0; 7];
        for (column, value) in values[..width].iter_mut().enumerate() {
            *value = columns[column * rows + row];
        }
        push(values, width, spheres).map_err(|e| Fault::Row(row as u64, e))?;
    }
    Ok(())
}

fn push([x, y, z, radius, r, g, b]: [f64; 7], width: usize, spheres: &mut Spheres) -> Result<()> {
    let radius = if width == 3 { 1.0 } else { radius };
    check_sphere([x, y, z], radius, Place::default)?;
    let color = (width == COLUMNS.len()).then_some([r as f32, g as f32, b as f32]);
    if let Some(color) = color {
        check_color(color, || Place::field("color"))?;
    }
    spheres.add([x, y, z], radius, color)
}
/// The blocks of an array that is stored row by row.
struct RowBlocks<'a> {
    form: &'a Form<'a>,
    /// Bytes of a row.
    row: usize,
}

impl<'a> RowBlocks<'a> {
    fn new(form: &'a Form<'a>) -> Self {
        Self { form, row: form.width * form.scalar.size() }
    }

    /// Number of complete rows in `block`.
    fn complete(&self, block: &[u8]) -> u64 {
        (block.len() / self.row) as u64
    }

    /// Replaces the content of `block` by the rows after the first `done`; by less at the end of the stream.
    ///
    /// # Errors
    /// Those of the reader.
    fn read(&self, reader: &mut impl Read, done: u64, block: &mut Vec<u8>) -> io::Result<()> {
        let rows = (self.form.rows - done).min((BLOCK / self.row as u64).max(1)) as usize;
        // The content of an earlier block is overwritten, not cleared.
        block.resize(rows * self.row, 0);
        let mut filled = 0;
        while filled < block.len() {
            match reader.read(&mut block[filled..]) {
                Ok(0) => break,
                Ok(read) => filled += read,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        block.truncate(filled);
        Ok(())
    }

    /// Appends the spheres of the complete rows in `block`, whose first one has the number `first`.
    ///
    /// # Errors
    /// [`Fault::Row`] for the first row that is not a valid sphere, and where memory is short.
    fn convert(&self, block: &[u8], first: u64, spheres: &mut Spheres) -> Result<(), Fault> {
        let &Form { width, scalar, .. } = self.form;
        spheres.grow(block.len() / self.row, false).map_err(|e| Fault::Row(first, e))?;
        let is_plain = width <= 4 && spheres.colors.is_none() && spheres.materials.is_none();
        // The types are constants of the loops, which take a third of the time that way.
        let appended = is_plain
            && match (scalar.size(), scalar.is_big()) {
                (4, false) => self.append(block, spheres, |number| f64::from(f32::from_le_bytes(number))),
                (4, true) => self.append(block, spheres, |number| f64::from(f32::from_be_bytes(number))),
                (_, false) => self.append(block, spheres, f64::from_le_bytes),
                (_, true) => self.append(block, spheres, f64::from_be_bytes),
            };
        if appended {
            return Ok(());
        }
        for (row, bytes) in (first..).zip(block.chunks_exact(self.row)) {
            let mut values = [0.0; 7];
            let numbers = bytes.chunks_exact(scalar.size()).map(|bytes| scalar.number(bytes));
            values.iter_mut().zip(numbers).for_each(|(value, number)| *value = number);
            push(values, width, spheres).map_err(|e| Fault::Row(row, e))?;
        }
        Ok(())
    }

    /// Appends spheres without colours, unless one of them is not valid.
    fn append<const N: usize>(
        &self,
        block: &[u8],
        spheres: &mut Spheres,
        number: impl Fn([u8; N]) -> f64 + Sync,
    ) -> bool {
        let (before, has_radii) = (spheres.len(), self.form.width == 4);
        let at = |row: &[u8], column: usize| row.as_chunks().0.get(column).map_or(1.0, |bytes| number(*bytes));
        let rows = block.par_chunks_exact(self.row);
        let (centers, radii) = (spheres.centers.to_mut(), spheres.radii.to_mut());
        centers.par_extend(rows.clone().map(|row| [at(row, 0), at(row, 1), at(row, 2)]));
        radii.par_extend(rows.map(|row| if has_radii { at(row, 3) } else { 1.0 }));
        let are_finite = |centers: &[[f64; 3]]| centers.iter().fold(true, |all, center| all & is_center(center));
        let are_sizes = |radii: &[f64]| radii.iter().fold(true, |all, radius| all & is_radius(radius));
        let valid = centers[before..].par_chunks(TOGETHER).all(are_finite)
            && radii[before..].par_chunks(TOGETHER).all(are_sizes);
        if !valid {
            centers.truncate(before);
            radii.truncate(before);
        }
        valid
    }
}
