//! Scenes.

use crate::arrays::{list, owned, shown};
use crate::camera::Camera;
use crate::errors::{OrRaise, keywords};
use crate::paint::Paint;
use crate::work::{Job, begin};
use halfline::camera::Aperture;
use halfline::frame::legend::Legend;
use halfline::progress::Watch;
use halfline::scene::arrange::{Arrangement, Bead};
use halfline::scene::{Cell, Framing, ImagePlane, Lighting, List, check_color};
use halfline::settings::FileLook;
use halfline::{Camera as CoreCamera, Error, Scene as CoreScene, Spheres};
use halfline_files::read::Skipped;
use halfline_files::read::{Codes, ColumnValues, Columns, SceneFrame, Selection};
use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use std::sync::Arc;

/// A scene; it does not change, so that any number of threads may render it.
#[pyclass(frozen)]
pub(crate) struct Scene {
    scene: Arc<CoreScene>,
    /// Objects that its reader left out, and assumptions that it made.
    pub(crate) skipped: Skipped,
    /// The size of the lens of its file's camera; `None` for a pinhole.
    pub(crate) aperture: Option<Aperture>,
    /// Whether the camera stays, whatever the size of the image; otherwise it shows all spheres.
    is_fixed: bool,
    /// The kind of its file, and the look and the samples that it asks for.
    pub(crate) look: FileLook,
    /// Whether its default camera is that of a molecule.
    is_molecule: bool,
    /// The number of the frame in its file.
    #[pyo3(get)]
    pub(crate) number: u64,
    /// The time of the frame, if its file has it.
    #[pyo3(get)]
    time: Option<f64>,
    /// The step of the frame, if its file has it.
    #[pyo3(get)]
    step: Option<i64>,
    /// The periodic cell: a corner and three edges.
    #[pyo3(get)]
    pub(crate) cell: Option<([f64; 3], [[f64; 3]; 3])>,
    /// The periodic copies along its edges, and whether the edges are drawn.
    copies: [u32; 3],
    outlined: bool,
    /// The number of its last spheres, which are beads of these edges.
    pub(crate) beads: usize,
    /// The name of its file.
    #[pyo3(get)]
    pub(crate) file: Option<String>,
    /// The legend of its colours.
    pub(crate) legend: Option<Arc<Legend>>,
    /// The columns of the file, in the order of its spheres.
    pub(crate) columns: Arc<Columns>,
}

impl Scene {
    /// The scene of a file.
    pub(crate) fn of_file(frame: SceneFrame, file: Option<String>, arrangement: &Arrangement, is_fixed: bool) -> Self {
        let mut scene = frame.scene;
        scene.spheres.share();
        Self {
            scene: Arc::new(scene),
            skipped: frame.skipped,
            aperture: frame.aperture,
            is_fixed,
            look: frame.look,
            is_molecule: frame.is_molecule,
            number: frame.number,
            time: frame.when.time,
            step: frame.when.step,
            cell: frame.cell.map(|cell| (cell.origin, cell.edges)),
            copies: arrangement.copies,
            outlined: arrangement.outline.is_some(),
            beads: frame.beads,
            file,
            legend: frame.legend.map(Arc::new),
            columns: Arc::new(frame.columns),
        }
    }

    /// The camera and the image of a part, which stay as they are; `samples` are its own.
    pub(crate) fn of_part(scene: CoreScene, samples: u32) -> Self {
        let look = FileLook { samples: Some(samples), ..FileLook::default() };
        Self { is_fixed: true, look, ..Self::of_arrays(scene) }
    }

    /// A scene of which nothing but this is known.
    fn of_arrays(scene: CoreScene) -> Self {
        Self {
            scene: Arc::new(scene),
            skipped: Skipped::default(),
            aperture: None,
            is_fixed: false,
            is_molecule: false,
            look: FileLook::default(),
            number: 1,
            time: None,
            step: None,
            cell: None,
            copies: [1; 3],
            outlined: false,
            beads: 0,
            file: None,
            legend: None,
            columns: Arc::default(),
        }
    }

    /// The same spheres, of which there may be more, with everything that is known of them.
    fn with(&self, scene: CoreScene) -> Self {
        Self {
            scene: Arc::new(scene),
            skipped: self.skipped.clone(),
            legend: self.legend.clone(),
            columns: Arc::clone(&self.columns),
            file: self.file.clone(),
            ..*self
        }
    }

    /// The scene with the edges of its cell as beads of this radius, after all other spheres; infinite for the default one.
    pub(crate) fn with_cell(&self, radius: f64) -> halfline::Result<Self> {
        let mut scene = (*self.scene).clone();
        if !self.outlined {
            // The copies are made, and the edges are those of all of them together.
            let grown = |edge: [f64; 3], count: u32| edge.map(|x| x * f64::from(count));
            let cell = self.cell.map(|(origin, [a, b, c])| {
                let [along, across, up] = self.copies;
                Cell { origin, edges: [grown(a, along), grown(b, across), grown(c, up)] }
            });
            let arrangement = Arrangement { outline: Some(bead(radius)), ..Arrangement::default() };
            arrangement.apply(&mut scene.spheres, cell.as_ref(), &Watch::default())?;
            scene.spheres.share();
        }
        let beads = self.beads + scene.spheres.len() - self.scene.spheres.len();
        Ok(Self { outlined: true, beads, ..self.with(scene) })
    }

    /// Frames the spheres beside a legend that takes these shares of the picture's width, unless the file has a camera.
    pub(crate) fn frame_with_legend(&self, exact: &mut CoreScene, legend_shares: [f64; 2]) -> halfline::Result<()> {
        if self.is_fixed {
            return Ok(());
        }
        exact.frame_by_default(self.is_molecule, &Framing { legend_shares, ..Framing::default() })
    }

    /// The same spheres in other colours, one for each.
    ///
    /// # Errors
    /// [`Error::Settings`] naming the row.
    pub(crate) fn with_colors(&self, colors: List<[f32; 3]>) -> halfline::Result<Self> {
        let mut scene = (*self.scene).clone();
        scene.spheres.colors = Some(colors);
        check(&scene.spheres)?;
        Ok(Self { legend: None, ..self.with(scene) })
    }

    /// The same spheres, each in the colour of the last rule that selects it, and with a legend of these colours.
    /// Returns also notes on the rules.
    ///
    /// # Errors
    /// Errors of the selections, also for a column that was not kept.
    pub(crate) fn painted(&self, rules: &[(Selection, [f32; 3])]) -> halfline::Result<(Self, Vec<String>)> {
        let mut scene = (*self.scene).clone();
        let (paint, notes) = Paint::of(&self.columns, &scene.spheres, self.beads, rules)?;
        let (colors, legend) = paint.apply(&scene.spheres, rules, self.legend.as_deref());
        scene.spheres.colors = Some(colors.into());
        scene.spheres.share();
        Ok((Self { legend: legend.map(Arc::new), ..self.with(scene) }, notes))
    }

    /// The same spheres without lights, sky and mirrors.
    pub(crate) fn with_light_at_the_eye(&self) -> Self {
        self.with(CoreScene { lighting: Lighting::from_the_eye(), ..(*self.scene).clone() })
    }

    /// The periodic cell.
    pub(crate) fn periodic(&self) -> Option<Cell> {
        self.cell.map(|(origin, edges)| Cell { origin, edges })
    }

    /// The time and the step.
    pub(crate) fn when(&self) -> (Option<f64>, Option<i64>) {
        (self.time, self.step)
    }

    /// The spheres.
    pub(crate) fn spheres(&self) -> &Spheres {
        &self.scene.spheres
    }

    /// The scene with another camera or size; its own camera shows all spheres, unless it is the file's.
    pub(crate) fn exact(&self, camera: Option<&Camera>, size: Option<(u32, u32)>) -> halfline::Result<CoreScene> {
        let mut exact = self.sized(camera, size, None)?;
        if camera.is_none() {
            self.frame_with_legend(&mut exact, [0.0; 2])?;
        }
        Ok(exact)
    }

    /// The scene with another camera, size or background; its own camera is still to be framed. The spheres are shared.
    pub(crate) fn sized(
        &self,
        camera: Option<&Camera>,
        size: Option<(u32, u32)>,
        background: Option<[f32; 3]>,
    ) -> halfline::Result<CoreScene> {
        let mut scene = (*self.scene).clone();
        let own = camera.filter(|camera| camera.in_pixels).and_then(|camera| camera.size);
        if let (Some(size), Some(own)) = (size, own)
            && size != own
        {
            let problem = format!("size is {size:?}, and the camera's intrinsics belong to {own:?}");
            return Err(Error::settings(problem, "remove size, or give the intrinsics of the other size"));
        }
        if let Some(size) = size.or(camera.and_then(|camera| camera.size)) {
            (scene.image.width, scene.image.height) = size;
        }
        if let Some(color) = background {
            scene.set_background(color);
        }
        match camera {
            Some(camera) => scene.camera = camera.camera,
            None if self.is_fixed => {}
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
    /// The package passes contiguous arrays of shape (n, 3), (n,) and (n, 3).
    #[new]
    fn new(
        py: Python<'_>,
        centers: PyReadonlyArrayDyn<'_, f64>,
        radii: PyReadonlyArrayDyn<'_, f64>,
        colors: Option<PyReadonlyArrayDyn<'_, f32>>,
        background: [f32; 3],
    ) -> PyResult<Self> {
        let colors = colors.map(|colors| list::<f32, [f32; 3], 3>(&colors)).transpose()?;
        let spheres = Spheres {
            centers: list::<f64, [f64; 3], 3>(&centers)?,
            radii: list::<f64, f64, 1>(&radii)?,
            colors,
            materials: None,
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
        let mut scene = Self { number, time, step, cell, ..self.with((*self.scene).clone()) };
        scene.skipped.assumed.extend(warnings);
        scene
    }

    /// The names of the columns.
    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.columns.names().map(str::to_owned).collect()
    }

    /// The numbers of a column, by the word of a selection; of a column of texts the number of each, and the texts.
    fn column<'py>(this: &Bound<'py, Self>, word: &str) -> PyResult<(Bound<'py, PyAny>, Option<Vec<String>>)> {
        let columns = &this.get().columns;
        let (_, values) = columns.get(word).map_err(|error| PyKeyError::new_err(keywords(&error.to_string())))?;
        let (owner, py) = (this.clone().into_any(), this.py());
        #[expect(unsafe_code, reason = "arrays of the memory of this scene")]
        // SAFETY: a scene is frozen, and the array keeps it alive.
        let array = unsafe {
            match values {
                ColumnValues::Numbers(values) => shown(values, &[values.len()], owner)?.into_any(),
                ColumnValues::Whole(values) => shown(values, &[values.len()], owner)?.into_any(),
                ColumnValues::Order(count) => owned(py, (0..*count as i32).collect(), &[*count])?.into_any(),
                ColumnValues::Texts(Codes::U8(codes), _) => shown(codes, &[codes.len()], owner)?.into_any(),
                ColumnValues::Texts(Codes::U16(codes), _) => shown(codes, &[codes.len()], owner)?.into_any(),
                ColumnValues::Texts(Codes::U32(codes), _) => shown(codes, &[codes.len()], owner)?.into_any(),
            }
        };
        let texts = if let ColumnValues::Texts(_, texts) = values { Some(texts.clone()) } else { None };
        Ok((array, texts))
    }

    fn __len__(&self) -> usize {
        self.scene.spheres.len()
    }

    #[getter]
    fn centers<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let values = &this.get().scene.spheres.centers;
        #[expect(unsafe_code, reason = "an array of the memory of this scene")]
        // SAFETY: a scene is frozen, and the array keeps it alive.
        unsafe {
            shown(values.as_flattened(), &[values.len(), 3], this.clone().into_any())
        }
    }

    #[getter]
    fn radii<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let values = &this.get().scene.spheres.radii;
        #[expect(unsafe_code, reason = "an array of the memory of this scene")]
        // SAFETY: as for the centres.
        unsafe {
            shown(values, &[values.len()], this.clone().into_any())
        }
    }

    #[getter]
    fn colors<'py>(this: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyArrayDyn<f32>>>> {
        let Some(values) = &this.get().scene.spheres.colors else { return Ok(None) };
        #[expect(unsafe_code, reason = "an array of the memory of this scene")]
        // SAFETY: as for the centres.
        unsafe {
            shown(values.as_flattened(), &[values.len(), 3], this.clone().into_any()).map(Some)
        }
    }

    /// Whether a selection selects each sphere, and what is to be said about it.
    fn select<'py>(&self, py: Python<'py>, expression: &str) -> PyResult<(Bound<'py, PyArrayDyn<u8>>, Vec<String>)> {
        let selection = expression.parse::<Selection>().or_raise()?;
        let (mask, notes) = Job::default().run(py, None, || self.columns.select(&selection, &self.scene.spheres))?;
        let count = mask.len();
        let notes = notes.iter().map(|note| keywords(note)).collect();
        Ok((owned(py, mask.into_iter().map(u8::from).collect(), &[count])?, notes))
    }

    /// Columns and rows of the image.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.scene.image.width, self.scene.image.height)
    }

    /// Linear RGB of a ray that hits nothing.
    #[getter]
    fn background(&self) -> [f32; 3] {
        self.scene.image.background
    }

    /// Objects that the reader left out, and assumptions that it made, in whole sentences.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.skipped.warnings().iter().map(|warning| keywords(warning)).collect()
    }

    /// The camera for an image of this size.
    fn camera(&self, size: Option<(u32, u32)>) -> PyResult<Camera> {
        begin()?;
        let scene = self.exact(None, size).or_raise()?;
        Ok(Camera { camera: scene.camera, aperture: self.aperture, size: None, in_pixels: false })
    }

    /// Equal for equal numbers.
    fn fingerprint(&self, py: Python<'_>) -> PyResult<String> {
        begin()?;
        Ok(py.detach(|| self.scene.fingerprint()))
    }
}

/// The beads of a radius; infinite for the default one.
pub(crate) fn bead(radius: f64) -> Bead {
    if radius.is_finite() { Bead::Radius(radius) } else { Bead::Thin }
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
    let Some(colors) = &spheres.colors else { return Ok(()) };
    match colors.iter().position(|color| color.iter().any(|c| !(c.is_finite() && *c >= 0.0))) {
        Some(row) => wrong("colors", row, three(colors[row].map(f64::from)), "give linear RGB, 0 or more"),
        None => Ok(()),
    }
}

fn rule(name: &str) -> &'static str {
    match name {
        "centers" => "coordinates are finite",
        "radii" => "radii are positive and finite",
        _ => "components are finite and not negative",
    }
}
