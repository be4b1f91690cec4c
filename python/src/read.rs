//! Reading of scene and particle files, with the options of the command.

use crate::color::Color;
use crate::errors::OrRaise;
use crate::scene::{Scene, bead};
use crate::work::Job;
use halfline::error::{Error, Result};
use halfline::frame::color_map::ColorMap;
use halfline::scene::arrange::Arrangement;
use halfline::scene::{Material, MaterialName, is_opacity};
use halfline_files::read::style::{self, Coloring, Scale};
use halfline_files::read::{
    Altloc, AtomStyle, ColumnNames, FixedCamera, Format, FrameRange, Hold, Identity, Keep, Periodic, ReadOptions,
    SceneFrame, Selection, Style,
};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::{Mutex, PoisonError};

/// A colour map: a name or a file, or colours at equal steps.
#[derive(FromPyObject)]
enum MapValue {
    Name(String),
    Colors(Vec<[u8; 3]>),
}

impl MapValue {
    fn map(&self) -> Result<ColorMap> {
        match self {
            Self::Name(name) => style::color_map(name),
            Self::Colors(colors) => ColorMap::of_colors("own", colors.clone()),
        }
    }
}

/// The options of the command that decide about the spheres.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Options {
    format: Option<String>,
    columns: Option<String>,
    atom_style: Option<String>,
    frames: Option<String>,
    hold: String,
    topology: Option<PathBuf>,
    identity: Option<String>,
    model: Option<i64>,
    altloc: String,
    assembly: Option<String>,
    as_listed: bool,
    strict: bool,
    skip_invalid: bool,
    select: Vec<String>,
    hide: Vec<String>,
    radii: String,
    radius: Option<f64>,
    radius_of: Vec<(String, f64)>,
    radius_scale: f64,
    color: Option<Color>,
    color_of: Vec<(String, Color)>,
    opacity: Option<f32>,
    opacity_of: Vec<(String, f32)>,
    material: Option<String>,
    material_of: Vec<(String, String)>,
    shine: Option<f32>,
    color_by: Option<String>,
    map: Option<MapValue>,
    range: Option<[String; 2]>,
    log: bool,
    nan_color: Option<[f32; 3]>,
    wrap: bool,
    unwrap: bool,
    copies: Option<[u32; 3]>,
    clip: Vec<[f64; 4]>,
    cell: Option<f64>,
    /// `nothing`, `molecules`, `named` or `all`, and the words of `named`.
    keep: (String, Vec<String>),
}

/// The value of a text, if there is one.
fn parsed<T: FromStr<Err = Error>>(text: Option<&String>) -> Result<Option<T>> {
    text.map(|text| text.parse()).transpose()
}

/// Rules for selected particles.
fn rules<T: Copy>(given: &[(String, T)]) -> Result<Vec<(Selection, T)>> {
    given.iter().map(|(expression, value)| Ok((expression.parse()?, *value))).collect()
}

/// An opacity.
fn opacity(opacity: f32) -> Result<f32> {
    match is_opacity(opacity) {
        true => Ok(opacity),
        false => Err(Error::settings(format!("the opacity is {opacity}"), "give a number above 0 and at most 1")),
    }
}

impl Options {
    fn coloring(&self) -> Result<Coloring> {
        let range = match &self.range {
            Some([low, high]) => Some([low.parse()?, high.parse()?]),
            None => None,
        };
        let map = self.map.as_ref().map(MapValue::map).transpose()?;
        let scale = Scale { map, range, log: self.log, nan_color: self.nan_color, ..Scale::of(Vec::new()) };
        Coloring::of(self.color.as_ref().map(Color::paint).transpose()?, self.color_by.as_deref(), scale)
    }

    /// The material with this name.
    fn material(&self, name: &str) -> Result<Material> {
        Ok(name.parse::<MaterialName>()?.material(self.shine))
    }

    /// The materials of selected particles.
    fn matters(&self) -> Result<Vec<(Selection, Material)>> {
        let plastic = |name: &str| name == MaterialName::Plastic.name();
        let mut names = self.material.iter().chain(self.material_of.iter().map(|(_, name)| name));
        if self.shine.is_some() && !names.any(|name| plastic(name)) {
            let problem = "shine belongs to plastic, and no sphere is made of it";
            return Err(Error::settings(problem, "add material=\"plastic\", or remove shine"));
        }
        if let Some(shine) = self.shine.filter(|shine| !(*shine > 0.0 && shine.is_finite())) {
            return Err(Error::settings(format!("shine is {shine}"), "give a positive number"));
        }
        self.material_of.iter().map(|(expression, name)| Ok((expression.parse()?, self.material(name)?))).collect()
    }

    fn options(&self, job: &Job) -> Result<ReadOptions> {
        let selections = |given: &[String]| given.iter().map(|text| text.parse()).collect::<Result<Vec<Selection>>>();
        Ok(ReadOptions {
            strict: self.strict,
            format: parsed::<Format>(self.format.as_ref())?,
            columns_named: parsed::<ColumnNames>(self.columns.as_ref())?.unwrap_or_default(),
            atom_style: parsed::<AtomStyle>(self.atom_style.as_ref())?,
            skip_invalid: self.skip_invalid,
            frames: parsed::<FrameRange>(self.frames.as_ref())?.unwrap_or_default(),
            hold: self.hold.parse::<Hold>()?,
            topology: self.topology.clone(),
            identity: self.identity.as_deref().map(Identity::from).unwrap_or_default(),
            model: self.model,
            altloc: self.altloc.parse::<Altloc>()?,
            assembly: self.assembly.clone(),
            as_operators: false,
            as_listed: self.as_listed,
            periodic: match (self.wrap, self.unwrap) {
                (true, true) => {
                    return Err(Error::settings("wrap and unwrap exclude each other", "remove one of them"));
                }
                (true, _) => Periodic::Wrap,
                (_, true) => Periodic::Unwrap,
                _ => Periodic::AsListed,
            },
            select: selections(&self.select)?,
            marks: Vec::new(),
            hide: selections(&self.hide)?,
            style: Style {
                radii: self.radii.parse()?,
                radius: self.radius,
                radius_scale: self.radius_scale,
                coloring: self.coloring()?,
                paints: self
                    .color_of
                    .iter()
                    .map(|(of, color)| Ok((of.parse()?, color.paint()?)))
                    .collect::<Result<_>>()?,
                sizes: rules(&self.radius_of)?,
                opacity: self.opacity.map(opacity).transpose()?,
                fades: rules(&self.opacity_of)?
                    .into_iter()
                    .map(|(of, x)| Ok((of, opacity(x)?)))
                    .collect::<Result<_>>()?,
                material: self.material.as_deref().map(|name| self.material(name)).transpose()?,
                matters: self.matters()?,
                ..Style::default()
            },
            keep: match self.keep.0.as_str() {
                "all" => Keep::All,
                "molecules" => Keep::Molecules,
                "named" => Keep::Named(self.keep.1.clone()),
                _ => Keep::Nothing,
            },
            survey: None,
            watch: job.watch(),
        })
    }

    fn arrangement(&self) -> Arrangement {
        Arrangement { copies: self.copies.unwrap_or([1; 3]), clip: self.clip.clone(), outline: self.cell.map(bead) }
    }
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
    /// `holds`: whether the frames have the camera of the first one, for an image of this size.
    #[new]
    fn new(py: Python<'_>, path: PathBuf, options: Options, size: Option<(u32, u32)>, holds: bool) -> PyResult<Self> {
        let job = Job::default();
        let read = options.options(&job).or_raise()?;
        if read.hold == Hold::All {
            let mend = "use hold='first', or give the camera, the radius and the range yourself";
            return Err(Error::settings("hold='all' is an option of the command only", mend)).or_raise();
        }
        let fixed_camera = FixedCamera::new(holds && read.hold != Hold::None);
        let sequence = job.run(py, None, || halfline_files::read::Sequence::open(&path, &read))?;
        let arrangement = options.arrangement();
        let file = path.file_name().map(|name| name.to_string_lossy().into_owned());
        Ok(Self(Mutex::new(Opened {
            sequence,
            arrangement,
            colored_by: options.color_by,
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
