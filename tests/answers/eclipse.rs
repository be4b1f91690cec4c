//! The promise of a light with a size: scenes/eclipse.toml has the umbra and the penumbra of three spheres.
//!
//! Gold standard: the cones that touch Sun and Moon, cut with the Earth's sphere, and the overlap of two discs, from the
//! scene's numbers. All is computed here in f64; its error is below a metre, as the first test shows.

use crate::adapter::cpu;
use crate::home::home;
use glam::DVec3;
use halfline::camera::{Lens, Look};
use halfline::frame::Aov;
use halfline::scene::Scene;
use halfline::settings::{Accuracy, Settings};
use halfline_files::read::ReadOptions;
use std::f64::consts::{PI, TAU};

/// The points of a light that are asked for each pixel.
const POINTS: u32 = 64;

/// A sphere of the scene.
#[derive(Debug, Clone, Copy)]
struct Ball {
    center: DVec3,
    radius: f64,
}

/// Sun, Moon and Earth, and the direction from the Sun to the Moon.
#[derive(Debug, Clone, Copy)]
struct Eclipse {
    sun: Ball,
    moon: Ball,
    earth: Ball,
    axis: DVec3,
}

/// The cones in which the Sun is hidden, completely or in part.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shadow {
    Umbra,
    Penumbra,
}

/// The discs of Sun and Moon as a point of the ground sees them: the radius of the Moon's disc and the distance of the
/// centres, in radii of the Sun's disc.
#[derive(Debug, Clone, Copy)]
struct Discs {
    moon: f64,
    apart: f64,
}

/// A point of the ground, and the share of the Sun that the frame says is hidden there.
struct Pixel {
    at: DVec3,
    share: f64,
}

fn file() -> Scene {
    let path = home().join("scenes/eclipse.toml");
    halfline_files::read::scene(&path, &ReadOptions::default()).expect("the eclipse").scene
}

impl Eclipse {
    fn of(scene: &Scene) -> Self {
        let ball = |n: usize| Ball { center: scene.spheres.centers[n].into(), radius: scene.spheres.radii[n] };
        let (sun, moon, earth) = (ball(0), ball(1), ball(2));
        Self { sun, moon, earth, axis: (moon.center - sun.center).normalize() }
    }

    /// The first point at which a half line meets the Earth; NaN on a miss.
    fn ground(&self, from: DVec3, along: DVec3) -> DVec3 {
        let to = self.earth.center - from;
        let b = to.dot(along);
        let off = to - along * b;
        from + along * (b - (self.earth.radius.powi(2) - off.length_squared()).sqrt())
    }

    /// Across the axis, away from the Earth's centre: with the axis it spans the plane of symmetry.
    fn outward(&self) -> DVec3 {
        let from = self.moon.center - self.earth.center;
        (from - self.axis * from.dot(self.axis)).normalize()
    }

    /// The extent along the ground in the plane of symmetry: the great circle between the two lines of the cone there; each
    /// line touches the Moon on one side.
    fn extent(&self, shadow: Shadow) -> f64 {
        let distance = (self.moon.center - self.sun.center).length();
        // The umbra's lines touch both spheres on one side, the penumbra's on opposite sides.
        let side = if shadow == Shadow::Umbra { 1.0 } else { -1.0 };
        let sine = (self.sun.radius - side * self.moon.radius) / distance;
        let ends = [1.0, -1.0].map(|end| {
            let out = self.outward() * end;
            let along = self.axis * (1.0 - sine * sine).sqrt() - out * (side * sine);
            let touched = out * (1.0 - sine * sine).sqrt() + self.axis * (side * sine);
            self.ground(self.moon.center + touched * self.moon.radius, along) - self.earth.center
        });
        self.earth.radius * ends[0].angle_between(ends[1])
    }

    fn discs(&self, at: DVec3) -> Discs {
        let (sun, moon) = (self.sun.center - at, self.moon.center - at);
        let [sun_radius, moon_radius] =
            [(self.sun.radius, sun), (self.moon.radius, moon)].map(|(radius, to)| (radius / to.length()).asin());
        let apart = (sun.cross(moon).length() / (sun.length() * moon.length())).asin();
        Discs { moon: moon_radius / sun_radius, apart: apart / sun_radius }
    }

    /// The extent of points of the ground in the plane of symmetry, along the ground.
    fn extent_of(&self, points: impl Iterator<Item = DVec3>) -> f64 {
        let angle = |at: DVec3| {
            let up = at - self.earth.center;
            up.dot(self.outward()).atan2(-up.dot(self.axis))
        };
        let ends = points.map(angle).fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
        self.earth.radius * (ends[1] - ends[0])
    }

    /// The length on the ground, along the plane of symmetry, of one radius of the Sun's disc.
    fn sun_on_the_ground(&self) -> f64 {
        let center = self.ground(self.moon.center, self.axis);
        let sun = self.sun.radius / (self.sun.center - center).length();
        let altitude = -(center - self.earth.center).normalize().dot(self.axis);
        sun * (self.moon.center - center).length() / altitude
    }

    /// The Moon's radius that explains the light of all these pixels.
    fn fitted(&self, pixels: &[Pixel]) -> Self {
        let measured: f64 = pixels.iter().map(|pixel| pixel.share).sum();
        let with = |radius: f64| Self { moon: Ball { radius, ..self.moon }, ..*self };
        let mut ends = [1700.0, 1800.0];
        for _ in 0..40 {
            let middle = (ends[0] + ends[1]) / 2.0;
            let hidden: f64 = pixels.iter().map(|pixel| with(middle).discs(pixel.at).hidden()).sum();
            ends[usize::from(hidden > measured)] = middle;
        }
        with(ends[0])
    }

    /// The ground where the Sun is up, through a lens from beside the Moon, whose disc is not in view.
    fn pixels(&self, degrees: f64, side: u32) -> Vec<Pixel> {
        let mut scene = file();
        scene.camera.eye = self.moon.center + DVec3::new(0.0, 0.0, 20_000.0);
        scene.camera.look = Look::At(self.ground(self.moon.center, self.axis));
        scene.camera.lens = Lens::Vfov { degrees, distance: 1.0 };
        [scene.image.width, scene.image.height] = [side; 2];
        let settings =
            Settings { accuracy: Accuracy::Certified, aovs: vec![Aov::Position, Aov::Shadow], ..Settings::default() };
        let frame = cpu().render(&scene, &settings).expect("a frame");
        let positions = frame.f64(Aov::Position).expect("a requested buffer").chunks_exact(3).map(DVec3::from_slice);
        let shares = frame.f32(Aov::Shadow).expect("a requested buffer");
        let pixels = positions.zip(shares).zip(frame.ids());
        let pixels = pixels.filter(|(_, id)| **id == 2).map(|((at, &share), _)| Pixel { at, share: f64::from(share) });
        // Near the terminator the Earth hides the Sun.
        pixels.filter(|pixel| (pixel.at - self.earth.center).dot(-self.axis) > 0.05 * self.earth.radius).collect()
    }
}

impl Discs {
    /// The distance beyond the edge of the umbra, in radii of the Sun's disc; negative inside the umbra.
    fn beyond(self) -> f64 {
        self.apart - (self.moon - 1.0)
    }

    /// The distance within the edge of the penumbra, in radii of the Sun's disc; negative outside the penumbra.
    fn within(self) -> f64 {
        1.0 + self.moon - self.apart
    }

    /// The share of the Sun's disc behind the Moon's. The discs are 0.005 rad wide; that they are not flat changes the share
    /// by less than 1e-5.
    fn hidden(self) -> f64 {
        let Discs { moon, apart } = self;
        if self.within() <= 0.0 {
            return 0.0;
        }
        if self.beyond() <= 0.0 {
            return 1.0;
        }
        let x = (apart * apart + 1.0 - moon * moon) / (2.0 * apart);
        let y = apart - x;
        let half = (1.0 - x * x).max(0.0).sqrt();
        (x.acos() - x * half + moon * moon * (y / moon).acos() - y * half) / PI
    }
}

/// The largest distances from the exact edges, in radii of the Sun, at which a share may still be 1 outside the umbra,
/// and 0 inside the penumbra. For each turn of the points, a Moon that moves away along x uncovers the first of them at
/// the one distance and the last at the other.
fn reach(moon: f64) -> [f64; 2] {
    let golden = PI * (3.0 - 5f64.sqrt());
    let [mut one, mut zero] = [0f64; 2];
    for turn in 0..3600 {
        let apart = |n: u32| {
            let radius = ((f64::from(n) + 0.5) / f64::from(POINTS)).sqrt();
            let (y, x) = (f64::from(n) * golden + f64::from(turn) * TAU / 3600.0).sin_cos();
            radius * x + (moon * moon - radius * radius * y * y).sqrt()
        };
        let first = (0..POINTS).map(apart).fold(f64::INFINITY, f64::min);
        let last = (0..POINTS).map(apart).fold(0.0, f64::max);
        [one, zero] = [one.max(first - (moon - 1.0)), zero.max(1.0 + moon - last)];
    }
    // Between two turns, and for the Moon's size elsewhere on the ground, which differs by 0.3 %.
    [one, zero].map(|reach| 1.01 * reach)
}

#[test]
fn the_closed_form_has_the_digits_of_other_arithmetic() {
    let eclipse = Eclipse::of(&file());
    // The same cones in 50 decimal digits, with mpmath.
    assert!((eclipse.extent(Shadow::Umbra) - 260.708_766_070).abs() < 1e-3);
    assert!((eclipse.extent(Shadow::Penumbra) - 7_190.350_327_353).abs() < 1e-3);
    // The published place of greatest eclipse is 25.5 N, 33.2 E. That latitude is geodetic, 0.15 degrees more than ours.
    let center = eclipse.ground(eclipse.moon.center, eclipse.axis) - eclipse.earth.center;
    let latitude = (center.z / center.length()).asin().to_degrees();
    assert!((latitude + 0.15 - 25.5).abs() < 0.1, "{latitude}");
    assert!((center.y.atan2(center.x).to_degrees() - 33.2).abs() < 0.1);
}

#[test]
fn the_umbra_has_the_diameter_of_its_cone() {
    let eclipse = Eclipse::of(&file());
    let exact = eclipse.extent(Shadow::Umbra);
    // A field of 500 km.
    let pixels = eclipse.pixels(0.08, 160);
    assert_eq!(pixels.len(), 160 * 160);
    // Inside the cone every point of the Sun is hidden, whichever are asked. The positions are within 0.1 km, which is
    // less than 1e-4 radii of the Sun.
    let reach = reach(1.08)[0];
    for Pixel { at, share } in &pixels {
        let beyond = eclipse.discs(*at).beyond();
        assert!(*share == 1.0 || beyond > -1e-4, "{share} inside the umbra, {beyond}");
        assert!(*share < 1.0 || beyond < reach, "{share} outside the umbra, {beyond}");
    }
    // A pixel is 3.1 km; at each end one may be missing.
    let measured = eclipse.extent_of(pixels.iter().filter(|pixel| pixel.share == 1.0).map(|pixel| pixel.at));
    let most = exact + 2.0 * (reach * eclipse.sun_on_the_ground() + 3.2);
    println!("share 1: {measured:.1} km, the umbra {exact:.1} km, at most {most:.1} km");
    assert!(exact - 6.4 < measured && measured < most, "{measured} of {exact}");
    // The crescent that the points miss makes share 1 too large, but the mean of the shares is right: the umbra that explains
    // the light of all pixels. Shares outside the umbra have errors of 0.009 (root mean square), so the sum over these 20,200
    // pixels is known to 1.3, and 1 km of diameter changes it by 3.5: a standard error of 0.36 km. That the points have only
    // 64 distances from the middle of the disc adds 0.12 km in this field.
    let fitted = eclipse.fitted(&pixels).extent(Shadow::Umbra);
    println!("fitted: {fitted:.2} km");
    assert!((fitted - exact).abs() < 4.0 * 0.36 + 0.12, "{fitted} of {exact}");
}

#[test]
fn the_penumbra_has_the_diameter_of_its_cone() {
    let eclipse = Eclipse::of(&file());
    let exact = eclipse.extent(Shadow::Penumbra);
    let pixels = eclipse.pixels(1.4, 120);
    assert!(pixels.len() > 10_000);
    let reach = reach(1.08)[1];
    for Pixel { at, share } in &pixels {
        let within = eclipse.discs(*at).within();
        assert!(*share == 0.0 || within > -1e-4, "{share} outside the penumbra, {within}");
        assert!(*share > 0.0 || within < reach, "{share} inside the penumbra, {within}");
    }
    let measured = eclipse.extent_of(pixels.iter().filter(|pixel| pixel.share > 0.0).map(|pixel| pixel.at));
    println!("share > 0: {measured:.0} km of {exact:.0} km");
    assert!(measured < exact, "{measured} of {exact}");
    // Errors of 0.0125 at about 6,700 pixels add up to 1.0, and 1 km of diameter changes the sum by 0.85: a standard error of
    // 1.2 km.
    let fitted = eclipse.fitted(&pixels).extent(Shadow::Penumbra);
    println!("fitted: {fitted:.1} km");
    assert!((fitted - exact).abs() < 4.0 * 1.2, "{fitted} of {exact}");
}
