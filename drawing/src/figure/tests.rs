//! A figure shows what the certified frame shows: at the centre of every pixel the path that holds it is that of the sphere of the pixel.
//! Paths are read as SVG defines them, by code that knows nothing of spheres.

use super::*;
use halfline::camera::{Camera, Look};
use halfline::render::Renderer;
use halfline::scene::{ImagePlane, Lighting, Spheres};
use halfline::settings::{Accuracy, Backend, Settings};
use std::f64::consts::TAU;

/// The distance from a path within which a place may be on either side: numbers are rounded to 1e-4, and arcs through rounded ends have other
/// centres.
const NEAR: f64 = 1e-3;

/// A line of a path: straight, or an arc of an ellipse with its centre, half axes, turn, first angle and way.
enum Line {
    Straight([f64; 2], [f64; 2]),
    Arc { center: [f64; 2], axes: [f64; 2], turn: f64, start: f64, way: f64 },
}

/// The lines of a path of M, A, L and Z, by section B.2.4 of the specification of SVG 2.
fn lines(path: &str) -> Vec<Line> {
    let spaced: String =
        path.chars().flat_map(|c| if c.is_ascii_alphabetic() { vec![' ', c, ' '] } else { vec![c] }).collect();
    let (mut words, mut at, mut first, mut all) = (spaced.split_whitespace(), [0.0; 2], [0.0; 2], Vec::new());
    while let Some(command) = words.next() {
        let mut number = || words.next().and_then(|word| word.parse::<f64>().ok()).expect("a number");
        match command {
            "M" => (at, first) = ([number(), number()], [0.0; 2]),
            "L" => {
                let to = [number(), number()];
                all.push(Line::Straight(at, to));
                at = to;
            }
            "A" => {
                let [rx, ry, degrees, larger, sweep, x, y] = [(); 7].map(|()| number());
                all.push(arc(at, [rx, ry], degrees.to_radians(), [larger, sweep], [x, y]));
                at = [x, y];
            }
            _ => all.push(Line::Straight(at, first)),
        }
        if command == "M" {
            first = at;
        }
    }
    all
}

fn arc(from: [f64; 2], [mut rx, mut ry]: [f64; 2], turn: f64, [larger, sweep]: [f64; 2], to: [f64; 2]) -> Line {
    let (sin, cos) = turn.sin_cos();
    let [dx, dy] = [(from[0] - to[0]) / 2.0, (from[1] - to[1]) / 2.0];
    let [x, y] = [cos * dx + sin * dy, cos * dy - sin * dx];
    let size = (x / rx).powi(2) + (y / ry).powi(2);
    if size > 1.0 {
        (rx, ry) = (rx * size.sqrt(), ry * size.sqrt());
    }
    let across = (rx * y).powi(2) + (ry * x).powi(2);
    let side = if larger == sweep { -1.0 } else { 1.0 };
    let factor = side * (((rx * ry).powi(2) - across) / across).max(0.0).sqrt();
    let [cx, cy] = [factor * rx * y / ry, -factor * ry * x / rx];
    let center = [cos * cx - sin * cy + (from[0] + to[0]) / 2.0, sin * cx + cos * cy + (from[1] + to[1]) / 2.0];
    let start = ((y - cy) / ry).atan2((x - cx) / rx);
    let mut way = ((-y - cy) / ry).atan2((-x - cx) / rx) - start;
    if sweep == 1.0 && way < 0.0 {
        way += TAU;
    }
    if sweep == 0.0 && way > 0.0 {
        way -= TAU;
    }
    Line::Arc { center, axes: [rx, ry], turn, start, way }
}

/// The columns at which lines cross a row.
fn crossings(lines: &[Line], row: f64) -> Vec<f64> {
    let mut all = Vec::new();
    for line in lines {
        match line {
            Line::Straight(a, b) => {
                if (a[1] > row) != (b[1] > row) {
                    all.push(a[0] + (row - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
                }
            }
            Line::Arc { center, axes: [rx, ry], turn, start, way } => {
                let (sin, cos) = turn.sin_cos();
                // The row at an angle is that of the centre + a cos + b sin.
                let [a, b] = [rx * sin, ry * cos];
                let share = (row - center[1]) / a.hypot(b);
                if share.abs() > 1.0 {
                    continue;
                }
                for half in [share.acos(), -share.acos()] {
                    let angle = b.atan2(a) + half;
                    let along = if *way > 0.0 { angle - start } else { start - angle }.rem_euclid(TAU);
                    if along < way.abs() {
                        all.push(center[0] + rx * cos * angle.cos() - ry * sin * angle.sin());
                    }
                }
            }
        }
    }
    all
}

/// Whether a place lies within an odd number of lines.
fn is_inside(lines: &[Line], [x, y]: [f64; 2]) -> bool {
    crossings(lines, y).iter().filter(|column| **column > x).count() % 2 == 1
}

/// Numbers from 0 to 1, of a linear congruential generator.
struct Rng(u64);

impl Rng {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

fn scene(spheres: Spheres, at: [f64; 3], lens: Lens) -> Scene {
    let eye = DVec3::from_array(at) + DVec3::new(0.0, 0.0, 9.0);
    let camera = Camera { eye, look: Look::At(at.into()), lens, ..Camera::CANONICAL };
    let image = ImagePlane { width: 96, height: 72, background: [0.0; 3] };
    Scene { camera, image, spheres, lighting: Lighting::default() }
}

/// Spheres of hard cases around a point.
fn hard(case: u64, at: [f64; 3]) -> (&'static str, Spheres) {
    let (mut rng, mut spheres) = (Rng(case + 1), Spheres::default());
    let mut push = |[x, y, z]: [f64; 3], radius: f64| spheres.push([at[0] + x, at[1] + y, at[2] + z], radius, None);
    let name = match case % 6 {
        0 => {
            (0..60).for_each(|_| push([0; 3].map(|_| rng.between(-2.0, 2.0)), rng.between(0.1, 0.9)));
            "crossing"
        }
        1 => {
            (0..40).for_each(|_| {
                let center = [0; 3].map(|_| rng.between(-2.0, 2.0));
                [0.5, 0.4, 0.2].into_iter().for_each(|radius| push(center, radius));
                push(center, 0.5);
            });
            "nested and equal"
        }
        2 => {
            // Balls of a lattice touch; under a parallel camera along an axis their outlines are one.
            (0..27).for_each(|n| push([n % 3, n / 3 % 3, n / 9].map(|k| f64::from(k) - 1.0), 0.5));
            "a lattice whose balls touch"
        }
        3 => {
            (0..27).for_each(|n| push([n % 3, n / 3 % 3, n / 9].map(|k| 0.75 * (f64::from(k) - 1.0)), 0.5));
            "a lattice whose balls cross"
        }
        4 => {
            // Three and more surfaces through the origin.
            (0..12).for_each(|_| {
                let center = [0; 3].map(|_| rng.between(-1.0, 1.0));
                push(center, DVec3::from_array(center).length());
            });
            "through one point"
        }
        _ => {
            (0..400).for_each(|_| push([0; 3].map(|_| rng.between(-2.0, 2.0)), rng.between(0.1, 0.3)));
            "many"
        }
    };
    (name, spheres)
}

#[test]
fn figures_show_what_frames_show() {
    let vfov = |degrees| Lens::Vfov { degrees, distance: 1.0 };
    let settings =
        Settings { backend: Backend::Cpu, accuracy: Accuracy::Certified, aovs: Vec::new(), ..Settings::default() };
    let mut renderer = Renderer::new(&settings).expect("the CPU path");
    let (mut centers, mut close, mut wrong, mut joined) = (0, 0, Vec::new(), 0);
    for case in 0..24_u64 {
        for at in [[0.0; 3], [1e6, -3e5, 2e5]] {
            for lens in [
                vfov(40.0),
                Lens::Orthographic { height: 5.0 },
                Lens::Intrinsics { fx: 90.0, fy: 120.0, cx: 30.0, cy: 50.5 },
            ] {
                let (name, spheres) = hard(case, at);
                let scene = scene(spheres, at, lens);
                let figure = Figure::new(&scene).expect("a figure");
                joined += figure.joined();
                let frame = renderer.render(&scene, &settings).expect("a frame");
                let paths: Vec<_> =
                    figure.regions().iter().map(|region| (region.sphere as i32, lines(&figure.path(region)))).collect();
                for (n, id) in frame.ids().iter().enumerate() {
                    let place = [(n % 96) as f64 + 0.5, (n / 96) as f64 + 0.5];
                    let at = |place: [f64; 2]| {
                        paths.iter().filter(|(_, lines)| is_inside(lines, place)).map(|(id, _)| *id).collect::<Vec<_>>()
                    };
                    let found = at(place);
                    let expected = if *id < 0 { vec![] } else { vec![*id] };
                    centers += 1;
                    if found == expected {
                        continue;
                    }
                    let around = [[NEAR, 0.0], [-NEAR, 0.0], [0.0, NEAR], [0.0, -NEAR]];
                    let is_close = around.iter().any(|[x, y]| at([place[0] + x, place[1] + y]) != found);
                    close += u32::from(is_close);
                    if !is_close {
                        wrong.push(format!(
                            "{name} {case}, {at:?}, {lens:?}: {place:?} is in {found:?}, and shows {id}",
                            at = scene.camera.eye
                        ));
                    }
                }
            }
        }
    }
    println!("{centers} centres, {close} within {NEAR} of a line, {} wrong, {joined} lines joined", wrong.len());
    assert!(
        wrong.is_empty() && joined == 0,
        "{} wrong: {:#?}, {joined} joined",
        wrong.len(),
        &wrong[..wrong.len().min(8)]
    );
    assert!(close < centers / 1000, "{close} of {centers}");
}

#[test]
fn what_has_no_ellipses_is_refused() {
    let (_, spheres) = hard(0, [0.0; 3]);
    let mut inside = scene(spheres, [0.0; 3], Lens::Vfov { degrees: 40.0, distance: 1.0 });
    inside.camera.eye = inside.spheres.centers[0].into();
    let words = |scene: &Scene| Figure::new(scene).err().map(|error| error.to_string()).unwrap_or_default();
    assert!(words(&inside).contains("across the plane of the eye"), "{}", words(&inside));
}
