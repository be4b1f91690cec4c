//! The frames of a file: its points, the points of the files that it names, or a collection of times.

use super::legacy;
use super::points::Pieces;
use super::xml::{self, Content};
use crate::input::{Input, read_once};
use crate::particles::bytes::BinaryFile;
use crate::particles::frame::{OneFrame, ParticleFrames, Particles};
use crate::particles::frame_time::FrameTime;
use crate::particles::request::Request;
use crate::source::Source;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::quote;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// A time of a collection, and its files.
struct Moment {
    time: Option<f64>,
    files: Vec<PathBuf>,
}

/// The times of a collection.
struct Collection {
    moments: VecDeque<Moment>,
    request: Request,
}

/// Opens a file.
///
/// # Errors
/// [`Error::Scene`], [`Error::Io`] and [`Error::Limits`].
pub(super) fn open(source: Source, request: Request) -> Result<Box<dyn ParticleFrames>> {
    let path = source.path.clone();
    match content(source, &request)? {
        Content::Collection(mut files) => {
            let order = |time: Option<f64>| time.unwrap_or(f64::NEG_INFINITY);
            files.sort_by(|(a, _), (b, _)| order(*a).total_cmp(&order(*b)));
            let mut moments: VecDeque<Moment> = VecDeque::new();
            for (time, file) in files {
                let file = sibling(&path, &file);
                match moments.back_mut().filter(|moment| moment.time == time && time.is_some()) {
                    Some(moment) => moment.files.push(file),
                    None => moments.push_back(Moment { time, files: vec![file] }),
                }
            }
            Ok(Box::new(Collection { moments, request }))
        }
        content => Ok(Box::new(OneFrame::new(move || {
            let pieces = of_parts(content, &path, &request)?;
            pieces.particles(&file(&path), &request)
        }))),
    }
}

fn file(path: &Path) -> Place {
    Place::file(path.display().to_string())
}

/// The path of a file that another one names.
fn sibling(path: &Path, name: &str) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).join(name)
}

/// The content of a file.
fn content(source: Source, request: &Request) -> Result<Content> {
    let place = file(&source.path);
    let mut binary = BinaryFile::new(source);
    let mut bytes = Vec::new();
    binary.all(&mut bytes)?;
    binary.found();
    if bytes.starts_with(b"# vtk DataFile") {
        return legacy::read(&bytes, &place, request).map(Content::Pieces);
    }
    xml::read(&bytes, &place, request)
}

/// The pieces of a file, or of the files that it names.
fn of_parts(content: Content, path: &Path, request: &Request) -> Result<Pieces> {
    let parts = match content {
        Content::Pieces(pieces) => return Ok(pieces),
        Content::Parts(parts) => parts,
        Content::Collection(_) => {
            let problem = "a collection names a collection";
            return Err(Error::scene(file(path), problem, "name the files of the data"));
        }
    };
    let mut all = Pieces::default();
    for part in parts {
        let path = sibling(path, &part);
        match opened(&path, request)? {
            Content::Pieces(pieces) => all.append(pieces),
            _ => {
                let problem = format!("the piece {} is not a file of points", quote(&part));
                return Err(Error::scene(file(&path), problem, "name files of PolyData or UnstructuredGrid"));
            }
        }
    }
    Ok(all)
}

fn opened(path: &Path, request: &Request) -> Result<Content> {
    if let Some(what) = read_once(path) {
        let problem = format!("{} is {what}, not a file", quote(path.as_os_str().as_encoded_bytes()));
        return Err(Error::scene(file(path), problem, "name files of points"));
    }
    content(Source { reader: Input::open(path, &request.watch)?, path: path.to_path_buf() }, request)
}

impl Pieces {
    /// Adds the pieces of another file.
    fn append(&mut self, other: Self) {
        self.all.extend(other.all);
        if self.when == FrameTime::default() {
            self.when = other.when;
        }
    }
}

impl ParticleFrames for Collection {
    fn next(&mut self) -> Result<Option<Particles>> {
        let Some(Moment { time, files }) = self.moments.pop_front() else { return Ok(None) };
        let mut all = Pieces::default();
        for path in &files {
            all.append(of_parts(opened(path, &self.request)?, path, &self.request)?);
        }
        let place = files.first().map_or_else(Place::default, |path| file(path));
        let when = FrameTime { time: time.or(all.when.time), ..all.when };
        Ok(Some(Particles { when, ..all.particles(&place, &self.request)? }))
    }

    fn skip(&mut self) -> Result<bool> {
        Ok(self.moments.pop_front().is_some())
    }
}
