//! Rays from a NumPy array: float64 (or float32, converted exactly) of shape (n, 6) or (n, 7), row by row, in either
//! byte order. Rows count from 0, as in NumPy.

use super::block::{REQUIRED, RayBlock, RayOptions, Row, flaw, mend_row};
use halfline::error::{Error, Result};
use halfline_particles::input::Input;
use halfline_particles::npy::{Matrix, Npy};
use std::io::ErrorKind;
use std::path::Path;

const MEND: &str = "save a float64 array of shape (n, 6) or (n, 7), ox oy oz dx dy dz [tmax], with numpy.save";

/// Rows that are read together.
const ROWS: u64 = 1 << 14;

pub(super) struct RayArray {
    npy: Npy<Input>,
    matrix: Matrix,
    /// Rows that were read.
    done: u64,
    bytes: Vec<u8>,
}

impl RayArray {
    pub(super) fn open(reader: Input, path: &Path) -> Result<Self> {
        let mut npy = Npy::new(reader, path, MEND);
        let header = npy.header()?;
        let matrix = npy.matrix(&header, &[6, 7])?;
        if header.fortran {
            let problem = "the array is stored column by column, so no ray is complete before the last column";
            let mend = "save numpy.ascontiguousarray(rays)";
            return Err(Error::scene(npy.place("fortran_order"), problem, mend));
        }
        let there = npy.reader.left().map(|left| left / matrix.row() as u64);
        if let Some(found) = there.filter(|found| *found < matrix.rows) {
            return Err(npy.cut(ErrorKind::UnexpectedEof.into(), found, matrix.rows));
        }
        Ok(Self { npy, matrix, done: 0, bytes: Vec::new() })
    }

    pub(super) fn count(&self) -> u64 {
        self.matrix.rows
    }

    /// The next rows, at most `most`, counting those that are left out as invalid; an empty block after the last.
    pub(super) fn block(&mut self, most: usize, options: &RayOptions) -> Result<RayBlock> {
        let mut block = RayBlock::default();
        let rows = self.matrix.rows;
        if self.done == rows {
            self.npy.end(rows)?;
        }
        while self.done < rows && block.rows() < most {
            self.part((rows - self.done).min((most - block.rows()) as u64).min(ROWS), options, &mut block)?;
        }
        Ok(block)
    }

    /// Adds the next rows, at most `most`.
    fn part(&mut self, most: u64, options: &RayOptions, block: &mut RayBlock) -> Result<()> {
        let Matrix { rows, width, scalar } = self.matrix;
        let read = self.npy.block(most, self.matrix.row(), &mut self.bytes);
        if read.map_err(|e| Error::read(&self.npy.path, e))? == 0 {
            return Err(self.npy.cut(ErrorKind::UnexpectedEof.into(), self.done, rows));
        }
        for bytes in self.bytes.chunks_exact(self.matrix.row()) {
            let mut row: Row = [f64::INFINITY; 7];
            row.iter_mut().zip(bytes.chunks_exact(scalar.size())).for_each(|(x, bytes)| *x = scalar.number(bytes));
            match flaw(&row) {
                None => block.push(row, width > REQUIRED),
                Some((field, problem)) => block.leave_out(options, || {
                    let place = self.npy.place(format!("row {} (from 0) {field}", self.done));
                    Error::scene(place, problem, mend_row())
                })?,
            }
            self.done += 1;
        }
        Ok(())
    }
}
