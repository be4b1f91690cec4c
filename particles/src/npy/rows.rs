//! The rows of an array as spheres: read in blocks, converted on all cores.

use super::{Matrix, Npy};
use crate::csv::COLUMNS;
use crate::input::Input;
use crate::npy::{Header, NumberKind};
use crate::particles::survey::Survey;
use crate::spheres::SphereRows;
use halfline_ground::check::{check_color, check_sphere, is_center, is_radius};
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::check_spheres;
use halfline_ground::parallel::{self, CHEAP};
use std::io::ErrorKind;

impl Npy<Input> {
    /// Appends the spheres of an array with one of these widths, which is returned; for a width of 3 the radii are 1.
    /// For a survey the spheres of an array in C order are counted or passed on, block by block.
    pub(super) fn spheres(
        &mut self,
        header: &Header,
        widths: &[u64],
        spheres: &mut SphereRows,
        survey: Option<&Survey>,
    ) -> Result<usize> {
        let matrix = self.matrix(header, widths)?;
        let there = matrix.rows.min(self.bytes / matrix.row() as u64);
        if survey.is_none() {
            check_spheres(spheres.len() as u64 + there, matrix.width == COLUMNS.len())?;
            spheres.grow(there as usize, matrix.width == COLUMNS.len())?;
        }
        if header.fortran {
            self.by_columns(&matrix, spheres)?;
        } else {
            self.by_rows(&matrix, spheres, survey)?;
        }
        Ok(matrix.width)
    }

    /// Appends the spheres of an array that is stored row by row: all cores convert a block of rows while the next is
    /// read.
    fn by_rows(&mut self, matrix: &Matrix, spheres: &mut SphereRows, survey: Option<&Survey>) -> Result<()> {
        let (mut block, mut next, mut done) = (Vec::new(), Vec::new(), 0);
        let mut read = self.block(matrix.rows, matrix.row(), &mut block);
        loop {
            let found = read.map_err(|error| self.cut(error, done, matrix.rows))?;
            if found == 0 && done < matrix.rows {
                return Err(self.cut(ErrorKind::UnexpectedEof.into(), done, matrix.rows));
            } else if found == 0 {
                return Ok(());
            }
            let left = matrix.rows - done - found;
            let (skips, mut invalid) = (self.left_out.is_some(), Vec::new());
            let converted;
            (converted, read) = parallel::join(
                || matrix.convert(&block, spheres, skips.then_some(&mut invalid)),
                || self.block(left, matrix.row(), &mut next),
            );
            converted.map_err(|(row, error)| self.in_row(done + row, error))?;
            invalid.into_iter().try_for_each(|(row, error)| self.refuse(done + row, error))?;
            if let Some(survey) = survey {
                survey.take_spheres(spheres, matrix.width > 3).map_err(|error| self.in_row(done, error))?;
            }
            done += found;
            std::mem::swap(&mut block, &mut next);
        }
    }

    /// Appends the spheres of an array that is stored column by column: no row is complete before the last column begins.
    fn by_columns(&mut self, matrix: &Matrix, spheres: &mut SphereRows) -> Result<()> {
        let before_last = (matrix.width as u64 - 1) * matrix.rows;
        let columns = self
            .stored(matrix.rows, matrix.width as u64, matrix.scalar, |numbers| numbers.saturating_sub(before_last))?;
        let rows = columns.len() / matrix.width;
        for row in 0..rows {
            let mut values = [0.0; 7];
            values[..matrix.width].iter_mut().zip(columns[row..].iter().step_by(rows)).for_each(|(to, x)| *to = *x);
            self.add(row as u64, values, matrix.width, spheres)?;
        }
        Ok(())
    }

    /// Appends the spheres of a frame of all numbers of an array in the order of its indices; returns their width.
    pub(super) fn of_numbers(
        &mut self,
        numbers: &[f64],
        frame: u64,
        header: &Header,
        spheres: &mut SphereRows,
    ) -> Result<usize> {
        let (rows, width) = (header.shape[0] as usize, header.shape[1] as usize);
        check_spheres(rows as u64, width == COLUMNS.len())?;
        for (row, numbers) in numbers.chunks_exact(width).skip(frame as usize * rows).take(rows).enumerate() {
            let mut values = [0.0; 7];
            values[..width].copy_from_slice(numbers);
            self.add(row as u64, values, width, spheres)?;
        }
        Ok(width)
    }

    /// Appends the sphere of a row, or counts it as left out.
    fn add(&mut self, row: u64, values: [f64; 7], width: usize, spheres: &mut SphereRows) -> Result<()> {
        match check_row(&values, width) {
            Ok(()) => push(values, width, spheres).map_err(|error| self.in_row(row, error)),
            Err(error) => self.refuse(row, error),
        }
    }

    /// Counts a row that is no sphere as left out, or returns its error.
    fn refuse(&mut self, row: u64, error: Error) -> Result<()> {
        let error = self.in_row(row, error);
        match &mut self.left_out {
            Some(left_out) => {
                left_out.add(error);
                Ok(())
            }
            None => Err(error),
        }
    }
}

fn check_row([x, y, z, radius, ..]: &[f64; 7], width: usize) -> Result<()> {
    check_sphere([*x, *y, *z], if width == 3 { 1.0 } else { *radius }, Place::default)
}

fn push([x, y, z, radius, r, g, b]: [f64; 7], width: usize, spheres: &mut SphereRows) -> Result<()> {
    let radius = if width == 3 { 1.0 } else { radius };
    let color = (width == COLUMNS.len()).then_some([r as f32, g as f32, b as f32]);
    if let Some(color) = color {
        check_color(color, || Place::field("color"))?;
    }
    spheres.add([x, y, z], radius, color)
}

impl Matrix {
    /// Appends the spheres of a block of rows. Rows that are no spheres are left out and added to `invalid`, where it is given.
    ///
    /// # Errors
    /// The number in the block of the first row that is not a valid sphere, and why; or that memory is short.
    fn convert(
        &self,
        block: &[u8],
        spheres: &mut SphereRows,
        mut invalid: Option<&mut Vec<(u64, Error)>>,
    ) -> Result<(), (u64, Error)> {
        let &Self { width, scalar, .. } = self;
        spheres.grow(block.len() / self.row(), false).map_err(|error| (0, error))?;
        let is_wide = scalar.kind == NumberKind::Float && scalar.size() >= 4;
        let is_plain = is_wide && width <= 4 && spheres.colors.is_empty();
        // The types are constants of the loops, which take a third of the time that way.
        let appended = is_plain
            && match (scalar.size(), scalar.big) {
                (4, false) => self.append(block, spheres, |number| f64::from(f32::from_le_bytes(number))),
                (4, true) => self.append(block, spheres, |number| f64::from(f32::from_be_bytes(number))),
                (_, false) => self.append(block, spheres, f64::from_le_bytes),
                (_, true) => self.append(block, spheres, f64::from_be_bytes),
            };
        if appended {
            return Ok(());
        }
        for (row, bytes) in (0..).zip(block.chunks_exact(self.row())) {
            let mut values = [0.0; 7];
            let numbers = bytes.chunks_exact(scalar.size()).map(|bytes| scalar.number(bytes));
            values.iter_mut().zip(numbers).for_each(|(value, number)| *value = number);
            match (check_row(&values, width), &mut invalid) {
                (Ok(()), _) => push(values, width, spheres).map_err(|error| (row, error))?,
                (Err(error), Some(invalid)) => invalid.push((row, error)),
                (Err(error), None) => return Err((row, error)),
            }
        }
        Ok(())
    }

    /// Appends spheres without colours, unless one of them is not valid.
    fn append<const N: usize>(
        &self,
        block: &[u8],
        spheres: &mut SphereRows,
        number: impl Fn([u8; N]) -> f64 + Sync,
    ) -> bool {
        let (before, has_radii) = (spheres.len(), self.width == 4);
        let at = |row: &[u8], column: usize| row.as_chunks().0.get(column).map_or(1.0, |bytes| number(*bytes));
        let (centers, radii) = (&mut spheres.centers, &mut spheres.radii);
        parallel::extend(centers, block, self.row(), |row| [at(row, 0), at(row, 1), at(row, 2)]);
        parallel::extend(radii, block, self.row(), |row| if has_radii { at(row, 3) } else { 1.0 });
        let (new_centers, new_radii) = (&centers[before..], &radii[before..]);
        // Without branches within a job, so that compilers vectorize it.
        let invalid = parallel::any(new_radii.len(), CHEAP, &|rows| {
            let all = new_centers[rows.clone()].iter().zip(&new_radii[rows]);
            !all.fold(true, |all, (center, radius)| all & is_center(center) & is_radius(radius))
        });
        if invalid {
            centers.truncate(before);
            radii.truncate(before);
        }
        !invalid
    }
}
