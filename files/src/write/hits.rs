//! Files of hits: `.npz` with an array per column and `.csv`, a row for each ray or echo, and point clouds, a point for each
//! hit or echo. Rows arrive in blocks and are not kept in memory.

mod archive;
mod cloud;
mod las;
mod pcd;
mod ply;
mod point;
mod rows;

pub use cloud::CloudSummary;
pub use rows::Query;

use super::atomic::{is_standard_output, write_atomically};
use super::npz::write_archive;
use archive::Spool;
use cloud::{Cloud, CloudFormat};
use halfline::error::{Error, Result};
use halfline::progress::Watch;
use halfline::quote::setting::ANY;
use halfline::render::trace::echoes::Echoes;
use halfline::render::trace::{Hits, Occlusion, Rays};
use halfline::scene::Spheres;
use halfline_particles::input::is_special;
use rows::Rows;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file of hits that is to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HitFile {
    path: PathBuf,
    format: HitFormat,
    query: Query,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum HitFormat {
    Csv,
    Npz,
    Cloud(CloudFormat),
}

/// The formats by their file name extensions.
const FORMATS: [(&str, HitFormat); 5] = [
    ("npz", HitFormat::Npz),
    ("csv", HitFormat::Csv),
    ("ply", HitFormat::Cloud(CloudFormat::Ply)),
    ("pcd", HitFormat::Cloud(CloudFormat::Pcd)),
    ("las", HitFormat::Cloud(CloudFormat::Las)),
];

impl HitFile {
    /// The file at `path`; its extension chooses the format: `.npz`, `.csv`, or a cloud of the hits, `.ply`, `.pcd` or `.las`.
    /// Standard output (`-`), and pipes and devices without one of these extensions, are CSV.
    ///
    /// # Errors
    /// [`Error::Settings`] for another extension, and for a cloud of [`Query::Any`], which has no points.
    pub fn new(path: &Path, query: Query) -> Result<Self> {
        let ends_in = |ending: &str| path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending));
        let format = FORMATS.iter().find(|(ending, _)| ends_in(ending)).map(|(_, format)| *format);
        let format = format.or((is_standard_output(path) || is_special(path)).then_some(HitFormat::Csv));
        match format {
            Some(HitFormat::Cloud(_)) if query == Query::Any => {
                let problem = format!("{} is a point cloud, and {ANY} finds no points", path.display());
                Err(Error::settings(problem, format!("remove {ANY}, or use the file name extension .npz or .csv")))
            }
            Some(format) => Ok(Self { path: path.to_path_buf(), format, query }),
            None => {
                let problem = format!("{} cannot hold hits", path.display());
                Err(Error::settings(
                    problem,
                    "use the file name extension .npz or .csv, or for a cloud .ply, .pcd or .las",
                ))
            }
        }
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

    /// Whether the colours of the spheres are in it, or intensities, which are made of them.
    #[must_use]
    pub fn has_colors(&self) -> bool {
        matches!(self.format, HitFormat::Cloud(_)) || self.query == Query::Echoes
    }

    /// Writes the rows that `fill` adds, completely or not at all; a pipe or standard output receives CSV as it is
    /// made. Rays that are a scan come ring by ring: `scan` has the numbers of rings and of columns, and shapes the arrays of
    /// an archive that has a row for each ray. A cloud is coloured by `spheres`; what it contains is returned.
    ///
    /// # Errors
    /// Errors of `fill`, [`Error::Io`] naming the file, [`Error::Interrupted`]; for a cloud [`Error::Settings`] for
    /// hits that the format cannot number, and [`Error::Limits`] for hits beyond f64.
    pub fn write(
        &self,
        watch: &Watch,
        scan: Option<[u32; 2]>,
        spheres: &Spheres,
        fill: impl FnOnce(&mut HitWriter<'_>) -> Result<()>,
    ) -> Result<Option<CloudSummary>> {
        let mut summary = None;
        write_atomically(&self.path, |out| {
            let fill = |place| fill(&mut HitWriter { file: self, place }).map_err(io::Error::other);
            match self.format {
                HitFormat::Csv => {
                    out.write_all(self.query.header().as_bytes())?;
                    fill(Destination::Text(out))
                }
                HitFormat::Npz => {
                    let mut spool = Spool::new(&self.path, self.query)?;
                    fill(Destination::Spool(&mut spool))?;
                    let sides = scan.filter(|_| self.query != Query::Echoes);
                    write_archive(out, |archive| spool.write(self.query, sides, archive, watch))
                }
                HitFormat::Cloud(format) => {
                    let mut cloud = Cloud::new(&self.path, format, self.query, scan)?;
                    fill(Destination::Cloud(&mut cloud))?;
                    summary = Some(cloud.write(spheres, out, watch).map_err(io::Error::other)?);
                    Ok(())
                }
            }
        })?;
        Ok(summary)
    }
}

/// Receives the rows of a file of hits, block by block.
pub struct HitWriter<'a> {
    file: &'a HitFile,
    place: Destination<'a>,
}

enum Destination<'a> {
    Text(&'a mut dyn Write),
    Spool(&'a mut Spool),
    Cloud(&'a mut Cloud),
}

impl HitWriter<'_> {
    /// Adds the nearest hits of a block of rays. `invalid` are the places of rows without a valid ray among all rows of
    /// the block, in ascending order: misses of certainty 255.
    ///
    /// # Errors
    /// [`Error::Io`] naming the file, [`Error::Settings`] for hits without normals or in a file of [`Query::Any`]; see
    /// [`HitFile::write`] for errors of clouds.
    pub fn hits(&mut self, rays: &Rays<'_>, hits: &Hits, invalid: &[u32]) -> Result<()> {
        let rows = Rows::nearest(rays, hits, invalid).filter(|_| self.file.query == Query::Nearest);
        self.rows(&rows.ok_or_else(|| Error::settings("the hits have no normals", "trace with Aov::Normal"))?)
    }

    /// Adds whether the rays of a block hit anything, as [`Self::hits`].
    ///
    /// # Errors
    /// [`Error::Io`] naming the file, [`Error::Settings`] in a file of [`Query::Nearest`].
    pub fn occlusion(&mut self, occlusion: &Occlusion, invalid: &[u32]) -> Result<()> {
        if self.file.query != Query::Any {
            return Err(Error::settings("the file has a row for each nearest hit", "make it for Query::Any"));
        }
        self.rows(&Rows::any(occlusion, invalid))
    }

    /// Adds the echoes of a block of beams.
    ///
    /// # Errors
    /// [`Error::Io`] naming the file, [`Error::Settings`] in a file of another query; see [`HitFile::write`] for errors of
    /// clouds.
    pub fn echoes(&mut self, echoes: &Echoes) -> Result<()> {
        if self.file.query != Query::Echoes {
            return Err(Error::settings("the file has a row for each ray", "make it for Query::Echoes"));
        }
        self.rows(&Rows::Echoes(echoes))
    }

    fn rows(&mut self, rows: &Rows<'_>) -> Result<()> {
        let written = match &mut self.place {
            Destination::Text(out) => rows.write_text(out),
            Destination::Spool(spool) => spool.add(rows),
            Destination::Cloud(cloud) => return cloud.add(rows),
        };
        written.map_err(|error| Error::write(&self.file.path, error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline::settings::Search;

    #[test]
    fn answers_of_the_other_query_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let hits = |normal| Hits {
            id: vec![],
            t: vec![],
            distance: vec![],
            certainty: vec![],
            normal,
            bound: None,
            search: Search::All,
        };
        let (occlusion, rays) = (Occlusion { hit: vec![], certainty: vec![] }, Rays::default());
        let (watch, spheres) = (Watch::default(), Spheres::default());
        let echoes = Echoes { beams: 0, all: vec![] };
        for (query, name) in [(Query::Nearest, "a.npz"), (Query::Any, "a.csv"), (Query::Echoes, "a.ply")] {
            let file = HitFile::new(&folder.path().join(name), query).expect("a file of hits");
            for other in [Query::Nearest, Query::Any, Query::Echoes].into_iter().filter(|other| *other != query) {
                let written = file.write(&watch, None, &spheres, |out| match other {
                    Query::Nearest => out.hits(&rays, &hits(Some(vec![])), &[]),
                    Query::Any => out.occlusion(&occlusion, &[]),
                    Query::Echoes => out.echoes(&echoes),
                });
                assert!(matches!(written, Err(Error::Settings { .. })), "{query:?}, {other:?}: {written:?}");
            }
            let file = HitFile::new(&folder.path().join(name), Query::Nearest).expect("a file of hits");
            file.write(&watch, None, &spheres, |out| out.hits(&rays, &hits(None), &[])).expect_err("no normals");
        }
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
        HitFile::new(Path::new("a.npy"), Query::Any).expect_err("another extension");
        HitFile::new(Path::new("a.ply"), Query::Any).expect_err("a cloud");
    }
}
