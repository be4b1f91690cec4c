//! Hard scenes: families of spheres and cameras, most of them placed so that a pixel's ray nearly grazes a sphere.

use super::claims::Exact;
use crate::camera::{Camera, Lens, Look};
use crate::dd;
use crate::scene::{ImagePlane, Scene, Skipped, Spheres};
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
    ("generic", generic),
    ("grazed", grazed),
    ("wide lens", wide),
    ("long lens", long),
    ("planet", planet),
    ("inside", inside),
    ("straddling", straddling),
    ("cluster", cluster),
    ("sub-pixel", sub_pixel),
    ("scales", scales),
    ("corner", corner),
    ("anisotropic", anisotropic),
    ("surface", surface),
    ("big image", big_image),
    ("off axis near", beside),
    ("parallel", parallel),
    ("parallel crossing", parallel_crossing),
    ("parallel distant", parallel_distant),
    ("parallel sub-pixel", parallel_sub_pixel),
    ("parallel scales", parallel_scales),
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
        let scene = Scene { camera, image, spheres: Spheres::default(), skipped: Skipped::default() };
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

    /// A sphere of about that radius whose silhouette the pixel's ray just misses or meets: D = 2 delta a r^2.
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

    /// Where a ray passes at that depth: right, up, ahead.
    pub(super) fn on_ray(&self, pixel: [u32; 2], depth: f64) -> [f64; 3] {
        // Of the eye itself, from where the ray begins.
        let ray = Exact::of(&self.scene, pixel, self.scene.camera.eye.to_array(), 1.0);
        let [right, up, _] = ray.p.map(|x| x.value());
        [ray.x.value() * depth - right, ray.y.value() * depth - up, depth]
    }

    /// The same, moved sideways by about `by`.
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

/// One sphere from 1.01 to 1e8 radii away, the lens narrowed to it.
fn generic(rng: &mut Rng) -> World {
    let size = size(rng);
    let depth = rng.decade(0.005, 8.0);
    let half = (rng.between(0.3, 3.0) / depth).min(2.0);
    let mut site = Site::random(rng, shaped(half, size).map(|h| h.min(20.0)), size, depth);
    let by = rng.between(0.0, half * depth);
    let pixel = site.pixel(rng);
    let at = site.near_ray(rng, pixel, depth, by);
    site.push(at, 1.0);
    site.done(rng, vec![pixel])
}

/// The same by one to four spheres, grazed.
fn grazed(rng: &mut Rng) -> World {
    let size = size(rng);
    let site = Site::random(rng, shaped(rng.clone().decade(-3.0, 0.5), size).map(|h| h.min(20.0)), size, 1.0);
    aimed(rng, site, [0.3, 6.0], &[])
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

/// 100 to 176 degrees.
fn wide(rng: &mut Rng) -> World {
    let size = size(rng);
    let half = rng.between(100f64, 176.0).to_radians() / 2.0;
    let site = Site::random(rng, [half.tan(), half.tan()].map(|h| h * 0.78), size, 1.0);
    aimed(rng, site, [0.1, 4.0], &[])
}

/// Down to a micro-radian and a billion units away.
fn long(rng: &mut Rng) -> World {
    let size = size(rng);
    let half = rng.decade(-10.0, -3.0);
    let site = Site::random(rng, shaped(half, size), size, 1.0);
    aimed(rng, site, [2.0, 9.0], &[])
}

/// A planet seen from 1.7 m to 100 km, its horizon, and pebbles below the eye.
fn planet(rng: &mut Rng) -> World {
    let r = 6.4e6;
    let h = rng.decade(0.2, 5.0);
    let lens = Lens::Vfov { degrees: rng.between(5.0, 100.0), distance: 1.0 };
    let tilt = rng.between(0.0, 2.5) * (2.0 * h / r).sqrt();
    let look = Look::View(DVec3::new(rng.between(-1.0, 1.0), -tilt, rng.between(-1.0, 1.0)));
    let size = size(rng);
    let mut site = Site::new(Camera { eye: DVec3::new(0.0, h, 0.0), look, up: DVec3::Y, lens }, size);
    let center = [0.0, -r, 0.0];
    let pixel = site.pixel(rng);
    let passes = Exact::of(&site.scene, pixel, center, 1.0).passes();
    // The horizon through a pixel, where that leaves the eye outside.
    let aimed = passes * (1.0 + rng.sign() * 2f64.powf(rng.between(-40.0, -18.0)));
    site.scene.spheres.push(center, if aimed < r + 0.99 * h { aimed } else { r }, None);
    for _ in 0..rng.below(4) {
        let depth = h * rng.decade(-0.5, 1.5);
        let pixel = site.pixel(rng);
        let at = site.near_ray(rng, pixel, depth, 0.03 * depth);
        site.aim(rng, pixel, at);
    }
    site.done(rng, vec![pixel])
}

/// The eye inside spheres, deep and close to the surface; shells; a sphere between eye and surface.
fn inside(rng: &mut Rng) -> World {
    let size = size(rng);
    let mut site = Site::random(rng, shaped(rng.clone().decade(-4.0, 0.7), size).map(|h| h.min(25.0)), size, 1.0);
    for _ in 0..1 + rng.below(3) {
        let r = rng.decade(-2.0, 4.0);
        let deep = 1.0 - rng.decade(-9.0, 0.0);
        let way = DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0));
        site.push((way.normalize() * r * deep).to_array(), r);
        if rng.below(2) == 0 {
            let last = site.scene.spheres.centers.len() - 1;
            let center = site.scene.spheres.centers[last];
            site.scene.spheres.push(center, r * (1.0 + rng.decade(-9.0, -2.0)), None);
        }
    }
    let pixel = site.pixel(rng);
    site.done(rng, vec![pixel])
}

/// Across the eye plane, or large and close.
fn straddling(rng: &mut Rng) -> World {
    let size = size(rng);
    let mut site = Site::random(rng, shaped(rng.clone().decade(-2.0, 0.9), size).map(|h| h.min(30.0)), size, 1.0);
    let mut pixels = Vec::new();
    for _ in 0..1 + rng.below(3) {
        let pixel = site.pixel(rng);
        let depth = rng.between(-0.5, 1.2);
        let by = rng.decade(-1.0, 1.5);
        let at = site.near_ray(rng, pixel, depth, by);
        site.aim(rng, pixel, at);
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

/// Far away and at nearly equal depths, which makes the order hard.
fn cluster(rng: &mut Rng) -> World {
    let size = size(rng);
    let depth = rng.decade(0.7, 8.0);
    let mut site = Site::random(rng, shaped(0.7 / depth, size), size, depth);
    let pixel = site.pixel(rng);
    let apart = rng.decade(-8.0, 0.0);
    for _ in 0..2 + rng.below(5) {
        let by = rng.between(0.0, 0.4);
        let back = rng.between(0.0, apart);
        let mut at = site.near_ray(rng, pixel, depth, by);
        // Fronts nearly level along the ray.
        let r = rng.between(0.5, 1.5);
        at[2] += (r * r - by * by).sqrt() + back;
        site.push(at, r);
    }
    site.done(rng, vec![pixel; 2])
}

/// A pixel is larger than the sphere.
fn sub_pixel(rng: &mut Rng) -> World {
    let size = size(rng);
    let half = rng.decade(-5.0, 0.3);
    let mut site = Site::random(rng, [half, half], size, 1.0);
    let mut pixels = Vec::new();
    for _ in 0..2 {
        let pixel = site.pixel(rng);
        let depth = rng.decade(0.3, 5.0);
        let radius = depth * half / f64::from(size[1]) * rng.decade(-6.5, 0.0);
        let at = site.near_ray(rng, pixel, depth, radius);
        // Where the projected centre's own rounding is what grazes.
        let delta = if rng.below(2) == 0 { rng.sign() * rng.decade(-8.0, -1.0) } else { rng.decade(-2.0, 0.3) };
        site.aim_by(delta, pixel, at);
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

/// Any family's scene, 1e-30 to 1e30 times as large.
fn scales(rng: &mut Rng) -> World {
    let World { mut scene, pixels } = FAMILIES[rng.below(9) as usize].1(rng);
    // A power of two, so that rays graze as before.
    let scale = 2f64.powi(rng.below(200) as i32 - 100);
    scaled(&mut scene, scale);
    World { scene, pixels }
}

fn scaled(scene: &mut Scene, scale: f64) {
    scene.camera.eye *= scale;
    for center in &mut scene.spheres.centers {
        *center = center.map(|x| x * scale);
    }
    for radius in &mut scene.spheres.radii {
        *radius *= scale;
    }
}

/// At the corners of a wide image, where |d|^2 is largest.
fn corner(rng: &mut Rng) -> World {
    let size = size(rng);
    let half = rng.decade(-0.3, 1.3);
    let mut site = Site::random(rng, [half, half], size, 1.0);
    let mut pixels = Vec::new();
    for _ in 0..2 {
        let pixel = [rng.below(2) * (size[1] - 1), rng.below(2) * (size[0] - 1)];
        let depth = rng.decade(0.3, 5.0);
        let radius = depth * rng.decade(-4.0, 0.0);
        let at = site.near_ray(rng, pixel, depth, radius);
        site.aim(rng, pixel, at);
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

/// Viewports a hundred times as wide as tall, or the reverse, on square images.
fn anisotropic(rng: &mut Rng) -> World {
    let size = size(rng);
    let half = rng.decade(-3.0, 1.0);
    let half = if rng.below(2) == 0 { [half, half / 100.0] } else { [half / 100.0, half] };
    let site = Site::random(rng, half, size, 1.0);
    aimed(rng, site, [0.3, 5.0], &[])
}

/// The eye just outside, just inside, or on a surface.
fn surface(rng: &mut Rng) -> World {
    let size = size(rng);
    let mut site = Site::random(rng, shaped(rng.clone().decade(-2.0, 0.5), size).map(|h| h.min(25.0)), size, 0.0);
    for _ in 0..1 + rng.below(2) {
        let r = rng.decade(-2.0, 6.0);
        let gap = 1.0 + rng.sign() * rng.decade(-16.0, -2.0);
        let way = DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0));
        site.push((way.normalize() * r * gap).to_array(), r);
    }
    let pixel = site.pixel(rng);
    site.done(rng, vec![pixel])
}

/// Up to 2^20 pixels wide.
fn big_image(rng: &mut Rng) -> World {
    let size = [1 << (10 + rng.below(11)), 1 + rng.below(3000)];
    let half = rng.decade(-4.0, 0.7);
    let site = Site::random(rng, shaped(half.min(20.0 / f64::from(size[0])), size), size, 1.0);
    aimed(rng, site, [0.3, 6.0], &[])
}

/// Ahead by little, aside by much: in front, but not by a projected centre.
fn beside(rng: &mut Rng) -> World {
    let size = size(rng);
    let half = rng.decade(0.0, 2.5);
    let mut site = Site::random(rng, [half, half], size, 1.0);
    // Small: p x d cancels, which affects the normal first.
    let pixel = site.pixel(rng);
    let radius = rng.decade(-5.5, -3.0);
    let at = site.near_ray(rng, pixel, 1.0, radius);
    site.aim_by(rng.decade(-2.0, 0.3), pixel, at);
    aimed(rng, site, [-1.0, 1.0], &[pixel])
}

/// Parallel rays of a view about as high as that, from somewhere within `unit`.
fn parallel_site(rng: &mut Rng, size: [u32; 2], height: f64, unit: f64) -> Site {
    let site = Site::random(rng, [1.0; 2], size, unit);
    let lens = Lens::Orthographic { height };
    Site::new(Camera { lens, ..site.scene.camera }, size)
}

/// One to four spheres at any depth, larger or smaller than the view, grazed.
fn parallel(rng: &mut Rng) -> World {
    let size = size(rng);
    let height = rng.decade(-3.0, 3.0);
    let mut site = parallel_site(rng, size, height, 1.0);
    let mut pixels = Vec::new();
    for _ in 0..1 + rng.below(4) {
        let pixel = site.pixel(rng);
        let radius = height * rng.decade(-4.0, 0.5);
        let depth = radius * rng.decade(0.0, 4.0);
        let at = site.near_ray(rng, pixel, depth, radius);
        site.aim(rng, pixel, at);
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

/// Across the plane of the eye, just before and just behind it; the eye within; something farther behind.
fn parallel_crossing(rng: &mut Rng) -> World {
    let size = size(rng);
    let mut site = parallel_site(rng, size, 2.0, 1.0);
    let mut pixels = Vec::new();
    for _ in 0..1 + rng.below(4) {
        let pixel = site.pixel(rng);
        let radius = rng.decade(-2.0, 0.5);
        let depth = match rng.below(3) {
            0 => rng.between(-1.0, 1.0),
            1 => rng.sign() * (1.0 + rng.sign() * rng.decade(-16.0, -1.0)),
            _ => rng.between(1.0, 3.0),
        };
        let by = radius * rng.between(0.0, 1.0);
        let at = site.near_ray(rng, pixel, depth * radius, by);
        if rng.below(2) == 0 {
            site.aim(rng, pixel, at);
        } else {
            site.push(at, radius);
        }
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

/// Far from the plane, or far from the origin, which makes the order hard.
fn parallel_distant(rng: &mut Rng) -> World {
    let size = size(rng);
    let (depth, unit) = match rng.below(2) {
        0 => (rng.decade(0.7, 12.0), 1.0),
        _ => (rng.decade(0.7, 2.0), rng.decade(2.0, 9.0)),
    };
    let mut site = parallel_site(rng, size, 3.0, unit);
    let pixel = site.pixel(rng);
    let apart = rng.decade(-8.0, 0.0);
    for _ in 0..2 + rng.below(5) {
        let by = rng.between(0.0, 0.4);
        let back = rng.between(0.0, apart);
        let mut at = site.near_ray(rng, pixel, depth, by);
        let r = rng.between(0.5, 1.5);
        at[2] += (r * r - by * by).sqrt() + back;
        site.push(at, r);
    }
    site.done(rng, vec![pixel; 2])
}

/// A pixel is larger than the sphere, and the host's rounding of where it is what grazes.
fn parallel_sub_pixel(rng: &mut Rng) -> World {
    let size = size(rng);
    let height = rng.decade(-5.0, 5.0);
    let mut site = parallel_site(rng, size, height, 1.0);
    let mut pixels = Vec::new();
    for _ in 0..2 {
        let pixel = site.pixel(rng);
        let depth = height * rng.decade(-1.0, 9.0);
        let radius = height / f64::from(size[1]) * rng.decade(-6.5, 0.0);
        let at = site.near_ray(rng, pixel, depth, radius);
        let delta = if rng.below(2) == 0 { rng.sign() * rng.decade(-8.0, -1.0) } else { rng.decade(-2.0, 0.3) };
        site.aim_by(delta, pixel, at);
        pixels.push(pixel);
    }
    site.done(rng, pixels)
}

/// Any of these, 1e-30 to 1e30 times as large.
fn parallel_scales(rng: &mut Rng) -> World {
    let World { mut scene, pixels } = FAMILIES[15 + rng.below(4) as usize].1(rng);
    let scale = 2f64.powi(rng.below(200) as i32 - 100);
    if let Lens::Orthographic { height } = &mut scene.camera.lens {
        *height *= scale;
    }
    scaled(&mut scene, scale);
    World { scene, pixels }
}

/// `up` almost along the view, the eye so near the origin beside `at` that their difference has more than 100 bits, and a
/// lens in which a turn of the image by 1e-17 rad shows. `at` is exactly on the axis.
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
    // After a turn almost about the view, `up` may be parallel to it.
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

/// Any family's scene where squares overflow, or among the subnormal numbers.
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
    // The least length keeps a few bits; the largest number stays where differences do not overflow.
    let k = if rng.below(2) == 0 { -1070 + rng.below(40) as i32 - least } else { 990 - rng.below(300) as i32 - most };
    let scale = |x: &mut f64| *x = dd::ldexp(*x, k);
    if let Lens::Orthographic { height } = &mut scene.camera.lens {
        scale(height);
    }
    let mut eye = scene.camera.eye.to_array();
    eye.iter_mut().chain(scene.spheres.centers.iter_mut().flatten()).for_each(scale);
    scene.spheres.radii.iter_mut().for_each(scale);
    scene.camera.eye = eye.into();
    World { scene, pixels }
}
