//! The scene: spheres, their colours, the camera, the image. Everything geometric is f64 and taken as exact. The
//! readers of the crate `halfline-files` make scenes.

pub mod arrange;
mod ball;
pub mod camera;
mod check;
mod cut;
mod fit;
mod gradient;
pub mod instances;
mod least_size;
pub mod lidar;
mod light;
pub(crate) mod list;
mod lists;
mod material;
mod opacity;
mod orient;
mod outlook;
pub(crate) mod same;
mod source;

use camera::Camera;
use glam::DVec3;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::{entries, extend_to};

pub(crate) use ball::{Ball, NumberedBall};
pub use check::{MAX_SIDE, check_size};
pub use cut::{CUT, CutPlane, Cuts, REMOVED, SPARED};
pub(crate) use cut::{Solid, removes_all};
pub use fit::{Framing, Reach};
pub use gradient::SkyColors;
pub(crate) use gradient::{Gradient, SkyLight};
pub use halfline_ground::Cell;
pub use halfline_ground::check::{check_color, check_sphere, is_center, is_radius};
pub use light::{BOUNCES, Light, LightSource, Lighting, MOST_BOUNCES, MOST_RAYS, Sky};
pub use list::List;
pub use material::{Material, MaterialName, Materials};
pub use opacity::{check_opacity, is_opacity};
pub use orient::{Facing, NamedView, Spread};
pub use outlook::{Outlook, Surroundings};
pub use source::{SphereSource, middle};

/// Linear RGB of a sphere without a colour.
pub const DEFAULT_COLOR: [f32; 3] = [0.8, 0.8, 0.8];

/// A scene: camera, image plane, spheres and lights. World coordinates are in any unit of length.
///
/// ```
/// use halfline::{Camera, ImagePlane, Lens, Look, Scene, Spheres};
///
/// let mut spheres = Spheres::default();
/// spheres.push([0.0, 0.0, 0.0], 1.0, Some([0.9, 0.4, 0.2]));
/// let camera = Camera {
///     eye: [0.0, 1.0, 5.0].into(),
///     look: Look::At([0.0, 0.0, 0.0].into()),
///     up: [0.0, 1.0, 0.0].into(),
///     lens: Lens::Vfov { degrees: 40.0, distance: 1.0 },
/// };
/// let image = ImagePlane { width: 64, height: 48, background: [1.0; 3] };
/// let scene = Scene { camera, image, spheres, lighting: Default::default() };
/// assert!(scene.check().is_ok());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The camera.
    pub camera: Camera,
    /// The image plane.
    pub image: ImagePlane,
    /// The spheres.
    pub spheres: Spheres,
    /// Lights, sky and bounces.
    pub lighting: Lighting,
}

/// Size of the image in pixels and the colour of a ray that hits nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImagePlane {
    /// Columns, W.
    pub width: u32,
    /// Rows, H.
    pub height: u32,
    /// Linear RGB; black by default.
    pub background: [f32; 3],
}

impl Default for ImagePlane {
    /// 512 x 512 pixels on black.
    fn default() -> Self {
        Self { width: 512, height: 512, background: [0.0; 3] }
    }
}

/// The spheres in the scene's order: a sphere's id is its index here.
///
/// ```
/// use halfline::Spheres;
///
/// let mut spheres = Spheres { centers: vec![[0.0; 3], [2.0, 0.0, 0.0]].into(), radii: vec![1.0, 0.5].into(), ..Spheres::default() };
/// spheres.push([4.0, 0.0, 0.0], 0.25, None);
/// assert_eq!((spheres.len(), spheres.radii[2]), (3, 0.25));
/// spheres.share(); // clones of the scene share the numbers from here on
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Spheres {
    /// Centres in world coordinates.
    pub centers: List<[f64; 3]>,
    /// Radii, positive and finite.
    pub radii: List<f64>,
    /// Linear RGB per sphere; `None` when no sphere of the scene has a colour, so that none is uploaded.
    pub colors: Option<List<[f32; 3]>>,
    /// Materials of the spheres; `None` where all of them reflect diffusely only.
    pub materials: Option<Materials>,
    /// Opacities in pictures, above 0 and at most 1; `None` where all spheres are opaque. No other buffer depends on them.
    pub opacities: Option<List<f32>>,
    /// The planes that cut spheres; `None` where no sphere is cut. See [`Spheres::cut`].
    pub cuts: Option<Cuts>,
}

impl Spheres {
    /// The number of spheres.
    pub fn len(&self) -> usize {
        self.radii.len()
    }

    /// Whether there are no spheres.
    pub fn is_empty(&self) -> bool {
        self.radii.is_empty()
    }

    /// Remembers that the numbers of every sphere were checked, until they are changed.
    pub fn checked(self) -> Self {
        let (centers, radii) = (List::sound(self.centers.into_vec()), List::sound(self.radii.into_vec()));
        Self { centers, radii, ..self }
    }

    /// Checks the numbers of every sphere, unless that was done before ([`Spheres::checked`], [`Spheres::share`]).
    ///
    /// # Errors
    /// As [`check_sphere`] for the first that cannot be rendered.
    pub(crate) fn check(&self) -> Result<()> {
        if !(self.centers.is_sound(is_center) && self.radii.is_sound(is_radius)) {
            for (n, (center, radius)) in self.centers.iter().zip(&self.radii).enumerate() {
                check_sphere(*center, *radius, || Place::field(format!("sphere {n}")))?;
            }
        }
        self.check_opacities()
    }

    /// The corners of the box around all spheres; not finite for no spheres.
    #[must_use]
    pub fn bounds(&self) -> [DVec3; 2] {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (center, radius) in self.centers.iter().zip(&self.radii) {
            let center = DVec3::from_array(*center);
            (low, high) = (low.min(center - *radius), high.max(center + *radius));
        }
        [low, high]
    }

    /// The middle of the box around all spheres; the origin for no spheres.
    #[must_use]
    pub fn middle(&self) -> DVec3 {
        middle(self.bounds())
    }

    /// The box around all spheres, in words.
    pub fn extent(&self) -> String {
        extent(self.bounds())
    }

    /// Reserves capacity for `more` spheres, with or without colours.
    ///
    /// # Errors
    /// [`Error::Limits`] where memory is short.
    pub fn grow(&mut self, more: usize, colored: bool) -> Result<()> {
        let n = self.len();
        // The capacity of a shared list is 0: it is copied before it grows.
        let room = |capacity: usize| capacity.saturating_sub(n) >= more;
        let colored = colored || self.colors.is_some();
        let colors = self.colors.as_ref().map_or(0, List::capacity);
        if room(self.centers.capacity()) && room(self.radii.capacity()) && (!colored || colors >= n + more) {
            return Ok(());
        }
        let each = size_of::<[f64; 3]>() + size_of::<f64>() + if colored { size_of::<[f32; 3]>() } else { 0 };
        let entries = entries(n, more, each, "spheres")?;
        extend_to(self.centers.to_mut(), entries)?;
        extend_to(self.radii.to_mut(), entries)?;
        // If the first sphere has a colour, adding it makes the list.
        if self.colors.is_some() || colored && n > 0 {
            let colors = self.colors.get_or_insert_default().to_mut();
            extend_to(colors, entries)?;
            colors.resize(n, DEFAULT_COLOR);
        }
        Ok(())
    }

    /// As [`Spheres::push`], but an error where memory is short.
    ///
    /// # Errors
    /// [`Error::Limits`].
    pub fn add(&mut self, center: [f64; 3], radius: f64, color: Option<[f32; 3]>) -> Result<()> {
        self.grow(1, color.is_some())?;
        self.push(center, radius, color);
        Ok(())
    }

    /// Adds one sphere. The first colour creates the colour list; spheres without one get [`DEFAULT_COLOR`] in it.
    pub fn push(&mut self, center: [f64; 3], radius: f64, color: Option<[f32; 3]>) {
        match (&mut self.colors, color) {
            (Some(colors), color) => colors.to_mut().push(color.unwrap_or(DEFAULT_COLOR)),
            (None, Some(color)) => {
                let mut colors = vec![DEFAULT_COLOR; self.len()];
                colors.push(color);
                self.colors = Some(colors.into());
            }
            (None, None) => {}
        }
        if let Some(materials) = &mut self.materials {
            materials.push(Material::default());
        }
        if let Some(opacities) = &mut self.opacities {
            opacities.to_mut().push(1.0);
        }
        if let Some(cuts) = &mut self.cuts {
            cuts.of.to_mut().push(0);
            cuts.colors.iter_mut().for_each(|colors| colors.to_mut().push(color.unwrap_or(DEFAULT_COLOR)));
        }
        self.centers.to_mut().push(center);
        self.radii.to_mut().push(radius);
    }

    /// Changes the material of the sphere that was added last.
    pub fn set_last_material(&mut self, material: Material) {
        let (count, plain) = (self.len(), Material::default());
        if count == 0 || self.materials.is_none() && material == plain {
            return;
        }
        let materials =
            self.materials.get_or_insert_with(|| Materials { kinds: vec![plain], of: vec![0; count].into() });
        materials.of.to_mut().pop();
        materials.push(material);
    }
}

/// The box around spheres, in words.
fn extent([low, high]: [DVec3; 2]) -> String {
    format!("the spheres lie between {} and {}", point(low), point(high))
}

/// A point in words.
pub(crate) fn point(p: DVec3) -> String {
    // Decimal notation where it is short: for numbers up to the scale of the solar system, not near the limits of f64.
    let number = |x: f64| match x.abs() {
        size if size == 0.0 || (1e-9..1e16).contains(&size) => x.to_string(),
        _ => format!("{x:e}"),
    };
    format!("({}, {}, {})", number(p.x), number(p.y), number(p.z))
}

impl Scene {
    /// Checks a scene made in memory as a reader checks a file: sizes, radii, finite numbers, the camera.
    ///
    /// # Errors
    /// [`Error::Scene`] with the first field that cannot be rendered.
    pub fn check(&self) -> Result<()> {
        let s = &self.spheres;
        if s.centers.len() != s.radii.len() || s.colors.as_ref().is_some_and(|c| c.len() != s.radii.len()) {
            let problem = format!(
                "found {} centres, {} radii and {} colours",
                s.centers.len(),
                s.radii.len(),
                s.colors.as_ref().map_or(0, |colors| colors.len())
            );
            return Err(Error::scene("spheres", problem, "use lists of the same length"));
        }
        s.check()?;
        if let Some(materials) = &s.materials {
            let count = materials.kinds.len();
            if materials.of.len() != s.radii.len() || materials.of.iter().any(|kind| *kind as usize >= count) {
                let problem = format!("found materials of {} spheres", materials.of.len());
                return Err(Error::scene("spheres", problem, "give every sphere one of the materials"));
            }
            for (index, material) in materials.kinds.iter().enumerate() {
                material.check(|field| Place::field(format!("material {index} {field}")))?;
            }
        }
        if s.cuts.as_ref().is_some_and(|cuts| {
            cuts.of.len() != s.radii.len() || cuts.colors.as_ref().is_some_and(|colors| colors.len() != s.radii.len())
        }) {
            return Err(Error::scene("spheres", "some spheres have no flag of cuts", "cut them again"));
        }
        self.image.check()?;
        self.lighting.check(s.radii.len())?;
        self.camera.basis().map(drop)?;
        self.camera.check(self.image.width, self.image.height)
    }

    /// Makes this the colour of rays that hit nothing, also in place of the colours of a sky, which still lights the scene.
    pub fn set_background(&mut self, color: [f32; 3]) {
        self.image.background = color;
        if let Some(colors) = self.lighting.sky.as_mut().and_then(|sky| sky.colors.as_mut()) {
            colors.is_shown = false;
        }
    }

    /// The camera, the image and the planes of cuts alone.
    pub(crate) fn bare(&self) -> Self {
        let spheres = Spheres { cuts: self.spheres.cuts.as_ref().map(Cuts::bare), ..Spheres::default() };
        Self { camera: self.camera, image: self.image, spheres, lighting: Lighting::default() }
    }

    /// A fingerprint of everything that determines the picture: equal for equal numbers, whatever their source. 32
    /// hexadecimal digits of BLAKE3.
    pub fn fingerprint(&self) -> String {
        let mut hash = blake3::Hasher::new();
        hash.update(format!("{:?} {:?}", self.camera, self.image).as_bytes());
        if self.lighting != Lighting::default() {
            hash.update(format!("{:?}", self.lighting).as_bytes());
        }
        hash.update(self.spheres.centers.digest().as_bytes());
        hash.update(self.spheres.radii.digest().as_bytes());
        if let Some(colors) = &self.spheres.colors {
            hash.update(b"colors");
            hash.update(colors.digest().as_bytes());
        }
        if let Some(materials) = &self.spheres.materials {
            hash.update(format!("{:?}", materials.kinds).as_bytes());
            hash.update(materials.of.digest().as_bytes());
        }
        if let Some(opacities) = &self.spheres.opacities {
            hash.update(b"opacities");
            hash.update(opacities.digest().as_bytes());
        }
        if let Some(cuts) = &self.spheres.cuts {
            hash.update(format!("cuts {:?}", cuts.planes).as_bytes());
            // Without spared spheres the flags follow from planes and spheres.
            if cuts.count(SPARED) > 0 {
                hash.update(cuts.of.digest().as_bytes());
            }
            cuts.colors.iter().for_each(|colors| _ = hash.update(colors.digest().as_bytes()));
        }
        hash.finalize().to_hex()[..32].to_owned()
    }
}

impl ImagePlane {
    fn check(&self) -> Result<()> {
        check_size([i64::from(self.width), i64::from(self.height)], || Place::field("image.size")).map(drop)?;
        check_color(self.background, || Place::field("image.background"))
    }
}
