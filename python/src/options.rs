//! The settings of a rendering from keywords, which have the names and values of the command's options.

use crate::camera::Camera;
use crate::insets::Insets;
use crate::scene::Scene;
use halfline::camera::Aperture;
use halfline::error::{Error, Result};
use halfline::intersect::Method;
use halfline::scene::{MOST_BOUNCES, MOST_RAYS};
use halfline::settings::{Accuracy, AddedLight, Backend, ChosenLook, Look, Outline, Search, Settings, Tolerance};
use halfline::window::Window;
use halfline::{Aov, Shade};
use halfline_drawing::inset::Panels;
use halfline_files::read::matte::MatteNames;
use halfline_files::write::mattes;
use pyo3::prelude::*;

/// The keywords for accuracy, method, search and tolerance.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Accurate {
    accuracy: String,
    method: Option<String>,
    search: String,
    tolerance: Option<f64>,
}

impl Accurate {
    /// The settings of these keywords.
    pub(crate) fn settings(&self) -> Result<Settings> {
        Ok(Settings {
            accuracy: self.accuracy.parse::<Accuracy>()?,
            method: self.method.as_deref().map(str::parse::<Method>).transpose()?,
            search: self.search.parse::<Search>()?,
            tolerance: self.tolerance.map(Tolerance::new).transpose()?,
            ..Settings::default()
        })
    }
}

/// A rendered scene, and what is drawn into its pictures.
pub(crate) struct Rendered {
    pub(crate) scene: halfline::Scene,
    pub(crate) frame: halfline::Frame,
    pub(crate) panels: Option<Panels>,
    /// The names of the spheres in Cryptomatte layers.
    pub(crate) mattes: Vec<MatteNames>,
    /// Whether files of its colour have an alpha.
    pub(crate) transparent: bool,
}

/// The keywords for the look of a picture, its size and the part of it that is rendered.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Picture {
    aovs: Vec<String>,
    size: Option<(u32, u32)>,
    samples: Option<u32>,
    seed: u32,
    shade: Option<String>,
    look: Option<String>,
    tone: Option<String>,
    exposure: f64,
    silhouette: bool,
    outline_width: Option<f64>,
    outline_color: Option<[f32; 3]>,
    depth_cue: bool,
    layers: u32,
    opacity_shadows: bool,
    crop: Option<[u32; 4]>,
    background: Option<[f32; 3]>,
    transparent: bool,
    sun: Vec<[f64; 3]>,
    shadows: bool,
    occlusion: Option<u32>,
    reach: Option<f64>,
    bounces: Option<u32>,
    /// The radius of the beads that draw the edges of the cell; infinite for the default one.
    cell: Option<f64>,
    cryptomatte: Vec<String>,
    pub(crate) insets: Insets,
    /// Whether lengths are float32.
    pub(crate) single: bool,
}

impl Picture {
    /// Checks the scene for what is drawn into the picture, and gives the one with the edges of its cell, if they are drawn.
    pub(crate) fn begin(&self, scene: &Scene) -> Result<Option<Scene>> {
        self.insets.check(scene, self.crop.is_some(), self.aovs()?.contains(&Aov::Color))?;
        self.cell.map(|radius| scene.with_cell(radius)).transpose()
    }

    /// The settings of a picture of `scene` with this camera, or the scene's own. A lens with a size has samples of its own, where
    /// neither the keywords nor the file say how many.
    pub(crate) fn settings(
        &self,
        scene: &Scene,
        camera: Option<&Camera>,
        accurate: Settings,
        backend: Backend,
    ) -> Result<Settings> {
        let aovs = self.aovs()?;
        let ChosenLook { look, samples, .. } = self.chosen(scene, camera)?.0;
        let light = self.light(look)?;
        let aperture = camera.map_or(scene.frame.aperture, |camera| camera.aperture);
        let open = aperture.is_some() && self.samples.or(scene.frame.look.samples).is_none();
        let crop = self.crop.map(|[x0, y0, x1, y1]| Window { x0, y0, x1, y1 });
        Ok(Settings {
            backend,
            aovs,
            samples: if open { Aperture::SAMPLES } else { samples },
            aperture,
            coverage: !self.cryptomatte.is_empty(),
            seed: self.seed,
            tone: self.tone.as_deref().map(str::parse).transpose()?,
            exposure: self.exposure,
            shade: self.shade()?.unwrap_or_default(),
            silhouette: self.silhouette || look.has_silhouette(),
            outline: Outline::of(self.outline_width, self.outline_color),
            depth_cue: self.depth_cue,
            layers: self.layers,
            opacity_shadows: self.opacity_shadows,
            sky: light.buffer_sky(),
            window: crop,
            ..accurate
        })
    }

    /// Renders the scene with this camera; what is drawn into the picture is decided before.
    pub(crate) fn render(
        &self,
        scene: &Scene,
        camera: Option<&Camera>,
        number: u64,
        mut render: impl FnMut(&halfline::Scene) -> Result<halfline::Frame>,
    ) -> Result<Rendered> {
        let (exact, warnings) = self.scene(scene, camera)?;
        exact.check()?;
        let mut panels = self.insets.panels(scene, &exact, number)?;
        let names = scene.frame.matte_names(&self.cryptomatte)?;
        let (marked, notes) = self.insets.marked(scene)?;
        let mut frame = render(&exact)?;
        frame.report.warnings.extend(warnings.into_iter().chain(notes));
        if let Some(panels) = panels.as_mut().filter(|_| self.insets.has_marks()) {
            let ids = frame.ids().to_vec();
            frame.report.warnings.extend(self.insets.add_marks(panels, &exact, &ids, &marked, render)?);
        }
        frame.report.number = number;
        frame.report.look = self.look(scene, camera)?;
        frame.report.warnings.extend(self.insets.warnings(scene, panels.as_ref()));
        frame.report.warnings.extend(mattes::warnings(&names, &frame));
        Ok(Rendered { scene: exact, frame, panels, mattes: names, transparent: self.transparent })
    }

    /// The scene with this camera, size, background and light, and warnings about keywords that change nothing.
    pub(crate) fn scene(&self, scene: &Scene, camera: Option<&Camera>) -> Result<(halfline::Scene, Vec<String>)> {
        let background = if self.transparent { Some([0.0; 3]) } else { self.background };
        let mut exact = scene.sized(camera, self.size, background)?;
        if camera.is_none() {
            let legend_shares = self.insets.legend_shares(scene, exact.image)?;
            scene.frame_with_legend(&mut exact, legend_shares)?;
        }
        let aovs = self.aovs()?;
        let (ChosenLook { look, .. }, warning) = self.chosen(scene, camera)?;
        let given = [self.outline_width.is_some(), self.outline_color.is_some()];
        let silhouette = self.silhouette || look.has_silhouette();
        let idle = Outline::idle(given, aovs.contains(&Aov::Color), silhouette);
        let light = self.light(look)?.apply(&mut exact, &aovs)?;
        let legend = self.insets.lacking(scene)?;
        Ok((exact, warning.into_iter().chain(idle).chain(light).chain(legend).collect()))
    }

    /// Columns and rows, if they are given.
    pub(crate) fn size(&self) -> Option<(u32, u32)> {
        self.size
    }

    /// The width of outlines, if it is given.
    pub(crate) fn outline_width(&self) -> Option<f64> {
        self.outline_width
    }

    fn aovs(&self) -> Result<Vec<Aov>> {
        let mut aovs = self.aovs.iter().map(|name| name.parse()).collect::<Result<Vec<Aov>>>()?;
        if self.transparent && aovs.contains(&Aov::Color) && !aovs.contains(&Aov::Alpha) {
            aovs.push(Aov::Alpha);
        }
        Ok(aovs)
    }

    fn shade(&self) -> Result<Option<Shade>> {
        self.shade.as_deref().map(str::parse).transpose()
    }

    /// The look and the samples through this camera, and a warning, by the rule of the command.
    fn chosen(&self, scene: &Scene, camera: Option<&Camera>) -> Result<(ChosenLook, Option<String>)> {
        let look = self.look.as_deref().map(str::parse).transpose()?;
        let lens = camera.map_or(&scene.frame.scene.camera, |camera| &camera.camera).lens;
        let has_picture = self.aovs()?.contains(&Aov::Color);
        Ok(scene.frame.look.choose_through(&lens, has_picture, look, self.samples, self.shade()?))
    }

    /// The name of the look, for the report; `None` without a picture.
    fn look(&self, scene: &Scene, camera: Option<&Camera>) -> Result<Option<&'static str>> {
        let look = self.chosen(scene, camera)?.0.look;
        Ok(self.aovs()?.contains(&Aov::Color).then(|| look.name()))
    }

    /// The light that the keywords add to a scene.
    ///
    /// # Errors
    /// [`Error::Settings`] for a number of rays or of bounces out of range.
    fn light(&self, look: Look) -> Result<AddedLight> {
        let range = |name: &str, value: Option<u32>, least: u32, most: u32| match value {
            Some(value) if !(least..=most).contains(&value) => {
                let mend = format!("give a whole number from {least} to {most}");
                Err(Error::settings(format!("{name} is {value}"), mend))
            }
            _ => Ok(()),
        };
        range("occlusion", self.occlusion, 0, MOST_RAYS)?;
        range("bounces", self.bounces, 0, MOST_BOUNCES)?;
        Ok(AddedLight {
            look,
            suns: self.sun.iter().map(|sun| (*sun).into()).collect(),
            shadows: self.shadows,
            // 0 stands for the scene's number.
            occlusion: self.occlusion.map(|rays| Some(rays).filter(|rays| *rays > 0)),
            reach: self.reach,
            bounces: self.bounces,
        })
    }
}
