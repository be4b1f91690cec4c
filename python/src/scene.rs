//! Scenes.

use crate::arrays::{list, owned, shown};
use crate::camera::Camera;
use crate::color::Color;
use crate::columns::column;
use crate::errors::OrRaise;
use crate::work::{Job, begin};
use halfline::scene::arrange::Arrangement;
use halfline::scene::{Cell, Framing, ImagePlane, check_color, is_opacity};
use halfline::settings::FileLook;
use halfline::{Camera as CoreCamera, Error, Scene as CoreScene, Spheres};
use halfline_command::choices::{ChosenScene, in_keywords};
use halfline_files::read::cut::CutRules;
use halfline_files::read::{FrameTime, SceneFrame, Selection};
use halfline_files::write::file::check_writable;
use halfline_files::write::glb;
use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A scene; it does not change, so that any number of threads may render it.
#[pyclass(frozen)]
pub(crate) struct Scene {
    /// The spheres and what its file says of them. The camera stays, whatever the size of the image, where it has one;
    /// otherwise it shows all spheres.
    pub(crate) frame: SceneFrame,
    /// The periodic copies along the edges of the cell, and whether these edges are drawn.
    copies: [u32; 3],
    pub(crate) outlined: bool,
    /// The name of its file.
    pub(crate) file: Option<String>,
    /// The columns that give the colours.
    pub(crate) colored_by: Option<String>,
}

impl Scene {
    /// The scene of a file, coloured by these columns.
    pub(crate) fn of_file(
        mut frame: SceneFrame,
        file: Option<String>,
        arrangement: &Arrangement,
        colored_by: Option<String>,
    ) -> Self {
        frame.scene.spheres.share();
        Self { frame, copies: arrangement.copies, outlined: arrangement.outline.is_some(), file, colored_by }
    }

    /// The camera and the image of a part, which stay as they are; `samples` are its own.
    pub(crate) fn of_part(scene: CoreScene, samples: u32) -> Self {
        let mut scene = Self::of_arrays(scene);
        scene.frame.has_camera = true;
        scene.frame.look.samples = Some(samples);
        scene
    }

    /// A scene with nothing known of it but this.
    fn of_arrays(scene: CoreScene) -> Self {
        let frame = SceneFrame { look: FileLook::default(), ..SceneFrame::new(1, scene) };
        Self { frame, copies: [1; 3], outlined: false, file: None, colored_by: None }
    }

    /// The scene of a frame with the same spheres, or with more of them.
    fn with(&self, frame: SceneFrame) -> Self {
        let (file, colored_by) = (self.file.clone(), self.colored_by.clone());
        Self { frame, file, colored_by, ..*self }
    }

    /// The cell of all copies together, which are made.
    pub(crate) fn edges(&self) -> Option<Cell> {
        let grown = |(edge, count): ([f64; 3], u32)| edge.map(|x| x * f64::from(count));
        self.frame.cell.map(|Cell { origin, edges: [a, b, c] }| {
            let [along, across, up] = self.copies;
            Cell { origin, edges: [(a, along), (b, across), (c, up)].map(grown) }
        })
    }

    /// The scene for a picture with this camera and size, as frame `number`.
    pub(crate) fn chosen(
        &self,
        camera: Option<&Camera>,
        size: Option<(u32, u32)>,
        number: u64,
    ) -> halfline::Result<ChosenScene<'_>> {
        let scene = self.sized(camera, size)?;
        let mut frame = SceneFrame { number, scene, ..self.frame.clone() };
        if let Some(camera) = camera {
            (frame.has_camera, frame.aperture) = (true, camera.aperture);
        }
        Ok(ChosenScene {
            frame,
            edges: self.edges(),
            is_outlined: self.outlined,
            file: self.file.clone(),
            colored_by: self.colored_by.as_deref(),
            part: None,
        })
    }

    /// The frame with its planes and these, which cut spheres for given rays.
    pub(crate) fn cut_for_rays(&self, rules: &CutRules) -> halfline::Result<SceneFrame> {
        let mut frame = self.frame.clone();
        frame.cut_for_rays(rules)?;
        Ok(frame)
    }

    /// The spheres.
    pub(crate) fn spheres(&self) -> &Spheres {
        &self.frame.scene.spheres
    }

    /// The scene with another camera or size; its own camera shows all spheres, unless it is the file's.
    pub(crate) fn exact(&self, camera: Option<&Camera>, size: Option<(u32, u32)>) -> halfline::Result<CoreScene> {
        let mut exact = self.sized(camera, size)?;
        if camera.is_none() && !self.frame.has_camera {
            exact.frame_by_default(self.frame.is_molecule, &Framing::default())?;
        }
        Ok(exact)
    }

    /// The scene with another camera or size; its own camera is still to be framed. The spheres are shared.
    pub(crate) fn sized(&self, camera: Option<&Camera>, size: Option<(u32, u32)>) -> halfline::Result<CoreScene> {
        let mut scene = self.frame.scene.clone();
        let own = [scene.image.width, scene.image.height];
        if let (Some(camera), Some(size)) = (camera, size) {
            camera.check_size(size)?;
        }
        if let Some(size) = size.or(camera.and_then(|camera| camera.size)) {
            (scene.image.width, scene.image.height) = size;
        }
        match camera {
            Some(camera) => scene.camera = camera.for_image((scene.image.width, scene.image.height)),
            None if self.frame.has_camera => {
                scene.camera.lens = scene.camera.lens.resized(own, [scene.image.width, scene.image.height]);
            }
            // A size without pixels has no shape; it is refused before the camera is.
            None => {
                let size = [scene.image.width.into(), scene.image.height.into()];
                halfline::scene::check_size(size, || "size".into())?;
            }
        }
        Ok(scene)
    }
}

#[pymethods]
impl Scene {
    /// The package passes contiguous arrays of shape (n, 3), (n,), (n, 3) and (n,).
    #[new]
    fn new(
        py: Python<'_>,
        centers: PyReadonlyArrayDyn<'_, f64>,
        radii: PyReadonlyArrayDyn<'_, f64>,
        colors: Option<PyReadonlyArrayDyn<'_, f32>>,
        opacities: Option<PyReadonlyArrayDyn<'_, f32>>,
        background: [f32; 3],
    ) -> PyResult<Self> {
        let colors = colors.map(|colors| list::<f32, [f32; 3], 3>(&colors)).transpose()?;
        let opacities = opacities.map(|opacities| list::<f32, f32, 1>(&opacities)).transpose()?;
        let spheres = Spheres {
            centers: list::<f64, [f64; 3], 3>(&centers)?,
            radii: list::<f64, f64, 1>(&radii)?,
            colors,
            materials: None,
            opacities,
            cuts: None,
        };
        py.detach(|| check(&spheres)).or_raise()?;
        check_color(background, || "background".into()).or_raise()?;
        let scene = CoreScene {
            camera: CoreCamera::CANONICAL,
            image: ImagePlane { background, ..ImagePlane::default() },
            spheres,
            lighting: Default::default(),
        };
        Ok(Self::of_arrays(scene))
    }

    /// The same spheres with what another program says of them.
    fn with_facts(
        &self,
        warnings: Vec<String>,
        number: u64,
        time: Option<f64>,
        step: Option<i64>,
        cell: Option<([f64; 3], [[f64; 3]; 3])>,
    ) -> Self {
        let cell = cell.map(|(origin, edges)| Cell { origin, edges });
        let mut frame = SceneFrame { number, when: FrameTime { time, step }, cell, ..self.frame.clone() };
        frame.skipped.assumed.extend(warnings);
        self.with(frame)
    }

    /// The same spheres with the columns of another scene, of as many.
    fn with_columns(&self, other: &Self) -> Self {
        self.with(SceneFrame { columns: other.frame.columns.clone(), ..self.frame.clone() })
    }

    /// The same spheres in the look of scenes of arrays, with another background.
    fn as_arrays(&self, background: [f32; 3]) -> PyResult<Self> {
        check_color(background, || "background".into()).or_raise()?;
        let mut frame = SceneFrame { look: FileLook::default(), ..self.frame.clone() };
        frame.scene.image.background = background;
        Ok(self.with(frame))
    }

    /// The number of the frame in its file.
    #[getter]
    fn number(&self) -> u64 {
        self.frame.number
    }

    /// The time of the frame, if its file has it.
    #[getter]
    fn time(&self) -> Option<f64> {
        self.frame.when.time
    }

    /// The step of the frame, if its file has it.
    #[getter]
    fn step(&self) -> Option<i64> {
        self.frame.when.step
    }

    /// The periodic cell: a corner and three edges.
    #[getter]
    fn cell(&self) -> Option<([f64; 3], [[f64; 3]; 3])> {
        self.frame.cell.map(|Cell { origin, edges }| (origin, edges))
    }

    /// The same spheres in the colours of these rows.
    fn with_colors(&self, colors: PyReadonlyArrayDyn<'_, f32>) -> PyResult<Self> {
        let mut frame = SceneFrame { legend: None, ..self.frame.clone() };
        frame.scene.spheres.colors = Some(list::<f32, [f32; 3], 3>(&colors)?);
        check(&frame.scene.spheres).or_raise()?;
        Ok(Self { colored_by: None, ..self.with(frame) })
    }

    /// The same spheres, with a colour for those that each expression selects, the last one wins; and what is to be said
    /// about it.
    fn painted(&self, py: Python<'_>, rules: Vec<(String, Color)>) -> PyResult<(Self, Vec<String>)> {
        let rules = rules.iter().map(|(text, color)| Ok((text.parse::<Selection>()?, color.paint()?)));
        let rules = rules.collect::<halfline::Result<Vec<_>>>().or_raise()?;
        let (frame, notes) = Job::default().run(py, None, || self.frame.painted(&rules))?;
        Ok((self.with(frame), notes))
    }

    /// The names of the columns.
    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.frame.columns.names().map(str::to_owned).collect()
    }

    /// The numbers of a column, by the word of a selection; of a column of texts the number of each, and the texts.
    fn column<'py>(this: &Bound<'py, Self>, word: &str) -> PyResult<(Bound<'py, PyAny>, Option<Vec<String>>)> {
        // SAFETY: a scene is frozen, and the array keeps it alive.
        #[expect(unsafe_code, reason = "arrays of the memory of this scene")]
        unsafe {
            column(&this.get().frame.columns, word, this.clone().into_any())
        }
    }

    fn __len__(&self) -> usize {
        self.frame.scene.spheres.len()
    }

    #[getter]
    fn centers<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let values = &this.get().frame.scene.spheres.centers;
        #[expect(unsafe_code, reason = "an array of the memory of this scene")]
        // SAFETY: a scene is frozen, and the array keeps it alive.
        unsafe {
            shown(values.as_flattened(), &[values.len(), 3], this.clone().into_any())
        }
    }

    #[getter]
    fn radii<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let values = &this.get().frame.scene.spheres.radii;
        #[expect(unsafe_code, reason = "an array of the memory of this scene")]
        // SAFETY: as for the centres.
        unsafe {
            shown(values, &[values.len()], this.clone().into_any())
        }
    }

    #[getter]
    fn colors<'py>(this: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyArrayDyn<f32>>>> {
        let Some(values) = &this.get().frame.scene.spheres.colors else { return Ok(None) };
        #[expect(unsafe_code, reason = "an array of the memory of this scene")]
        // SAFETY: as for the centres.
        unsafe {
            shown(values.as_flattened(), &[values.len(), 3], this.clone().into_any()).map(Some)
        }
    }

    #[getter]
    fn opacities<'py>(this: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyArrayDyn<f32>>>> {
        let Some(values) = &this.get().frame.scene.spheres.opacities else { return Ok(None) };
        #[expect(unsafe_code, reason = "an array of the memory of this scene")]
        // SAFETY: as for the centres.
        unsafe {
            shown(values, &[values.len()], this.clone().into_any()).map(Some)
        }
    }

    /// Whether a selection selects each sphere, and what is to be said about it.
    fn select<'py>(&self, py: Python<'py>, expression: &str) -> PyResult<(Bound<'py, PyArrayDyn<u8>>, Vec<String>)> {
        let selection = expression.parse::<Selection>().or_raise()?;
        let (mask, notes) = Job::default().run(py, None, || self.frame.selected(&selection))?;
        let count = mask.len();
        let notes = notes.iter().map(|note| in_keywords(note)).collect();
        Ok((owned(py, mask.into_iter().map(u8::from).collect(), &[count])?, notes))
    }

    /// Columns and rows of the image.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.frame.scene.image.width, self.frame.scene.image.height)
    }

    /// Linear RGB of a ray that hits nothing.
    #[getter]
    fn background(&self) -> [f32; 3] {
        self.frame.scene.image.background
    }

    /// Objects that the reader left out, and assumptions that it made, in whole sentences.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.frame.skipped.warnings().iter().map(|warning| in_keywords(warning)).collect()
    }

    /// The camera for an image of this size.
    fn camera(&self, size: Option<(u32, u32)>) -> PyResult<Camera> {
        begin()?;
        let scene = self.exact(None, size).or_raise()?;
        Ok(Camera::of(scene.camera, self.frame.aperture, (scene.image.width, scene.image.height)))
    }

    /// Writes the spheres, and this camera or their own, as a model; warnings.
    fn save(&self, py: Python<'_>, path: PathBuf, camera: Option<&Camera>) -> PyResult<Vec<String>> {
        let warning = Job::default().run(py, None, || {
            if !glb::is_glb(&path) {
                let problem = format!("{} cannot hold spheres", path.display());
                return Err(Error::settings(problem, "use the file name extension .glb"));
            }
            check_writable(&path)?;
            glb::write(&path, &self.exact(camera, None)?)
        })?;
        Ok(warning.iter().map(|warning| in_keywords(warning)).collect())
    }

    /// Equal for equal numbers.
    fn fingerprint(&self, py: Python<'_>) -> PyResult<String> {
        begin()?;
        Ok(py.detach(|| self.frame.scene.fingerprint()))
    }
}

/// Checks the spheres; an error names the argument and the row.
fn check(spheres: &Spheres) -> halfline::Result<()> {
    let wrong = |name: &str, row: usize, found: String, mend: &str| {
        Err(Error::settings(format!("{name}[{row}] is {found}: {}", rule(name)), mend))
    };
    let three = |[x, y, z]: [f64; 3]| format!("[{x}, {y}, {z}]");
    if let Some(row) = spheres.centers.iter().position(|center| center.iter().any(|x| !x.is_finite())) {
        return wrong("centers", row, three(spheres.centers[row]), "remove the sphere or give it three finite numbers");
    }
    if let Some(row) = spheres.radii.iter().position(|radius| !(*radius > 0.0 && radius.is_finite())) {
        return wrong("radii", row, spheres.radii[row].to_string(), "remove the sphere or give it a radius");
    }
    let colors = spheres.colors.as_deref().unwrap_or_default();
    if let Some(row) = colors.iter().position(|color| color.iter().any(|c| !(c.is_finite() && *c >= 0.0))) {
        return wrong("colors", row, three(colors[row].map(f64::from)), "give linear RGB, 0 or more");
    }
    let opacities = spheres.opacities.as_deref().unwrap_or_default();
    match opacities.iter().position(|opacity| !is_opacity(*opacity)) {
        Some(row) => wrong("opacities", row, opacities[row].to_string(), "remove the sphere or give it an opacity"),
        None => Ok(()),
    }
}

fn rule(name: &str) -> &'static str {
    match name {
        "centers" => "coordinates are finite",
        "radii" => "radii are positive and finite",
        "opacities" => "opacities are above 0 and at most 1",
        _ => "components are finite and not negative",
    }
}
