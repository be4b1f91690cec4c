//! Hits as an archive of arrays. It has its columns one after the other, so until the last row each is in an anonymous
//! file.

use super::rows::{Query, Rows};
use crate::write::atomic::scratch;
use crate::write::npz::Archive;
use halfline::progress::Watch;
use halfline_particles::npy::header::Header;
use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::path::Path;

/// The columns of an archive, until all rows are known.
pub(super) struct Spool {
    columns: Vec<File>,
    rows: u64,
}

/// Bytes that are copied between two checks for cancellation.
const COPIED: u64 = 1 << 20;

impl Spool {
    /// No rows yet, of an archive at `path`.
    pub(super) fn new(path: &Path, query: Query) -> io::Result<Self> {
        let columns = query.columns().iter().map(|_| scratch(path)).collect::<io::Result<_>>()?;
        Ok(Self { columns, rows: 0 })
    }

    pub(super) fn add(&mut self, rows: &Rows<'_>) -> io::Result<()> {
        self.rows += rows.len() as u64;
        self.columns.iter_mut().zip(rows.columns()).try_for_each(|(file, bytes)| file.write_all(&bytes))
    }

    /// Copies the columns into an archive; the rows of a scan are in its rings and columns.
    pub(super) fn write(
        &mut self,
        query: Query,
        scan: Option<[u32; 2]>,
        archive: &mut Archive<'_>,
        watch: &Watch,
    ) -> io::Result<()> {
        let sides = match scan {
            Some(sides) => sides.map(u64::from).to_vec(),
            None => vec![self.rows],
        };
        let mut bytes = vec![0; COPIED as usize];
        for (file, &(name, dtype, numbers)) in self.columns.iter_mut().zip(query.columns()) {
            let mut shape = sides.clone();
            shape.extend((numbers > 1).then_some(numbers));
            let header = Header::bytes(dtype, &shape);
            let mut left = file.stream_position()?;
            let out = archive.member(&format!("{name}.npy"), header.len() as u64 + left)?;
            out.write_all(&header)?;
            file.rewind()?;
            while left > 0 {
                watch.check().map_err(io::Error::other)?;
                let bytes = &mut bytes[..left.min(COPIED) as usize];
                file.read_exact(bytes)?;
                out.write_all(bytes)?;
                left -= bytes.len() as u64;
            }
        }
        Ok(())
    }
}
