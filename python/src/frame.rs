//! Frames: their buffers as arrays, their report, their files.

use crate::arrays::shown;
use crate::errors::OrRaise;
use crate::renderer::{Shared, keep_if_forked};
use crate::work::{Job, begin};
use halfline::error::{Error, Result};
use halfline::frame::Data;
use halfline::render::origin;
use halfline::settings::Settings;
use halfline::write::file::Target;
use halfline::write::format::{FileFormat, FormatOptions};
use halfline::{Aov, Frame as Exact, Scene};
use numpy::PyArrayDyn;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use std::path::PathBuf;

/// A frame. Its buffers do not change; when the last array of them is gone, the renderer gets their memory back.
#[pyclass(frozen)]
pub(crate) struct Frame {
    /// Present until it is dropped.
    frame: Option<Exact>,
    scene: Scene,
    settings: Settings,
    renderer: Shared,
}

impl Frame {
    pub(crate) fn new(frame: Exact, scene: Scene, settings: Settings, renderer: Shared) -> Self {
        Self { frame: Some(frame), scene, settings, renderer }
    }

    fn exact(&self) -> Result<&Exact> {
        self.frame.as_ref().ok_or_else(|| Error::settings("the frame is gone", "render another one"))
    }

    /// The file at `path` with these buffers, or those that suit its format.
    fn target(&self, path: PathBuf, aovs: Option<Vec<String>>, style: FormatOptions) -> Result<Target> {
        if let Some(names) = aovs {
            let aovs = names.iter().map(|name| name.parse()).collect::<Result<Vec<Aov>>>()?;
            return Target::new(&aovs, &path, style);
        }
        let all: Vec<Aov> = self.exact()?.buffers.iter().map(|buffer| buffer.aov).collect();
        let format = FileFormat::of(&path);
        let takes = |aov: &Aov| format.is_none_or(|format| format.takes(*aov));
        let fits: Vec<Aov> = all.iter().copied().filter(takes).collect();
        match (&fits[..], format) {
            (_, Some(format)) if format.holds_many() && !fits.is_empty() => Target::new(&fits, &path, style),
            _ if fits.contains(&Aov::Color) => Target::new(&[Aov::Color], &path, style),
            // Ids are in every frame, so the other buffer is the requested one.
            ([Aov::Id, other] | [other, Aov::Id] | [other], _) => Target::new(&[*other], &path, style),
            ([], _) => Target::new(&all, &path, style),
            _ => {
                let names: Vec<_> = fits.iter().map(|aov| aov.name()).collect();
                let problem = format!("{} holds one buffer, and the frame has {}", path.display(), names.join(", "));
                Err(Error::settings(problem, "name one with aovs=, or use .npz or .exr"))
            }
        }
    }
}

impl Drop for Frame {
    fn drop(&mut self) {
        keep_if_forked(&self.renderer);
        // A renderer that is at work does not wait for memory.
        if let (Some(frame), Ok(mut place)) = (self.frame.take(), self.renderer.try_lock())
            && let Some(renderer) = place.as_mut()
        {
            renderer.recycle(frame);
        }
    }
}

#[pymethods]
impl Frame {
    /// Columns and rows of the part that was rendered.
    #[getter]
    fn size(&self) -> PyResult<(u32, u32)> {
        self.exact().map(|frame| (frame.width, frame.height)).or_raise()
    }

    /// The names of the buffers.
    #[getter]
    fn names(&self) -> PyResult<Vec<&'static str>> {
        Ok(self.exact().or_raise()?.buffers.iter().map(|buffer| buffer.aov.name()).collect())
    }

    /// A buffer as a read-only array that keeps the frame alive.
    fn array<'py>(this: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let aov = name.parse::<Aov>().or_raise()?;
        let frame = this.get().exact().or_raise()?;
        let Some(buffer) = frame.get(aov) else {
            let problem = format!("the frame has no buffer {name}; ask for it with aovs=['{name}']");
            return Err(PyKeyError::new_err(problem));
        };
        let owner = this.clone().into_any();
        #[expect(unsafe_code, reason = "arrays of the memory of this frame")]
        // SAFETY: a frame is frozen, its buffers move only when it is dropped, and the array keeps it alive.
        unsafe {
            match &buffer.data {
                Data::F32(values) => shown(values, &buffer.shape, owner).map(Bound::<PyArrayDyn<f32>>::into_any),
                Data::F64(values) => shown(values, &buffer.shape, owner).map(Bound::<PyArrayDyn<f64>>::into_any),
                Data::I32(values) => shown(values, &buffer.shape, owner).map(Bound::<PyArrayDyn<i32>>::into_any),
                Data::I64(values) => shown(values, &buffer.shape, owner).map(Bound::<PyArrayDyn<i64>>::into_any),
                Data::U8(values) => shown(values, &buffer.shape, owner).map(Bound::<PyArrayDyn<u8>>::into_any),
                _ => Err(Error::settings(format!("{name} has another type"), "update halfline")).or_raise(),
            }
        }
    }

    /// The picture in 8-bit sRGB, (H, W, 3), in an array of its own.
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        begin()?;
        let frame = self.exact().or_raise()?;
        let Some(image) = frame.image() else {
            return Err(Error::settings("the frame has no colour", "add color to aovs")).or_raise();
        };
        let bytes = image.pixels().flat_map(|pixel| [pixel.0[0], pixel.0[1], pixel.0[2]]).collect();
        crate::arrays::owned(py, bytes, &[frame.height as usize, frame.width as usize, 3])
    }

    /// The report as JSON.
    fn report(&self) -> PyResult<String> {
        crate::reports::json(&self.exact().or_raise()?.report)
    }

    /// Writes a file, completely or not at all.
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        aovs: Option<Vec<String>>,
        bits: u32,
        unit: f64,
        no_return: &str,
    ) -> PyResult<()> {
        let style = FormatOptions {
            bits: bits.to_string().parse().or_raise()?,
            unit,
            no_return: no_return.parse().or_raise()?,
            ..FormatOptions::default()
        };
        let target = self.target(path, aovs, style).or_raise()?;
        let job = Job::default();
        job.run(py, None, || {
            target.check()?;
            let frame = self.exact()?;
            let origin = origin(&self.scene, &self.settings, &frame.report, frame.window);
            target.write_while(frame, &origin, &|| !job.cancel.is_cancelled())
        })
    }
}
