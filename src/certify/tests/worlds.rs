//! Hard scenes: families of spheres and cameras, most of them placed so that a pixel's ray almost touches a sphere.

mod parallel;
mod perspective;

use super::claims::Exact;
use crate::double_double as dd;
use crate::scene::camera::{Camera, Lens, Look};
use crate::scene::{ImagePlane, Scene, Spheres};
use crate::testing::Rng;
use glam::DVec3;

/// A scene and the pixels to test, first those whose rays graze.
pub(super) struct World {
    pub(super) scene: Scene,
    pub(super) pixels: Vec<[u32; 2]>,
}

pub(super) type Make = fn(&mut Rng) -> World;

/// The families, by name.
pub(super) const FAMILIES: [(&str, Make); 22] = [
    ("generic", perspective::generic),
    ("grazed", perspective::grazed),
    ("wide lens", perspective::wide),
    ("long lens", perspective::long),
    ("planet", perspective::planet),
    ("inside", perspective::inside),
    ("straddling", perspective::straddling),
    ("cluster", perspective::cluster),
    ("sub-pixel", perspective::sub_pixel),
    ("scales", perspective::scales),
    ("corner", perspective::corner),
    ("anisotropic", perspective::anisotropic),
    ("surface", perspective::surface),
    ("big image", perspective::big_image),
    ("off axis near", perspective::off_axis_near),
    ("parallel", parallel::parallel),
    ("parallel crossing", parallel::parallel_crossing),
    ("parallel distant", parallel::parallel_distant),
    ("parallel sub-pixel", parallel::parallel_sub_pixel),
    ("parallel scales", parallel::parallel_scales),
    ("rolled", rolled),
    ("ends of f64", ends),
];

/// A scene with its camera's axes: positions are given as right, up, ahead.
pub(super) struct Site {
    pub(super) scene: Scene,
    axes: [DVec3; 3],
}

impl Site {
    pub(super) fn new(camera: Camera, [width, height]: [u32; 2]) -> Self {
        let basis = camera.basis().expect("a basis");
        let image = ImagePlane { width, height, ..ImagePlane::default() };
        let scene = Scene { camera, image, spheres: Spheres::default(), lighting: Default::default() };
        Self { scene, axes: [basis.u, basis.v, -basis.w] }
    }

    /// A random eye and view, with a viewport of `half` times twice its distance.
    fn random(rng: &mut Rng, half: [f64; 2], size: [u32; 2], unit: f64) -> Self {
        let mut vector = || DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0));
        let (eye, view, up) = (vector() * 3.0 * unit, vector(), vector());
        let distance = rng.decade(-1.0, 1.0);
        let [vw, vh] = half.map(|h| 2.0 * h * distance);
        let lens = Lens::Viewport { vw, vh, distance };
        Self::new(Camera { eye, look: Look::View(view), up, lens }, size)
    }

    pub(super) fn place(&self, [right, up, ahead]: [f64; 3]) -> [f64; 3] {
        let [u, v, w] = self.axes;
        (self.scene.camera.eye + u * right + v * up + w * ahead).to_array()
    }

    /// Slopes of a pixel's ray.
    pub(super) fn slopes(&self, pixel: [u32; 2]) -> [f64; 2] {
        let ray = Exact::of(&self.scene, pixel, [0.0; 3], 1.0);
        [ray.x.value(), ray.y.value()]
    }

    fn pixel(&self, rng: &mut Rng) -> [u32; 2] {
        [rng.below(self.scene.image.height), rng.below(self.scene.image.width)]
    }

    fn push(&mut self, at: [f64; 3], radius: f64) {
        let center = self.place(at);
        self.scene.spheres.push(center, radius, None);
    }

    /// A sphere of about that radius whose silhouette the pixel's ray just misses or hits: D = 2 delta a r^2.
    pub(super) fn aim(&mut self, rng: &mut Rng, pixel: [u32; 2], at: [f64; 3]) {
        let delta = rng.sign() * 2f64.powf(rng.between(-28.0, -15.0));
        self.aim_by(delta, pixel, at);
    }

    fn aim_by(&mut self, delta: f64, pixel: [u32; 2], at: [f64; 3]) {
        let center = self.place(at);
        let passes = Exact::of(&self.scene, pixel, center, 1.0).passes();
        if passes > 0.0 {
            self.scene.spheres.push(center, passes * (1.0 + delta), None);
        }
    }

    /// The point of a ray at that depth: right, up, ahead.
    pub(super) fn on_ray(&self, pixel: [u32; 2], depth: f64) -> [f64; 3] {
        // From the eye to the origin of the ray.
        let ray = Exact::of(&self.scene, pixel, self.scene.camera.eye.to_array(), 1.0);
        let [right, up, _] = ray.p.map(|x| x.value());
        [ray.x.value() * depth - right, ray.y.value() * depth - up, depth]
    }

    /// The same point, moved sideways by about `by`.
    fn near_ray(&self, rng: &mut Rng, pixel: [u32; 2], depth: f64, by: f64) -> [f64; 3] {
        let [x, y, _] = self.on_ray(pixel, depth);
        let turn = rng.between(0.0, std::f64::consts::TAU);
        [x + by * turn.cos(), y + by * turn.sin(), depth]
    }

    fn done(self, rng: &mut Rng, mut pixels: Vec<[u32; 2]>) -> World {
        for _ in 0..3 {
            pixels.push(self.pixel(rng));
        }
        World { scene: self.scene, pixels }
    }
}

fn size(rng: &mut Rng) -> [u32; 2] {
    let mut side = || match rng.below(6) {
        0 => 1 + rng.below(9),
        1 => 64,
        2 => 1023,
        3 => 1024,
        4 => 1920,
        _ => 2 + rng.below(200),
    };
    [side(), side()]
}

/// Half a viewport at distance 1: `half` for the height, shaped by the image.
fn shaped(half: f64, [width, height]: [u32; 2]) -> [f64; 2] {
    [half * f64::from(width) / f64::from(height), half]
}

/// Spheres aimed at pixels of any site: depth by decades, radius by its size in the image.
fn aimed(rng: &mut Rng, mut site: Site, depths: [f64; 2], first: &[[u32; 2]]) -> World {
    let lens = site.scene.camera.viewport(1, 1).expect("a viewport");
    let half = (lens.vw / lens.d).min(lens.vh / lens.d).min(0.5);
    let mut pixels = first.to_vec();
    for _ in 0..1 + rng.below(4) {
        let pixel = site.pixel(rng);
        let depth = rng.decade(depths[0], depths[1]);
        let radius = depth * half * rng.decade(-4.0, 0.0);
        let at = site.near_ray(rng, pixel, depth, radius);
        site.aim(rng, pixel, at);
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

fn scaled(scene: &mut Scene, scale: f64) {
    scene.camera.eye *= scale;
    for center in scene.spheres.centers.to_mut() {
        *center = center.map(|x| x * scale);
    }
    for radius in scene.spheres.radii.to_mut() {
        *radius *= scale;
    }
}

/// `up` almost along the view, the eye so near the origin compared with `at` that their difference has more than 100
/// bits, and a lens that makes a rotation of the image by 1e-17 rad visible. `at` is exactly on the axis.
fn rolled(rng: &mut Rng) -> World {
    let mut vector = |s: f64| DVec3::new(rng.between(-s, s), rng.between(-s, s), rng.between(-s, s));
    let (at, eye, side) = (vector(1.0), vector(1.0), vector(1.0));
    let extent = rng.decade(-17.0, -14.0);
    let up = at + side * rng.decade(-14.3, -6.0);
    let lens = match rng.below(2) {
        0 => Lens::Viewport { vw: extent, vh: extent, distance: 1.0 },
        _ => Lens::Orthographic { height: extent },
    };
    let camera = Camera { eye: eye * extent, look: Look::At(at), up, lens };
    // After a rotation almost about the view, `up` may be parallel to it.
    let camera = if camera.basis().is_ok() { camera } else { Camera { up: DVec3::new(at.z, at.x, at.y), ..camera } };
    let mut site = Site::new(camera, [2 + rng.below(40), 2 + rng.below(40)]);
    let mut pixels = Vec::new();
    for k in 0..1 + rng.below(2) {
        let pixel = site.pixel(rng);
        let center = (at * f64::from(1 << k)).to_array();
        let passes = Exact::of(&site.scene, pixel, center, 1.0).passes();
        let delta = rng.sign() * 2f64.powf(rng.between(-22.0, -3.0));
        site.scene.spheres.push(center, passes * (1.0 + delta), None);
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

/// A scene of any family, scaled to where squares overflow or to subnormal numbers.
fn ends(rng: &mut Rng) -> World {
    let place = if rng.below(2) == 0 { rng.below(9) } else { 15 + rng.below(4) };
    let World { mut scene, pixels } = FAMILIES[place as usize].1(rng);
    let exponents = |scene: &Scene| {
        let sizes = scene.spheres.centers.iter().flatten().chain(&scene.spheres.radii);
        let largest = sizes.fold(0.0f64, |most, x| most.max(x.abs()));
        let height = match scene.camera.lens {
            Lens::Orthographic { height } => height,
            _ => largest,
        };
        [scene.spheres.radii.iter().fold(height, |least, r| least.min(*r)), largest.max(height)].map(dd::exponent)
    };
    let [least, most] = exponents(&scene);
    // The smallest length keeps a few bits, and differences of the largest numbers do not overflow.
    let k = if rng.below(2) == 0 { -1070 + rng.below(40) as i32 - least } else { 990 - rng.below(300) as i32 - most };
    let scale = |x: &mut f64| *x = dd::ldexp(*x, k);
    if let Lens::Orthographic { height } = &mut scene.camera.lens {
        scale(height);
    }
    let mut eye = scene.camera.eye.to_array();
    eye.iter_mut().chain(scene.spheres.centers.to_mut().iter_mut().flatten()).for_each(scale);
    scene.spheres.radii.to_mut().iter_mut().for_each(scale);
    scene.camera.eye = eye.into();
    World { scene, pixels }
}
