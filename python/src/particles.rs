//! Particles of files, without a scene.

use crate::arrays::{owned, shown};
use crate::columns::column;
use crate::errors::OrRaise;
use crate::words::written;
use crate::work::Job;
use halfline_command::choices::{Choices, in_keywords};
use halfline_command::shown::Call;
use halfline_files::read::{Columns, Keep, Selection};
use halfline_particles::Frames;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// The particles of a frame.
#[pyclass(frozen)]
pub(crate) struct Particles {
    frame: halfline_particles::Particles,
    columns: Columns,
    number: u64,
}

#[pymethods]
impl Particles {
    fn __len__(&self) -> usize {
        self.frame.positions.len()
    }

    #[getter]
    fn number(&self) -> u64 {
        self.number
    }

    #[getter]
    fn time(&self) -> Option<f64> {
        self.frame.when.time
    }

    #[getter]
    fn step(&self) -> Option<i64> {
        self.frame.when.step
    }

    #[getter]
    fn cell(&self) -> Option<([f64; 3], [[f64; 3]; 3])> {
        self.frame.cell.map(|cell| (cell.origin, cell.edges))
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.frame.skipped.warnings().iter().map(|warning| in_keywords(warning)).collect()
    }

    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.columns.names().map(str::to_owned).collect()
    }

    fn column<'py>(this: &Bound<'py, Self>, word: &str) -> PyResult<(Bound<'py, PyAny>, Option<Vec<String>>)> {
        // SAFETY: particles are frozen, and the array keeps them alive.
        #[expect(unsafe_code, reason = "arrays of the memory of these particles")]
        unsafe {
            column(&this.get().columns, word, this.clone().into_any())
        }
    }

    #[getter]
    fn positions<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let values = &this.get().frame.positions;
        // SAFETY: as for the columns.
        #[expect(unsafe_code, reason = "an array of the memory of these particles")]
        unsafe {
            shown(values.as_flattened(), &[values.len(), 3], this.clone().into_any())
        }
    }

    #[getter]
    fn radii<'py>(this: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        let values = &this.get().frame.radii;
        if values.is_empty() {
            return Ok(None);
        }
        // SAFETY: as for the columns.
        #[expect(unsafe_code, reason = "an array of the memory of these particles")]
        unsafe {
            shown(values, &[values.len()], this.clone().into_any()).map(Some)
        }
    }

    #[getter]
    fn colors<'py>(this: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyArrayDyn<f32>>>> {
        let values = &this.get().frame.colors;
        if values.is_empty() {
            return Ok(None);
        }
        // SAFETY: as for the columns.
        #[expect(unsafe_code, reason = "an array of the memory of these particles")]
        unsafe {
            shown(values.as_flattened(), &[values.len(), 3], this.clone().into_any()).map(Some)
        }
    }

    /// Whether a selection selects each particle, and what is to be said about it.
    fn select<'py>(&self, py: Python<'py>, expression: &str) -> PyResult<(Bound<'py, PyArrayDyn<u8>>, Vec<String>)> {
        let selection = expression.parse::<Selection>().or_raise()?;
        let (positions, radii) = (&self.frame.positions, &self.frame.radii);
        let (mask, notes) = Job::default().run(py, None, || self.columns.select(&selection, positions, radii))?;
        let count = mask.len();
        let notes = notes.iter().map(|note| in_keywords(note)).collect();
        Ok((owned(py, mask.into_iter().map(u8::from).collect(), &[count])?, notes))
    }
}

/// An opened file, whose frames are read one after the other.
#[pyclass(frozen)]
pub(crate) struct ParticleFrames(Mutex<Opened>);

struct Opened {
    frames: Frames,
    job: Job,
}

#[pymethods]
impl ParticleFrames {
    #[new]
    fn new(py: Python<'_>, path: PathBuf, options: &Bound<'_, PyDict>, frames: &str) -> PyResult<Self> {
        let (job, choices) = (Job::default(), Choices::of(&written(options, Call::Read)?).or_raise()?);
        let mut options = choices.reading(Keep::All, None, job.watch()).or_raise()?.particles;
        options.frames = frames.parse().or_raise()?;
        let frames = job.run(py, None, || Frames::open(&path, &options))?;
        Ok(Self(Mutex::new(Opened { frames, job })))
    }

    fn __iter__(this: Bound<'_, Self>) -> Bound<'_, Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Particles>> {
        let job = self.0.lock().unwrap_or_else(PoisonError::into_inner).job.clone();
        job.run(py, None, || {
            let frames = &mut job.lock(&self.0)?.frames;
            let Some(frame) = frames.next().transpose()? else { return Ok(None) };
            let (columns, number) = (Columns::of(&frame)?, frames.passed());
            Ok(Some(Particles { frame, columns, number }))
        })
    }
}
