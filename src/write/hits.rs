//! Files of hits, one row per ray: `.npz` with an array per column, or `.csv`. Rows arrive in blocks and are not kept in
//! memory. An archive has its columns one after the other, so until the last row each is in an anonymous file.

use super::atomic::{check_writable, is_special, is_standard_output, scratch, write_atomically};
use super::encode::plain;
use super::npz::{Archive, write_archive};
use crate::error::{Error, Result};
use crate::npy::Header;
use crate::progress::Watch;
use crate::render::trace::{Hits, Occlusion};
use rayon::prelude::*;
use std::borrow::Cow;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// What the rays were traced for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Query {
    /// The nearest hit: columns `id`, `t`, `distance`, `normal` (`nx,ny,nz` in .csv) and `certainty`, as in [`Hits`].
    Nearest,
    /// Whether there is any hit: columns `hit` and `certainty`, as in [`Occlusion`].
    Any,
}

/// The certainty of a row without a valid ray, and of an answer that is not certified.
const UNCERTIFIED: u8 = 255;

/// A column of the answers: its name in .npz, its type by NumPy's name, its bytes and its numbers per row.
struct Column {
    name: &'static str,
    dtype: &'static str,
    size: u64,
    numbers: u64,
}

const fn column(name: &'static str, dtype: &'static str, size: u64, numbers: u64) -> Column {
    Column { name, dtype, size, numbers }
}

const NEAREST: [Column; 5] = [
    column("id", "<i4", 4, 1),
    column("t", "<f8", 8, 1),
    column("distance", "<f8", 8, 1),
    column("normal", "<f4", 12, 3),
    column("certainty", "|u1", 1, 1),
];

const ANY: [Column; 2] = [column("hit", "|u1", 1, 1), column("certainty", "|u1", 1, 1)];

impl Query {
    fn columns(self) -> &'static [Column] {
        match self {
            Self::Nearest => &NEAREST,
            Self::Any => &ANY,
        }
    }

    fn header(self) -> &'static str {
        match self {
            Self::Nearest => "id,t,distance,nx,ny,nz,certainty\n",
            Self::Any => "hit,certainty\n",
        }
    }
}

/// A file of hits that is to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HitFile {
    path: PathBuf,
    is_archive: bool,
    query: Query,
}

impl HitFile {
    /// The file at `path`; its extension, `.npz` or `.csv`, chooses the format. Standard output (`-`), and pipes and
    /// devices without one of these extensions, are CSV.
    ///
    /// # Errors
    /// [`Error::Settings`] for another extension.
    pub fn new(path: &Path, query: Query) -> Result<Self> {
        let ends_in = |ending: &str| path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending));
        let is_archive = ends_in("npz");
        if is_archive || ends_in("csv") || is_standard_output(path) || is_special(path) {
            return Ok(Self { path: path.to_path_buf(), is_archive, query });
        }
        let problem = format!("{} cannot hold hits", path.display());
        Err(Error::settings(problem, "use the file name extension .npz or .csv"))
    }

    /// The path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it is standard output.
    #[must_use]
    pub fn is_standard(&self) -> bool {
        is_standard_output(&self.path)
    }

    /// Checks that the file can be written, for use before the work begins.
    ///
    /// # Errors
    /// See [`check_writable`].
    pub fn check(&self) -> Result<()> {
        check_writable(&self.path)
    }

    /// Writes the rows that `fill` adds, completely or not at all; a pipe or standard output receives CSV as it is
    /// made.
    ///
    /// # Errors
    /// Those of `fill`, [`Error::Io`] naming the file, [`Error::Interrupted`].
    pub fn write(&self, watch: &Watch, fill: impl FnOnce(&mut HitWriter<'_>) -> Result<()>) -> Result<()> {
        write_atomically(&self.path, |out| {
            let fill = |place| fill(&mut HitWriter { file: self, place }).map_err(io::Error::other);
            if !self.is_archive {
                out.write_all(self.query.header().as_bytes())?;
                return fill(Place::Text(out));
            }
            let columns = self.query.columns().iter();
            let mut spool =
                Spool { columns: columns.map(|_| scratch(&self.path)).collect::<io::Result<_>>()?, rows: 0 };
            fill(Place::Spool(&mut spool))?;
            write_archive(out, |archive| spool.archive(self.query, archive, watch))
        })
    }
}

/// Receives the rows of a file of hits, block by block.
pub struct HitWriter<'a> {
    file: &'a HitFile,
    place: Place<'a>,
}

enum Place<'a> {
    Text(&'a mut dyn Write),
    Spool(&'a mut Spool),
}

impl HitWriter<'_> {
    /// Adds the nearest hits of a block of rays. `invalid` are the places of rows without a valid ray among all rows of
    /// the block, in ascending order: misses of certainty 255.
    ///
    /// # Errors
    /// [`Error::Io`] naming the file, [`Error::Settings`] for hits without normals or in a file of [`Query::Any`].
    pub fn hits(&mut self, hits: &Hits, invalid: &[u32]) -> Result<()> {
        let normal = hits.normal.as_ref().filter(|_| self.file.query == Query::Nearest);
        let normal = normal.ok_or_else(|| Error::settings("the hits have no normals", "trace with Aov::Normal"))?;
        self.rows(&Rows::Nearest {
            id: spread(&hits.id, invalid, -1),
            t: spread(&hits.t, invalid, f64::INFINITY),
            distance: spread(&hits.distance, invalid, f64::INFINITY),
            normal: spread(normal, invalid, [0.0; 3]),
            certainty: spread(&hits.certainty, invalid, UNCERTIFIED),
        })
    }

    /// Adds whether the rays of a block hit anything, as [`Self::hits`].
    ///
    /// # Errors
    /// [`Error::Io`] naming the file, [`Error::Settings`] in a file of [`Query::Nearest`].
    pub fn occlusion(&mut self, occlusion: &Occlusion, invalid: &[u32]) -> Result<()> {
        if self.file.query != Query::Any {
            return Err(Error::settings("the file has a row for each nearest hit", "make it for Query::Any"));
        }
        self.rows(&Rows::Any {
            hit: spread(&occlusion.hit, invalid, 0),
            certainty: spread(&occlusion.certainty, invalid, UNCERTIFIED),
        })
    }

    fn rows(&mut self, rows: &Rows<'_>) -> Result<()> {
        let written = match &mut self.place {
            Place::Text(out) => rows.write_text(out),
            Place::Spool(spool) => spool.add(rows),
        };
        written.map_err(|error| Error::write(&self.file.path, error))
    }
}

/// The columns of an archive, until all rows are known.
struct Spool {
    columns: Vec<File>,
    rows: u64,
}

/// Bytes that are copied between two checks for cancellation.
const COPIED: u64 = 8 << 20;

impl Spool {
    fn add(&mut self, rows: &Rows<'_>) -> io::Result<()> {
        self.rows += rows.len() as u64;
        self.columns.iter_mut().zip(rows.columns()).try_for_each(|(file, bytes)| file.write_all(&bytes))
    }

    /// Copies the columns into an archive.
    fn archive(&mut self, query: Query, archive: &mut Archive<'_>, watch: &Watch) -> io::Result<()> {
        for (file, column) in self.columns.iter_mut().zip(query.columns()) {
            let shape = [self.rows, column.numbers];
            let header = Header::bytes(column.dtype, if column.numbers == 1 { &shape[..1] } else { &shape });
            let mut left = self.rows * column.size;
            let out = archive.member(&format!("{}.npy", column.name), header.len() as u64 + left)?;
            out.write_all(&header)?;
            file.rewind()?;
            while left > 0 {
                watch.check().map_err(io::Error::other)?;
                let copied = io::copy(&mut file.take(left.min(COPIED)), out)?;
                if copied == 0 {
                    return Err(io::ErrorKind::UnexpectedEof.into());
                }
                left -= copied;
            }
        }
        Ok(())
    }
}

/// The columns of a block.
enum Rows<'a> {
    Nearest {
        id: Cow<'a, [i32]>,
        t: Cow<'a, [f64]>,
        distance: Cow<'a, [f64]>,
        normal: Cow<'a, [[f32; 3]]>,
        certainty: Cow<'a, [u8]>,
    },
    Any {
        hit: Cow<'a, [u8]>,
        certainty: Cow<'a, [u8]>,
    },
}

/// Rows of text that are made together, and those that a thread makes at a time.
const LINES: usize = 1 << 16;
const PART: usize = 1 << 11;

impl Rows<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Nearest { certainty, .. } | Self::Any { certainty, .. } => certainty.len(),
        }
    }

    /// The bytes of each column in .npy.
    fn columns(&self) -> Vec<Cow<'_, [u8]>> {
        match self {
            Self::Nearest { id, t, distance, normal, certainty } => vec![
                plain(id, i32::to_le_bytes),
                plain(t, f64::to_le_bytes),
                plain(distance, f64::to_le_bytes),
                plain(normal.as_flattened(), f32::to_le_bytes),
                Cow::Borrowed(certainty),
            ],
            Self::Any { hit, certainty } => vec![Cow::Borrowed(hit), Cow::Borrowed(certainty)],
        }
    }

    fn write_text(&self, out: &mut dyn Write) -> io::Result<()> {
        for first in (0..self.len()).step_by(LINES) {
            let last = self.len().min(first + LINES);
            let parts = (first..last).into_par_iter().step_by(PART);
            let parts: Vec<String> = parts.map(|start| self.text(start..last.min(start + PART))).collect();
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
                Self::Nearest { id, t, distance, normal, certainty } => {
                    let (id, t, distance, certainty) = (id[row], t[row], distance[row], certainty[row]);
                    let [x, y, z] = normal[row];
                    writeln!(text, "{id},{t:?},{distance:?},{x:?},{y:?},{z:?},{certainty}")
                }
                Self::Any { hit, certainty } => writeln!(text, "{},{}", hit[row], certainty[row]),
            };
        }
        text
    }
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
    use crate::settings::Search;

    #[test]
    fn invalid_rows_are_between_the_others() {
        assert_eq!(*spread(&[1, 2, 3], &[0, 1, 4], -1), [-1, -1, 1, 2, -1, 3]);
        assert_eq!(*spread(&[1, 2], &[2, 3], -1), [1, 2, -1, -1]);
        assert_eq!(*spread(&[], &[0], -1), [-1]);
        assert!(matches!(spread(&[1], &[], -1), Cow::Borrowed([1])));
    }

    #[test]
    fn answers_of_the_other_query_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let hits =
            |normal| Hits { id: vec![], t: vec![], distance: vec![], certainty: vec![], normal, search: Search::All };
        let occlusion = Occlusion { hit: vec![], certainty: vec![] };
        for (query, name) in [(Query::Nearest, "a.npz"), (Query::Any, "a.csv")] {
            let file = HitFile::new(&folder.path().join(name), query).expect("a file of hits");
            let written = file.write(&Watch::default(), |out| match query {
                Query::Nearest => out.occlusion(&occlusion, &[]),
                Query::Any => out.hits(&hits(Some(vec![])), &[]),
            });
            assert!(matches!(written, Err(Error::Settings { .. })), "{written:?}");
            let file = HitFile::new(&folder.path().join(name), Query::Nearest).expect("a file of hits");
            file.write(&Watch::default(), |out| out.hits(&hits(None), &[])).expect_err("no normals");
        }
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
        HitFile::new(Path::new("a.npy"), Query::Any).expect_err("another extension");
    }
}
