//! Frames of several files together: the particles of the first file, then of each further one. A column names the file
//! of each.

use super::frame::{Column, ParticleFrames, Particles};
use super::frame_time::FrameTime;
use super::periodic::{self, Periodic};
use super::residues::FILE;
use halfline_ground::error::Result;
use halfline_ground::memory::check;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

/// The reader of several files. Their frames go in step; a file with one frame is in all of them.
pub(crate) struct Added {
    members: Vec<Member>,
    /// Applied to the particles of each file by its own cell.
    periodic: Periodic,
}

/// One of the files.
struct Member {
    path: PathBuf,
    /// Its name in the column.
    name: String,
    frames: Box<dyn ParticleFrames>,
    /// The number of frames that were read or passed over.
    passed: u64,
    /// The first frame, while it may be the only one.
    still: Option<Particles>,
    /// Whether frames after the first are read too.
    is_film: bool,
}

/// The next frame of a member.
enum Next {
    /// A frame that was read; `None` where it was passed over.
    Moved(Option<Particles>),
    /// The only frame again.
    Still(Particles),
}

impl Member {
    /// The next frame, `None` behind the last of several; passed over unless `is_read`.
    fn next(&mut self, is_read: bool) -> Result<Option<Next>> {
        // The first frame is read in any case: it may be the only one.
        let next = match is_read || self.passed == 0 {
            true => self.frames.next()?.map(Some),
            false => self.frames.skip()?.then_some(None),
        };
        Ok(match (next, &self.still) {
            (Some(frame), _) => {
                self.passed += 1;
                self.still = frame.as_ref().filter(|_| self.is_film && self.passed == 1).cloned();
                Some(Next::Moved(frame))
            }
            (None, Some(still)) => Some(Next::Still(still.clone())),
            (None, None) => None,
        })
    }
}

impl Added {
    /// A reader of the frames of these files together; `is_film`: frames after the first are read too.
    pub(crate) fn new(files: Vec<(PathBuf, Box<dyn ParticleFrames>)>, periodic: Periodic, is_film: bool) -> Self {
        let names = names(files.iter().map(|(path, _)| path.as_path()));
        let member = |((path, frames), name)| Member { path, name, frames, passed: 0, still: None, is_film };
        Self { members: files.into_iter().zip(names).map(member).collect(), periodic }
    }

    /// The next frame of every file; `None` behind the last.
    fn step(&mut self, is_read: bool) -> Result<Option<Vec<Option<Particles>>>> {
        let (mut frames, mut has_moved) = (Vec::new(), false);
        for member in &mut self.members {
            frames.push(match member.next(is_read)? {
                Some(Next::Moved(frame)) => {
                    has_moved = true;
                    frame
                }
                Some(Next::Still(frame)) => Some(frame),
                None => return Ok(None),
            });
        }
        Ok(has_moved.then_some(frames))
    }
}

impl ParticleFrames for Added {
    fn next(&mut self) -> Result<Option<Particles>> {
        let Some(frames) = self.step(true)? else { return Ok(None) };
        let mut frames: Vec<Particles> = frames.into_iter().flatten().collect();
        let has_cell = frames.iter().any(|frame| frame.cell.is_some());
        for frame in &mut frames {
            if frame.cell.is_some() || !has_cell {
                periodic::apply(self.periodic, frame)?;
            }
        }
        let names: Vec<&str> = self.members.iter().map(|member| &member.name[..]).collect();
        let paths = self.members.iter().map(|member| member.path.as_path());
        united(frames, &names, paths).map(Some)
    }

    fn skip(&mut self) -> Result<bool> {
        Ok(self.step(false)?.is_some())
    }
}

/// The names of files without folders and extensions; with a number behind it, from 2, one that is already there.
fn names<'a>(paths: impl Iterator<Item = &'a Path>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for path in paths {
        let stem = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let stem = if path == Path::new("-") { "stdin".to_owned() } else { stem };
        let numbered = (2..).map(|number| format!("{stem}-{number}"));
        let name = std::iter::once(stem.clone()).chain(numbered).find(|name| !names.contains(name));
        names.extend(name);
    }
    names
}

/// The particles of all frames, one after the other. What some of them lack is missing there: no radius, no element, no colour, no
/// value of a column. Cell and time come from the first frame that has them.
fn united<'a>(mut frames: Vec<Particles>, names: &[&str], paths: impl Iterator<Item = &'a Path>) -> Result<Particles> {
    let count: usize = frames.iter().map(|frame| frame.positions.len()).sum();
    let mut columns: Vec<String> = Vec::new();
    for column in frames.iter().flat_map(|frame| &frame.columns) {
        if column.name != FILE && !columns.contains(&column.name) {
            columns.push(column.name.clone());
        }
    }
    let each = size_of::<[f64; 3]>() + size_of::<[f32; 3]>() + 9 + 8 * (columns.len() + 1);
    check((count * each) as u64, || format!("{count} particles of {} files", frames.len()))?;
    let mut all = Particles { checked: frames.iter().all(|frame| frame.checked), ..Particles::default() };
    let (mut first, mut places) = (0, Vec::with_capacity(count));
    for (number, (frame, path)) in frames.iter_mut().zip(paths).enumerate() {
        // Numbers of colours mean what their own file says.
        frame.lighten();
        if frame.column(FILE).is_some() {
            let words = format!("the column {FILE} has the names of the files, not the values of this file's column");
            frame.skipped.assumed.push(words);
        }
        for message in &mut frame.skipped.assumed {
            *message = format!("{}: {message}", names[number]);
        }
        all.files.push((path.to_path_buf(), first));
        first += frame.positions.len() as u64;
        places.resize(first as usize, number as f64);
    }
    all.radii = joined(&frames, |frame| &frame.radii, f64::NAN);
    all.elements = joined(&frames, |frame| &frame.elements, 0);
    all.colors = joined(&frames, |frame| &frame.colors, [f32::NAN; 3]);
    for name in columns {
        let (values, labels) = column(&frames, &name);
        all.labels.extend(labels.map(|labels| (name.clone(), labels)));
        all.columns.push(Column { name, values });
    }
    all.columns.push(Column { name: FILE.to_owned(), values: places });
    all.labels.insert(FILE.to_owned(), names.iter().map(|name| (*name).to_owned()).collect());
    for frame in frames {
        all.positions.extend(frame.positions);
        for name in frame.has {
            if name != FILE && !all.has.contains(&name) {
                all.has.push(name);
            }
        }
        all.shown.extend(frame.shown);
        frame.unknown.iter().for_each(|(name, count)| all.add_unknown(name, *count));
        all.skipped.append(frame.skipped);
        if all.cell.is_none() {
            (all.cell, all.open_edges) = (frame.cell, frame.open_edges);
        }
        if all.when == FrameTime::default() {
            all.when = frame.when;
        }
    }
    all.has.push(FILE.to_owned());
    Ok(all)
}

/// The values of all frames, `missing` for the particles of those that have none; none where no frame has.
fn joined<T: Copy>(frames: &[Particles], of: impl Fn(&Particles) -> &Vec<T>, missing: T) -> Vec<T> {
    if frames.iter().all(|frame| of(frame).is_empty()) {
        return Vec::new();
    }
    let mut all = Vec::with_capacity(frames.iter().map(|frame| frame.positions.len()).sum());
    for frame in frames {
        all.extend_from_slice(of(frame));
        all.resize(all.len() + frame.positions.len() - of(frame).len(), missing);
    }
    all
}

/// The values of a column in all frames; names where it has names in some of them.
fn column(frames: &[Particles], name: &str) -> (Vec<f64>, Option<Vec<String>>) {
    if !frames.iter().any(|frame| frame.labels.contains_key(name)) {
        let mut all = Vec::new();
        for frame in frames {
            let values = frame.column(name).map(|column| &column.values[..]).unwrap_or_default();
            all.extend_from_slice(values);
            all.resize(all.len() + frame.positions.len() - values.len(), f64::NAN);
        }
        return (all, None);
    }
    let (mut labels, mut known) = (Vec::new(), HashMap::new());
    let mut number = |label: String| -> f64 {
        *known.entry(label).or_insert_with_key(|label: &String| {
            labels.push(label.clone());
            (labels.len() - 1) as f64
        })
    };
    let mut all = Vec::new();
    for frame in frames {
        match (frame.column(name), frame.labels.get(name)) {
            (Some(column), Some(own)) => {
                let numbers: Vec<f64> = own.iter().map(|label| number(label.clone())).collect();
                let none = number(String::new());
                all.extend(column.values.iter().map(|x| numbers.get(*x as usize).copied().unwrap_or(none)));
            }
            (Some(column), None) => {
                let mut written: BTreeMap<u64, f64> = BTreeMap::new();
                let value = |x: &f64| *written.entry(x.to_bits()).or_insert_with(|| number(x.to_string()));
                all.extend(column.values.iter().map(value));
            }
            (None, _) => {
                let none = number(String::new());
                all.extend(std::iter::repeat_n(none, frame.positions.len()));
            }
        }
    }
    (all, Some(labels))
}
