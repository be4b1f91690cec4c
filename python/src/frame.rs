//! Frames: their buffers as arrays, their report, their files.

use crate::arrays::shown;
use crate::errors::OrRaise;
use crate::shared::Shared;
use crate::words::written;
use crate::work::{Job, begin};
use halfline::error::{Error, Result};
use halfline::frame::Data;
use halfline::frame::provenance::Origin;
use halfline::parallel;
use halfline::render::origin;
use halfline::settings::Settings;
use halfline::{Aov, Frame as CoreFrame, Scene};
use halfline_command::choices::{Choices, Rendered, in_keywords};
use halfline_command::shown::Call;
use halfline_drawing::inset::Panels;
use halfline_files::read::matte::MatteNames;
use halfline_files::write::file::Target;
use halfline_files::write::format::{FileFormat, FormatOptions};
use numpy::PyArrayDyn;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;
use std::sync::OnceLock;

/// A frame. Its buffers do not change; when the last array of them is gone, the renderer gets their memory back.
#[pyclass(frozen)]
pub(crate) struct Frame {
    /// Present until it is dropped.
    frame: Option<CoreFrame>,
    scene: Scene,
    settings: Settings,
    renderer: Shared,
    /// The panels that are drawn into its pictures; `None` without insets.
    panels: Option<Panels>,
    /// The names of the Cryptomatte layers of its .exr files.
    mattes: Vec<MatteNames>,
    /// Whether files of its colour have an alpha.
    transparent: bool,
    /// Lengths in float32, each buffer rounded at its first use; `None` if lengths are float64.
    rounded: Option<Rounded>,
}

/// Distance, depth and position in float32.
#[derive(Default)]
struct Rounded([OnceLock<Vec<f32>>; 3]);

impl Rounded {
    /// The nearest float32 of each value, ties to even; beyond the largest one infinity. `None` for other buffers.
    fn of(&self, aov: Aov, values: &[f64]) -> Option<&[f32]> {
        let place = [Aov::Distance, Aov::Depth, Aov::Position].iter().position(|known| *known == aov)?;
        Some(self.0[place].get_or_init(|| parallel::map(values, |value| *value as f32)))
    }
}

impl Frame {
    pub(crate) fn new(rendered: Rendered, single: bool, renderer: Shared) -> Self {
        let Rendered { scene, settings, frame, panels, mattes, transparent } = rendered;
        let frame = Some(frame);
        Self { frame, scene, settings, renderer, panels, mattes, transparent, rounded: single.then(Rounded::default) }
    }

    /// A copy of these buffers of the frame, with the panels in its colour.
    fn drawn(&self, panels: &Panels, aovs: &[Aov]) -> Result<CoreFrame> {
        let exact = self.exact()?;
        let mut frame = CoreFrame {
            buffers: exact.buffers.iter().filter(|buffer| aovs.contains(&buffer.aov)).cloned().collect(),
            coverage: exact.coverage.clone(),
            report: exact.report.clone(),
            ..*exact
        };
        panels.draw(&mut frame, self.transparent);
        Ok(frame)
    }

    /// Calls `write` with the frame as a file shows it. As in files of the command: numbers are of the scene, and
    /// pictures show what is drawn into them.
    fn with_drawn<T>(
        &self,
        (target, trims): &mut (Target, bool),
        write: impl FnOnce(&Target, &CoreFrame, &Origin<'_>) -> Result<T>,
    ) -> Result<T> {
        let is_picture = target.format().is_picture() && target.aovs().contains(&Aov::Color);
        let panels = self.panels.as_ref().filter(|_| is_picture);
        if let Some(panels) = panels {
            target.set_drawn(panels.words());
        }
        if target.format() == FileFormat::Exr {
            target.set_mattes(&self.mattes);
        }
        let frame = self.exact()?;
        let drawn = panels.map(|panels| self.drawn(panels, &[target.aovs(), &[Aov::Id]].concat())).transpose()?;
        let shown = drawn.as_ref().unwrap_or(frame);
        let content = trims.then(|| shown.content(self.scene.image.background)).flatten();
        let part = content.map(|window| shown.cut(window));
        let written = part.as_ref().unwrap_or(shown);
        let origin = origin(&self.scene, &self.settings, &frame.report, written.window);
        write(target, written, &origin)
    }

    /// The file at `path` with these buffers, by the keywords of `Frame.save`, and whether they are trimmed.
    fn target_of(
        &self,
        path: PathBuf,
        aovs: Option<Vec<String>>,
        options: &Bound<'_, PyDict>,
    ) -> PyResult<(Target, bool)> {
        let choices = Choices::of(&written(options, Call::Save)?).or_raise()?;
        let style = choices.format_options(self.transparent);
        let target = self.target(path, aovs, style).and_then(|target| choices.check_file(&target).map(|()| target));
        Ok((target.or_raise()?, choices.trims()))
    }

    /// Warnings about what a PNG file cannot hold of these buffers; those about masks are in the report.
    fn file_warnings(&self, target: &Target) -> Result<Vec<String>> {
        let is_png = target.format() == FileFormat::Png;
        let warnings = if is_png { target.warnings(self.exact()?) } else { Vec::new() };
        Ok(warnings.iter().map(|warning| in_keywords(warning)).collect())
    }

    fn exact(&self) -> Result<&CoreFrame> {
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
        if let Some(frame) = self.frame.take() {
            self.renderer.recycle(frame);
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
        let rounded = match (&this.get().rounded, &buffer.data) {
            (Some(rounded), Data::F64(values)) => this.py().detach(|| rounded.of(aov, values)),
            _ => None,
        };
        #[expect(unsafe_code, reason = "arrays of the memory of this frame")]
        // SAFETY: a frame is frozen, its buffers move only when it is dropped, and the array keeps it alive.
        unsafe {
            if let Some(values) = rounded {
                return shown(values, &buffer.shape, owner).map(Bound::<PyArrayDyn<f32>>::into_any);
            }
            match &buffer.data {
                Data::F32(values) => shown(values, &buffer.shape, owner).map(Bound::<PyArrayDyn<f32>>::into_any),
                Data::F64(values) => shown(values, &buffer.shape, owner).map(Bound::<PyArrayDyn<f64>>::into_any),
                Data::I32(values) => shown(values, &buffer.shape, owner).map(Bound::<PyArrayDyn<i32>>::into_any),
                Data::I64(values) => shown(values, &buffer.shape, owner).map(Bound::<PyArrayDyn<i64>>::into_any),
                Data::U8(values) => shown(values, &buffer.shape, owner).map(Bound::<PyArrayDyn<u8>>::into_any),
            }
        }
    }

    /// The picture in 8-bit sRGB, (H, W, 3), in an array of its own.
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        begin()?;
        let frame = self.exact().or_raise()?;
        let drawn = self.panels.as_ref().map(|panels| self.drawn(panels, &[Aov::Color])).transpose().or_raise()?;
        let shown = drawn.as_ref().unwrap_or(frame);
        let Some(bytes) = py.detach(|| shown.levels()) else {
            return Err(Error::settings("the frame has no colour", "add color to aovs")).or_raise();
        };
        crate::arrays::owned(py, bytes, &[frame.height as usize, frame.width as usize, 3])
    }

    /// The report as JSON.
    fn report(&self) -> PyResult<String> {
        crate::reports::json(&self.exact().or_raise()?.report)
    }

    /// The bytes of a PNG file of these buffers, as `save` writes it.
    fn encode<'py>(
        &self,
        py: Python<'py>,
        aovs: Option<Vec<String>>,
        options: &Bound<'py, PyDict>,
    ) -> PyResult<(Bound<'py, PyBytes>, Vec<String>)> {
        let mut target = self.target_of("frame.png".into(), aovs, options)?;
        let job = Job::default();
        let bytes = job.run(py, None, || {
            self.with_drawn(&mut target, |target, frame, origin| {
                target.encode(frame, origin, &|| !job.cancel.is_cancelled())
            })
        })?;
        Ok((PyBytes::new(py, &bytes), self.file_warnings(&target.0).or_raise()?))
    }

    /// Writes a file, completely or not at all.
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        aovs: Option<Vec<String>>,
        options: &Bound<'_, PyDict>,
    ) -> PyResult<Vec<String>> {
        let mut target = self.target_of(path, aovs, options)?;
        let job = Job::default();
        job.run(py, None, || {
            target.0.check()?;
            self.with_drawn(&mut target, |target, frame, origin| {
                target.write_while(frame, origin, &|| !job.cancel.is_cancelled())
            })
        })?;
        self.file_warnings(&target.0).or_raise()
    }
}
