//! Reading of scene and particle files, with the options of the command.

use crate::errors::OrRaise;
use crate::scene::Scene;
use crate::words::{texts, written};
use crate::work::Job;
use halfline::error::{Error, Result};
use halfline::frame::color_map::ColorMap;
use halfline::scene::arrange::Arrangement;
use halfline_command::choices::Choices;
use halfline_command::shown::Call;
use halfline_files::read::style;
use halfline_files::read::{FixedCamera, Hold, Keep, SceneFrame};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::io::Cursor;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// The columns that `keep` names: all, none, the columns of molecules, or these.
fn kept(keep: Option<&Bound<'_, PyAny>>) -> PyResult<Keep> {
    let Some(keep) = keep.filter(|keep| !keep.is_none()) else { return Ok(Keep::Molecules) };
    Ok(match keep.extract::<bool>() {
        Ok(true) => Keep::All,
        Ok(false) => Keep::Nothing,
        Err(_) => Keep::Named(texts("keep", keep)?),
    })
}

/// An opened file, whose scenes are read one after the other.
#[pyclass(frozen)]
pub(crate) struct Sequence(Mutex<Opened>);

struct Opened {
    sequence: halfline_files::read::Sequence,
    arrangement: Arrangement,
    colored_by: Option<String>,
    file: Option<String>,
    job: Job,
    size: Option<(u32, u32)>,
    fixed_camera: FixedCamera,
    any: bool,
}

/// The camera of a frame whose file has none.
fn point(frame: &mut SceneFrame) -> Result<()> {
    match frame.has_camera || frame.scene.spheres.is_empty() {
        true => Ok(()),
        false => frame.scene.frame_by_default(frame.is_molecule, &Default::default()),
    }
}

impl Opened {
    fn prepare(&mut self, frame: &mut SceneFrame) -> Result<()> {
        let watch = self.job.watch();
        if let Some((width, height)) = self.size {
            (frame.scene.image.width, frame.scene.image.height) = (width, height);
        }
        self.fixed_camera.see(frame, &self.arrangement, &watch, point)?;
        frame.arrange(&self.arrangement, &watch)?;
        self.fixed_camera.apply(frame, point)
    }

    fn next(&mut self) -> Result<Option<Scene>> {
        if let Some(mut first) = self.sequence.unselected_first()? {
            self.prepare(&mut first)?;
        }
        let Some(mut frame) = self.sequence.next_scene()? else {
            return if self.any { Ok(None) } else { Err(self.sequence.nothing()) };
        };
        self.any = true;
        self.prepare(&mut frame)?;
        frame.has_camera |= self.fixed_camera.camera.is_some();
        Ok(Some(Scene::of_file(frame, self.file.clone(), &self.arrangement, self.colored_by.clone())))
    }
}

#[pymethods]
impl Sequence {
    /// `archive` has the bytes of an .npz in place of a file. `colors` are the colours of a map, as levels of sRGB. `holds`: whether the frames
    /// have the camera of the first one, for an image of this size.
    #[new]
    #[expect(clippy::too_many_arguments, reason = "what is no option of the command has an argument of its own")]
    fn new(
        py: Python<'_>,
        path: PathBuf,
        archive: Option<Vec<u8>>,
        options: &Bound<'_, PyDict>,
        keep: Option<&Bound<'_, PyAny>>,
        colors: Option<Vec<[u8; 3]>>,
        frames: &str,
        size: Option<(u32, u32)>,
        holds: bool,
    ) -> PyResult<Self> {
        let (job, keep) = (Job::default(), kept(keep)?);
        let choices = Choices::of(&written(options, Call::Read)?).or_raise()?;
        let map = colors.map(|colors| ColorMap::of_colors("own", colors)).transpose().or_raise()?;
        let mut read = choices.reading(keep, map, job.watch()).or_raise()?;
        read.particles.frames = frames.parse().or_raise()?;
        if read.hold == Hold::All {
            let mend = "use hold='first', or give the camera, the radius and the range yourself";
            return Err(Error::settings("hold='all' is an option of the command only", mend)).or_raise();
        }
        let fixed_camera = FixedCamera::new(holds && read.hold != Hold::None);
        let file = path.file_name().filter(|_| archive.is_none()).map(|name| name.to_string_lossy().into_owned());
        let sequence = job.run(py, None, || match archive {
            Some(bytes) => halfline_files::read::Sequence::from_reader(Cursor::new(bytes), &path, &read),
            None => halfline_files::read::Sequence::open(&path, &read),
        })?;
        let arrangement = choices.arrangement();
        Ok(Self(Mutex::new(Opened {
            sequence,
            arrangement,
            colored_by: choices.colored_by().map(str::to_owned),
            file,
            job,
            size,
            fixed_camera,
            any: false,
        })))
    }

    fn __iter__(this: Bound<'_, Self>) -> Bound<'_, Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Scene>> {
        let job = self.0.lock().unwrap_or_else(PoisonError::into_inner).job.clone();
        job.run(py, None, || job.lock(&self.0)?.next())
    }
}

/// Linear RGB of a colour in the words of the command: a CSS name, `#rrggbb`, or `r,g,b`.
#[pyfunction]
pub(crate) fn color(text: &str) -> PyResult<[f32; 3]> {
    style::color(text).or_raise()
}
