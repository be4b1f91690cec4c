//! Rays from a NumPy array: float64 (or float32, converted exactly) of shape (n, 6) or (n, 7), row by row, in either
//! byte order. Rows count from 0, as in NumPy.

use super::block::{REQUIRED, RayBlock, RayOptions, Row, flaw, mend_row};
use crate::error::{Error, Result};
use crate::npy::DType;
use crate::read::input::Input;
use crate::read::npy::Npy;
use crate::read::particles::scalar::Scalar;
use std::io::{self, Read};
use std::path::Path;

const MEND: &str = "save a float64 array of shape (n, 6) or (n, 7), ox oy oz dx dy dz [tmax], with numpy.save";

/// Rows that are read together.
const ROWS: u64 = 1 << 14;

pub(super) struct RayArray {
    npy: Npy<Input>,
    scalar: Scalar,
    width: usize,
    rows: u64,
    /// Rows that were read.
    done: u64,
    bytes: Vec<u8>,
}

impl RayArray {
    pub(super) fn open(reader: Input, path: &Path) -> Result<Self> {
        let mut npy = Npy::new(reader, path, MEND);
        let header = npy.header()?;
        let (rows, width) = match header.shape[..] {
            [rows, width @ (6 | 7)] => (rows, width as usize),
            ref other => return Err(npy.fail("shape", format!("found {other:?}, expected (n, 6) or (n, 7)"))),
        };
        let scalar = match &header.dtype {
            DType::Plain(name) => Scalar::of_numpy(name).filter(|scalar| !scalar.is_whole()),
            _ => None,
        };
        let Some(scalar) = scalar else {
            return Err(npy.fail("dtype", format!("found {}, expected float64 or float32", header.dtype)));
        };
        if header.fortran {
            let problem = "the array is stored column by column, so no ray is complete before the last column";
            let mend = "save numpy.ascontiguousarray(rays)";
            return Err(Error::scene(npy.place("fortran_order"), problem, mend));
        }
        let row = (scalar.size() * width) as u64;
        if let Some(left) = npy.reader.left().filter(|left| left / row < rows) {
            return Err(npy.cut(io::ErrorKind::UnexpectedEof.into(), left / row, rows));
        }
        Ok(Self { npy, scalar, width, rows, done: 0, bytes: Vec::new() })
    }

    pub(super) fn count(&self) -> u64 {
        self.rows
    }

    /// The next rows; none after the last.
    pub(super) fn block(&mut self, most: usize, options: &RayOptions) -> Result<RayBlock> {
        let mut block = RayBlock::default();
        if self.done == self.rows {
            self.npy.end(self.rows)?;
        }
        while self.done < self.rows && block.rows() < most {
            self.part((self.rows - self.done).min((most - block.rows()) as u64).min(ROWS), options, &mut block)?;
        }
        Ok(block)
    }

    /// Adds the next `rows`.
    fn part(&mut self, rows: u64, options: &RayOptions, block: &mut RayBlock) -> Result<()> {
        let (size, limited) = (self.scalar.size(), self.width > REQUIRED);
        let row_bytes = size * self.width;
        let wanted = rows * row_bytes as u64;
        self.bytes.clear();
        let read = (&mut self.npy.reader).take(wanted).read_to_end(&mut self.bytes);
        read.map_err(|e| Error::read(&self.npy.path, e))?;
        self.npy.counts.found();
        for bytes in self.bytes.chunks_exact(row_bytes) {
            let mut row: Row = [f64::INFINITY; 7];
            row.iter_mut().zip(bytes.chunks_exact(size)).for_each(|(x, bytes)| *x = self.scalar.number(bytes));
            match flaw(&row) {
                None => block.push(row, limited),
                Some((field, problem)) => block.leave_out(options, || {
                    let place = self.npy.place(format!("row {} (from 0) {field}", self.done));
                    Error::scene(place, problem, mend_row())
                })?,
            }
            self.done += 1;
        }
        if (self.bytes.len() as u64) < wanted {
            return Err(self.npy.cut(io::ErrorKind::UnexpectedEof.into(), self.done, self.rows));
        }
        Ok(())
    }
}
