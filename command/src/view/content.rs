//! The content of a page: scenes with their options, as bytes; a page has a copy of them.

mod numbers;

use super::given::WrittenOption;
use halfline::camera::Camera;
use halfline::error::{Error, Result};
use halfline::frame::legend::Legend;
use halfline::scene::{Cell, ImagePlane, Light, Lighting, Material, Materials, Scene, Sky, SkyColors, Spheres};
use halfline::settings::FileLook;
use halfline_files::read::{Codes, ColumnValues, Columns, Focus, FrameTime, SceneFrame};
use halfline_viewer::Pose;
use numbers::{Lists, Packed, Table};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::sync::Arc;

/// The form of the bytes.
const SCHEMA: u32 = 1;

/// The columns that say what an atom is, by the words of selections: some kilobytes for a molecule.
const USUAL: [&str; 6] = ["file", "chain", "resname", "resid", "name", "element"];

/// The options whose values name columns.
const NAMING: [&str; 11] =
    ["color_by", "mark", "mark_one", "select", "hide", "color", "opacity", "radius", "material", "focus", "move"];

/// Scenes in memory that a page shows, with the options of every picture.
#[derive(Debug, Clone)]
pub struct Content {
    /// The frames, at least one, in their order; the page begins with the first. Their cameras and apertures are not used.
    pub frames: Vec<SceneFrame>,
    /// The cell whose edges the option `outline` draws.
    pub edges: Option<Cell>,
    /// The name of the file, or another one.
    pub name: String,
    /// The file that copied lines read, if they can read it again.
    pub source: Option<OsString>,
    /// The options of every picture.
    pub rendering: Vec<WrittenOption>,
    /// The options in copied lines: also those that read the file, and those that choose the renderer.
    pub copied: Vec<WrittenOption>,
    /// The camera with which the page begins.
    pub camera: Pose,
    /// Width and height of the picture with which it begins.
    pub size: [u32; 2],
    /// Whether pictures keep this size whatever the page's is.
    pub is_sized: bool,
    /// Whether the camera shows all spheres for this size, so that it does for another one too.
    pub is_framed: bool,
    /// The words around the picture.
    pub text: PageText,
}

/// The words of a page around its picture.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct PageText {
    /// The title; without it, the name of the file.
    pub title: Option<String>,
    /// The lines below the picture.
    pub caption: Option<String>,
}

#[derive(Serialize, Deserialize)]
struct Head {
    schema: u32,
    name: String,
    source: Option<String>,
    rendering: Vec<(String, Option<String>)>,
    copied: Vec<(String, Option<String>)>,
    camera: Pose,
    size: [u32; 2],
    is_sized: bool,
    is_framed: bool,
    text: PageText,
    edges: Option<Cell>,
    frames: Vec<Frame>,
    lists: Table,
}

#[derive(Serialize, Deserialize)]
struct Frame {
    number: u64,
    size: [u32; 2],
    background: [f32; 3],
    lights: Vec<Light>,
    shadows: bool,
    sky: Option<SkyOfFrame>,
    bounces: Option<u32>,
    /// Kinds of what the reader left out are counted in its sentences.
    notes: Vec<String>,
    is_particles: bool,
    look: Option<String>,
    samples: Option<u32>,
    legend: Option<Legend>,
    cell: Option<Cell>,
    time: Option<f64>,
    step: Option<i64>,
    is_molecule: bool,
    beads: u64,
    marks: Vec<(String, Balls, Vec<String>)>,
    spheres: Balls,
    columns: Vec<(String, Column)>,
}

#[derive(Serialize, Deserialize)]
struct SkyOfFrame {
    rays: u32,
    reach: f64,
    at_centers: bool,
    colors: Option<([f32; 3], [f32; 3], bool)>,
    share: f32,
}

/// Spheres, by the numbers of their lists.
#[derive(Serialize, Deserialize)]
struct Balls {
    count: u64,
    centers: [u32; 3],
    radii: u32,
    colors: Option<[u32; 3]>,
    materials: Option<(Vec<Material>, u32)>,
    opacities: Option<u32>,
}

#[derive(Serialize, Deserialize)]
enum Column {
    Numbers(u32),
    Whole(u32),
    Order,
    Texts(u32, Vec<String>),
}

impl Content {
    /// Keeps the columns with these names, those that say what an atom is or that an option names, and the number in the file.
    ///
    /// # Errors
    /// [`Error::Settings`] for a name without a column.
    pub fn keep(&mut self, names: &[String]) -> Result<()> {
        let options = self.copied.iter().chain(&self.rendering).filter(|(id, _)| NAMING.contains(&&id[..]));
        let values = options.filter_map(|(_, value)| value.as_ref()?.to_str());
        let words: BTreeSet<&str> =
            values.flat_map(|value| value.split(|c: char| !(c.is_alphanumeric() || c == '_'))).chain(USUAL).collect();
        for frame in &mut self.frames {
            let mut kept = vec!["index"];
            kept.extend(words.iter().filter_map(|word| Some(frame.columns.get(word).ok()?.0)));
            for name in names {
                kept.push(frame.columns.get(name)?.0);
            }
            let list = frame.columns.iter().filter(|(name, _)| kept.contains(name));
            let list = list.map(|(name, values)| (name.to_owned(), values.clone())).collect();
            frame.columns = Arc::new(Columns::from_list(list));
        }
        Ok(())
    }

    /// The bytes: the length of the head, the head as CBOR, the numbers of all lists.
    ///
    /// # Errors
    /// [`Error::Settings`] for an option that is no text.
    pub fn pack(&self) -> Result<Vec<u8>> {
        let mut lists = Packed::default();
        let frames = self.frames.iter().map(|frame| Frame::of(frame, &mut lists)).collect();
        let (table, numbers) = lists.into_parts();
        let head = Head {
            schema: SCHEMA,
            name: self.name.clone(),
            source: self.source.as_deref().map(|file| text("the file's name", file)).transpose()?,
            rendering: texts(&self.rendering)?,
            copied: texts(&self.copied)?,
            camera: self.camera,
            size: self.size,
            is_sized: self.is_sized,
            is_framed: self.is_framed,
            text: self.text.clone(),
            edges: self.edges,
            frames,
            lists: table,
        };
        let mut bytes = Vec::new();
        ciborium::into_writer(&head, &mut bytes)
            .map_err(|e| Error::settings(format!("the page cannot be packed: {e}"), "report this as a bug"))?;
        Ok([&(bytes.len() as u64).to_le_bytes()[..], &bytes, &numbers].concat())
    }

    /// The content of such bytes; `None` for others.
    #[must_use]
    pub fn unpack(bytes: &[u8]) -> Option<Self> {
        let (length, rest) = bytes.split_first_chunk::<8>()?;
        let (head, numbers) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
        let head: Head = ciborium::from_reader(head).ok().filter(|head: &Head| head.schema == SCHEMA)?;
        let lists = head.lists.lists(numbers)?;
        let frames = head.frames.into_iter().map(|frame| frame.into_scene(&lists)).collect::<Option<Vec<_>>>()?;
        let options = |all: Vec<(String, Option<String>)>| -> Vec<WrittenOption> {
            all.into_iter().map(|(id, value)| (id, value.map(OsString::from))).collect()
        };
        (!frames.is_empty()).then_some(Self {
            frames,
            edges: head.edges,
            name: head.name,
            source: head.source.map(OsString::from),
            rendering: options(head.rendering),
            copied: options(head.copied),
            camera: head.camera,
            size: head.size,
            is_sized: head.is_sized,
            is_framed: head.is_framed,
            text: head.text,
        })
    }
}

/// A name or a value as text.
fn text(what: &str, value: &OsStr) -> Result<String> {
    let text = value.to_str().map(str::to_owned);
    text.ok_or_else(|| Error::settings(format!("{what} is not UTF-8, and a page cannot have it"), "use another one"))
}

/// Options as texts.
fn texts(options: &[WrittenOption]) -> Result<Vec<(String, Option<String>)>> {
    let one = |(id, value): &WrittenOption| {
        let value = value.as_deref().map(|value| text(&format!("the value of {}", id), value)).transpose()?;
        Ok((id.clone(), value))
    };
    options.iter().map(one).collect()
}

impl Frame {
    fn of(frame: &SceneFrame, lists: &mut Packed) -> Self {
        let Scene { image, lighting, spheres, .. } = &frame.scene;
        let mut notes = Vec::new();
        frame.skipped.report(&mut 0, &mut notes, 0);
        let sky = lighting.sky.map(|Sky { rays, reach, at_centers, colors, share }| SkyOfFrame {
            rays,
            reach,
            at_centers,
            colors: colors.map(|SkyColors { zenith, horizon, is_shown }| (zenith, horizon, is_shown)),
            share,
        });
        let mark =
            |mark: &Focus, lists: &mut Packed| (mark.text.clone(), Balls::of(&mark.spheres, lists), mark.notes.clone());
        Self {
            number: frame.number,
            size: [image.width, image.height],
            background: image.background,
            lights: lighting.lights.clone(),
            shadows: lighting.shadows,
            sky,
            bounces: lighting.bounces,
            notes,
            is_particles: frame.look.is_particles,
            look: frame.look.look.map(|look| look.name().to_owned()),
            samples: frame.look.samples,
            legend: frame.legend.clone(),
            cell: frame.cell,
            time: frame.when.time,
            step: frame.when.step,
            is_molecule: frame.is_molecule,
            beads: frame.beads as u64,
            marks: frame.marks.iter().map(|one| mark(one, lists)).collect(),
            spheres: Balls::of(spheres, lists),
            columns: frame.columns.iter().map(|(name, values)| (name.to_owned(), Column::of(values, lists))).collect(),
        }
    }

    fn into_scene(self, lists: &Lists<'_>) -> Option<SceneFrame> {
        let [width, height] = self.size;
        let sky = self.sky.map(|SkyOfFrame { rays, reach, at_centers, colors, share }| Sky {
            rays,
            reach,
            at_centers,
            colors: colors.map(|(zenith, horizon, is_shown)| SkyColors { zenith, horizon, is_shown }),
            share,
        });
        let scene = Scene {
            camera: Camera::CANONICAL,
            image: ImagePlane { width, height, background: self.background },
            spheres: self.spheres.into_spheres(lists)?,
            lighting: Lighting { lights: self.lights, shadows: self.shadows, sky, bounces: self.bounces },
        };
        scene.check().ok()?;
        let count = scene.spheres.len();
        let look = self.look.map(|name| name.parse()).transpose().ok()?;
        let columns = self.columns.into_iter().map(|(name, column)| Some((name, column.into_values(count, lists)?)));
        let marks = self
            .marks
            .into_iter()
            .map(|(text, spheres, notes)| Some(Focus { text, spheres: spheres.into_spheres(lists)?, notes }));
        let mut frame = SceneFrame {
            look: FileLook { is_particles: self.is_particles, look, samples: self.samples },
            legend: self.legend,
            cell: self.cell,
            when: FrameTime { time: self.time, step: self.step },
            is_molecule: self.is_molecule,
            beads: usize::try_from(self.beads).ok().filter(|beads| *beads <= count)?,
            columns: Arc::new(Columns::from_list(columns.collect::<Option<_>>()?)),
            marks: marks.collect::<Option<_>>()?,
            ..SceneFrame::new(self.number, scene)
        };
        frame.skipped.assumed = self.notes;
        frame.scene.spheres.share();
        Some(frame)
    }
}

/// One coordinate of triples.
fn along<T: Into<f64> + Copy>(triples: &[[T; 3]], k: usize) -> Vec<f64> {
    triples.iter().map(|triple| triple[k].into()).collect()
}

impl Balls {
    fn of(spheres: &Spheres, lists: &mut Packed) -> Self {
        let centers = [0, 1, 2].map(|k| lists.add(&along(&spheres.centers, k)));
        let colors = spheres.colors.as_ref().map(|colors| [0, 1, 2].map(|k| lists.add(&along(colors, k))));
        let materials = spheres.materials.as_ref().map(|Materials { kinds, of }| {
            (kinds.clone(), lists.add(&of.iter().map(|n| f64::from(*n)).collect::<Vec<_>>()))
        });
        let opacities = spheres.opacities.as_ref();
        let opacities = opacities.map(|all| lists.add(&all.iter().map(|x| f64::from(*x)).collect::<Vec<_>>()));
        Self { count: spheres.len() as u64, centers, radii: lists.add(&spheres.radii), colors, materials, opacities }
    }

    fn into_spheres(self, lists: &Lists<'_>) -> Option<Spheres> {
        let count = usize::try_from(self.count).ok()?;
        let triples = |numbers: [u32; 3]| {
            let [x, y, z] = numbers.map(|number| lists.get(number, count));
            let (x, y, z) = (x?, y?, z?);
            Some((0..count).map(move |n| [x[n], y[n], z[n]]))
        };
        let colors = match self.colors {
            Some(colors) => Some(triples(colors)?.map(|color| color.map(|x| x as f32)).collect::<Vec<_>>().into()),
            None => None,
        };
        let materials = match self.materials {
            // Which kinds there are is checked with the scene.
            Some((kinds, of)) => {
                let of: Vec<u32> = lists.get(of, count)?.into_iter().map(|n| n as u32).collect();
                Some(Materials { kinds, of: of.into() })
            }
            None => None,
        };
        let opacities = match self.opacities {
            Some(all) => Some(lists.get(all, count)?.into_iter().map(|x| x as f32).collect::<Vec<_>>().into()),
            None => None,
        };
        let centers = triples(self.centers)?.collect::<Vec<_>>().into();
        Some(Spheres { centers, radii: lists.get(self.radii, count)?.into(), colors, materials, opacities, cuts: None })
    }
}

impl Column {
    fn of(values: &ColumnValues, lists: &mut Packed) -> Self {
        let whole =
            |numbers: &mut dyn Iterator<Item = f64>, lists: &mut Packed| lists.add(&numbers.collect::<Vec<_>>());
        match values {
            ColumnValues::Numbers(numbers) => Self::Numbers(lists.add(numbers)),
            ColumnValues::Whole(numbers) => Self::Whole(whole(&mut numbers.iter().map(|n| f64::from(*n)), lists)),
            ColumnValues::Order(_) => Self::Order,
            ColumnValues::Texts(codes, texts) => {
                let list = match codes {
                    Codes::U8(codes) => whole(&mut codes.iter().map(|n| f64::from(*n)), lists),
                    Codes::U16(codes) => whole(&mut codes.iter().map(|n| f64::from(*n)), lists),
                    Codes::U32(codes) => whole(&mut codes.iter().map(|n| f64::from(*n)), lists),
                };
                Self::Texts(list, texts.clone())
            }
        }
    }

    fn into_values(self, count: usize, lists: &Lists<'_>) -> Option<ColumnValues> {
        Some(match self {
            Self::Numbers(list) => ColumnValues::Numbers(lists.get(list, count)?),
            Self::Whole(list) => ColumnValues::Whole(lists.get(list, count)?.into_iter().map(|x| x as i32).collect()),
            Self::Order => ColumnValues::Order(count),
            Self::Texts(list, texts) => {
                let codes: Vec<u32> = lists.get(list, count)?.into_iter().map(|x| x as u32).collect();
                codes.iter().all(|code| (*code as usize) < texts.len()).then_some(())?;
                ColumnValues::Texts(Codes::U32(codes), texts)
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline::frame::color_map::ColorMap;
    use halfline::frame::legend::Category;
    use halfline::scene::LightSource;
    use halfline::settings::Look;
    use halfline_viewer::Lens;

    fn content() -> Content {
        let centers: Vec<[f64; 3]> =
            (0..50).map(|n| [f64::from(n) * 0.1, f64::from(n * n) * 1e-7, 1.0 / f64::from(n + 1)]).collect();
        let spheres = Spheres {
            centers: centers.into(),
            radii: (0..50).map(|n| 0.5 + f64::from(n)).collect::<Vec<_>>().into(),
            colors: Some((0..50).map(|n| [0.1, n as f32 / 50.0, 1.0]).collect::<Vec<_>>().into()),
            materials: Some(Materials {
                kinds: vec![Material::default(), Material::default()],
                of: (0..50).map(|n| n % 2).collect::<Vec<_>>().into(),
            }),
            opacities: Some((0..50).map(|n| (n + 1) as f32 / 50.0).collect::<Vec<_>>().into()),
            cuts: None,
        };
        let light =
            Light { source: LightSource::Direction([1.0, 2.0, 0.1].into()), color: [1.0, 0.5, 0.25], intensity: 0.3 };
        let sky = Sky { rays: 7, reach: f64::INFINITY, at_centers: true, colors: None, share: 0.5 };
        let lighting = Lighting { lights: vec![light], shadows: true, sky: Some(sky), bounces: Some(3) };
        let image = ImagePlane { width: 30, height: 20, background: [0.1, 0.2, 0.3] };
        let scene = Scene { camera: Camera::CANONICAL, image, spheres: spheres.clone(), lighting };
        let columns = vec![
            (
                "b".to_owned(),
                ColumnValues::Numbers((0..50).map(|n| if n == 3 { f64::NAN } else { f64::from(n) }).collect()),
            ),
            ("residue".to_owned(), ColumnValues::Whole((0..50).collect())),
            (
                "chain".to_owned(),
                ColumnValues::Texts(
                    Codes::U32((0..50).map(|n| n % 3).collect()),
                    ["A", "<b>", "é"].map(String::from).to_vec(),
                ),
            ),
            ("index".to_owned(), ColumnValues::Order(50)),
        ];
        let category = Category { label: "A".into(), color: [1, 2, 3], count: 9 };
        let legend = Legend {
            name: "chain".into(),
            title: None,
            map: ColorMap::Category,
            range: [0.0, f64::NAN],
            log: false,
            categories: vec![category],
            names: vec!["A".into()],
            overrides: Vec::new(),
        };
        let mut frame = SceneFrame {
            look: FileLook { is_particles: true, look: Some(Look::Figure), samples: Some(9) },
            legend: Some(legend),
            cell: Some(Cell { origin: [0.0; 3], edges: [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.5, 0.0, 3.0]] }),
            when: FrameTime { time: Some(2.5), step: Some(-3) },
            is_molecule: true,
            beads: 2,
            columns: Arc::new(Columns::from_list(columns)),
            marks: vec![Focus {
                text: "id = 1".into(),
                spheres: spheres.part(&(0..50).map(|n| n == 1).collect::<Vec<_>>()),
                notes: vec!["a note".into()],
            }],
            ..SceneFrame::new(7, scene)
        };
        let next = SceneFrame { number: 8, ..frame.copy() };
        Content {
            edges: frame.cell,
            frames: vec![frame, next],
            name: "a.cif".into(),
            source: Some("a.cif".into()),
            rendering: vec![("look".into(), Some("plain".into())), ("transparent".into(), None)],
            copied: Vec::new(),
            camera: Pose { eye: [1.0, 2.0, 3.0], at: [0.0; 3], up: [0.0, 1.0, 0.0], lens: Lens::Vfov(30.0) },
            size: [30, 20],
            is_sized: true,
            is_framed: true,
            text: PageText { title: Some("a title".into()), caption: None },
        }
    }

    /// All of a content as text; NaN has one spelling.
    fn shown(content: &Content) -> String {
        format!("{content:?}").replace("U8(", "U32(")
    }

    #[test]
    fn a_content_survives_packing() {
        let mut whole = content();
        let bytes = whole.pack().expect("packed");
        let again = Content::unpack(&bytes).expect("a content");
        assert_eq!(shown(&again), shown(&whole));
        let one = Content { frames: vec![whole.frames[0].copy()], ..whole };
        let alone = one.pack().expect("packed");
        assert!(
            bytes.len() < alone.len() + 1200,
            "what frames share is kept once: {} and {} bytes",
            bytes.len(),
            alone.len()
        );
    }

    #[test]
    fn numbers_beyond_a_table_are_refused() {
        let mut texts = content();
        let codes = ColumnValues::Texts(Codes::U8(vec![2; 50]), vec!["A".into(), "B".into()]);
        texts.frames[0].columns = Arc::new(Columns::from_list(vec![("chain".into(), codes)]));
        let mut kinds = content();
        kinds.frames[0].scene.spheres.materials.as_mut().expect("materials").kinds.pop();
        for wrong in [texts, kinds] {
            assert!(Content::unpack(&wrong.pack().expect("packed")).is_none());
        }
    }

    #[test]
    fn a_damaged_content_is_refused() {
        let bytes = content().pack().expect("packed");
        let length = u64::from_le_bytes(*bytes.first_chunk().expect("a length")) as usize;
        for cut in [0, 7, 8, 100, length, length + 8, bytes.len() - 1] {
            assert!(Content::unpack(&bytes[..cut]).is_none(), "{cut} bytes");
        }
        // Any byte of the head: refused, or other values, and never a panic.
        for place in 0..length + 8 {
            for change in [1, 0x20, 0x80, 0xff] {
                let mut bytes = bytes.clone();
                bytes[place] ^= change;
                let _ = Content::unpack(&bytes);
            }
        }
    }
}
