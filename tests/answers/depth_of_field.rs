//! The promises of a lens with a size. Colour and coverage come from rays from points of the lens through the places of the
//! pinhole's samples in the plane of focus. All other buffers are the pinhole's; crops, seeds and adapters as without it.
//!
//! Gold standards: these rays in f64, here (the hash of positions, the spiral of the lens and the quadratic), and
//! the size of a disc of blur by similar triangles.

use crate::adapter::{cpu, gpu_or_skip};
use crate::rng::Rng;
use glam::DVec3;
use halfline::camera::{Aperture, Camera, Lens, Look};
use halfline::error::Error;
use halfline::frame::{Aov, Frame};
use halfline::quote::setting::SAMPLES;
use halfline::render::Renderer;
use halfline::render::stream::Stream;
use halfline::scene::{ImagePlane, Scene, Sky, Spheres};
use halfline::settings::{Accuracy, Settings};
use halfline::shade::Shade;
use halfline::window::Window;
use halfline_files::read::{ReadOptions, Sequence};
use std::path::Path;

const SIZE: [u32; 2] = [60, 44];
const STRATA: u32 = 3;
const SEED: u32 = 11;
const VH: f64 = 0.9;
const FOCUS: f64 = 7.0;
const DIAMETER: f64 = 1.2;

fn scene() -> Scene {
    let mut random = Rng::new(4);
    let mut spheres = Spheres::default();
    for n in 0..60 {
        let center = [10.0 * random.unit() - 5.0, 8.0 * random.unit() - 4.0, 12.0 * random.unit() - 12.0];
        spheres.push(center, 0.1 + 0.6 * random.unit(), Some([(n % 3) as f32 / 2.0, 0.5, 0.9]));
    }
    let [width, height] = SIZE;
    Scene {
        camera: Camera {
            eye: DVec3::new(0.5, 1.0, 4.0),
            look: Look::View(DVec3::new(-0.1, -0.2, -1.0)),
            up: DVec3::new(0.1, 1.0, 0.2),
            lens: Lens::Viewport { vw: VH * f64::from(width) / f64::from(height), vh: VH, distance: 1.0 },
        },
        image: ImagePlane { width, height, background: [0.0; 3] },
        spheres,
        lighting: Default::default(),
    }
}

fn settings(aovs: &[Aov]) -> Settings {
    Settings {
        accuracy: Accuracy::Certified,
        shade: Shade::Flat,
        aovs: aovs.to_vec(),
        samples: STRATA * STRATA,
        seed: SEED,
        aperture: Some(Aperture { diameter: DIAMETER, focus: Some(FOCUS) }),
        ..Settings::default()
    }
}

fn render(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Frame {
    renderer.render(scene, settings).expect("a frame")
}

/// The hash pcg4d of Jarzynski and Olano.
fn pcg4d(v: [u32; 4]) -> [u32; 4] {
    let mut v = v.map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    for round in 0..2 {
        for (a, b, c) in [(0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)] {
            v[a] = v[a].wrapping_add(v[b].wrapping_mul(v[c]));
        }
        if round == 0 {
            v = v.map(|x| x ^ x >> 16);
        }
    }
    v
}

/// The point of the unit disc that a sample leaves from.
fn lens_point(sample: u32) -> [f64; 2] {
    let (row, column) = (sample / STRATA, sample % STRATA);
    let place = f64::from(STRATA * ((row + column) % STRATA) + (row + 2 * column) % STRATA);
    let number = |bits: u32| (2.0 * f64::from(bits) + 1.0) / 4_294_967_296.0 - 1.0;
    let [x, y, z, w] = pcg4d([0, 0, 0, SEED]);
    let pairs = (0..).flat_map(|trial: u32| {
        let [a, b, c, d] = pcg4d([x, y, z ^ u32::MAX, w.wrapping_add(trial)]).map(number);
        [[a, b], [c, d]]
    });
    let [a, b] = pairs.into_iter().find(|[a, b]| a.hypot(*b) < 1.0).expect("a pair within the disc");
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let (angle, radius) = (b.atan2(a) + place * golden, ((place + 0.5) / f64::from(STRATA * STRATA)).sqrt());
    [radius * angle.cos(), radius * angle.sin()]
}

/// The nearest sphere, and the least share of a radius by which the ray passes a silhouette.
fn nearest(scene: &Scene, eye: DVec3, direction: DVec3) -> (Option<usize>, f64) {
    let d = direction.normalize();
    let (mut found, mut margin): (Option<(usize, f64)>, f64) = (None, f64::INFINITY);
    for (n, (center, radius)) in scene.spheres.centers.iter().zip(&scene.spheres.radii).enumerate() {
        let p = DVec3::from_array(*center) - eye;
        let relative_distance = p.cross(d).length() / radius;
        margin = margin.min((relative_distance - 1.0).abs());
        let t = p.dot(d) - radius * (1.0 - relative_distance * relative_distance).max(0.0).sqrt();
        if relative_distance < 1.0 && t > 0.0 && found.is_none_or(|(_, least)| t < least) {
            found = Some((n, t));
        }
    }
    (found.map(|(n, _)| n), margin)
}

#[test]
fn samples_leave_from_the_lens_through_the_plane_of_focus() {
    let scene = scene();
    let camera = &scene.camera;
    let Look::View(view) = camera.look else { panic!("no view") };
    let back = -view.normalize();
    let right = camera.up.cross(back).normalize();
    let up = back.cross(right);
    let pitch = VH / f64::from(SIZE[1]);
    // Places of rays in a stratum: 16 x 16.
    let fine = 16 * STRATA;
    let mut renderers = vec![("CPU path", cpu())];
    renderers.extend(gpu_or_skip().map(|gpu| ("GPU", gpu)));
    for (name, renderer) in &mut renderers {
        let frame = render(renderer, &scene, &settings(&[Aov::Color, Aov::Alpha]));
        let (color, alpha) = (frame.f32(Aov::Color).expect("colours"), frame.f32(Aov::Alpha).expect("coverage"));
        let (mut compared, mut skipped, mut partly) = (0, 0, 0);
        for (row, column) in (0..SIZE[1]).flat_map(|i| (0..SIZE[0]).map(move |j| (i, j))) {
            let (mut hits, mut red, mut least) = (0u32, 0.0, f64::INFINITY);
            for sample in 0..STRATA * STRATA {
                let [across, down, ..] = pcg4d([column, row, sample, SEED]);
                let place = |pixel: u32, stratum: u32, hash: u32| (pixel * STRATA + stratum) * 16 + (hash >> 16 & 15);
                let [i, j] = [place(row, sample / STRATA, down), place(column, sample % STRATA, across)];
                let [x, y] = lens_point(sample).map(|x| x * DIAMETER / 2.0);
                // The viewport of the point is moved by whole places.
                let step = pitch / f64::from(fine);
                let [x_moved, y_moved] = [x, y].map(|x| (x / FOCUS / step).round() * step);
                let at = |n: u32, count: u32| (f64::from(n) + 0.5 - f64::from(count * fine) / 2.0) * step;
                let direction = right * (at(j, SIZE[0]) - x_moved) + up * (-at(i, SIZE[1]) - y_moved) - back;
                let (found, margin) = nearest(&scene, camera.eye + right * x + up * y, direction);
                least = least.min(margin);
                hits += u32::from(found.is_some());
                red += found.map_or(0.0, |id| f64::from((id % 3) as u32) / 2.0);
            }
            // f64 has 1e-16 of 20 units; nearer to a silhouette it does not know.
            if least < 1e-11 {
                skipped += 1;
                continue;
            }
            let at = (row * SIZE[0] + column) as usize;
            let count = f64::from(STRATA * STRATA);
            assert_eq!(alpha[at], (f64::from(hits) / count) as f32, "{name}, row {row}, column {column}");
            assert_eq!(color[3 * at], (red / count) as f32, "{name}, row {row}, column {column}");
            compared += 1;
            partly += u32::from(hits > 0 && f64::from(hits) < count);
        }
        println!("{name}: {compared} pixels, {partly} partly covered, {skipped} skipped");
        assert!(skipped < 5 && partly > 500, "{compared} {partly} {skipped}");
    }
}

/// By similar triangles a point at depth z is a disc of D |z - F|/F over the plane at z: so many pixels wide.
#[test]
fn a_small_sphere_is_a_disc_of_blur_of_the_expected_size() {
    for depth in [4.0, FOCUS, 20.0] {
        let mut spheres = Spheres::default();
        spheres.push([0.0, 0.0, -depth], 0.01 * depth, None);
        let camera = Camera { lens: Lens::Viewport { vw: 1.0, vh: 1.0, distance: 1.0 }, ..Camera::CANONICAL };
        let image = ImagePlane { width: 101, height: 101, background: [0.0; 3] };
        let scene = Scene { camera, image, spheres, lighting: Default::default() };
        let frame = render(&mut cpu(), &scene, &Settings { samples: 400, ..settings(&[Aov::Alpha]) });
        let alpha = frame.f32(Aov::Alpha).expect("coverage");
        let columns = (0..101).filter(|x| (0..101).any(|y| alpha[y * 101 + x] > 0.0)).count() as f64;
        let expected = DIAMETER * (depth - FOCUS).abs() / FOCUS / depth * 101.0 + 0.02 * 101.0;
        println!("depth {depth}: {columns} columns, {expected:.1} expected");
        // Columns at the rim are touched in part, and the sphere is 2 pixels wide itself.
        assert!((columns - expected).abs() < 1.6, "depth {depth}: {columns} columns of {expected}");
    }
}

#[test]
fn other_buffers_are_those_of_the_pinhole_and_crops_are_parts() {
    let scene = scene();
    let all = settings(&[Aov::Color, Aov::Alpha, Aov::Id, Aov::Depth, Aov::Normal]);
    let open = render(&mut cpu(), &scene, &all);
    let pinhole = render(&mut cpu(), &scene, &Settings { aperture: None, ..all.clone() });
    assert_eq!((open.ids(), open.f64(Aov::Depth)), (pinhole.ids(), pinhole.f64(Aov::Depth)));
    assert_eq!(open.f32(Aov::Normal), pinhole.f32(Aov::Normal));
    assert_ne!(open.f32(Aov::Color), pinhole.f32(Aov::Color));
    let other = render(&mut cpu(), &scene, &Settings { seed: SEED + 1, ..all.clone() });
    assert_ne!(open.f32(Aov::Alpha), other.f32(Aov::Alpha), "another seed turns the lens");
    // With lines, and a sky that is taken from the centres of pixels where there is no lens.
    let mut with_sky = scene.clone();
    with_sky.lighting.sky = Some(Sky { rays: 4, at_centers: true, ..Sky::default() });
    let lined = Settings { silhouette: true, shade: Shade::Headlight, ..all };
    let whole = render(&mut cpu(), &with_sky, &lined);
    let color = whole.f32(Aov::Color).expect("colours");
    let window = Window { x0: 17, y0: 9, x1: 42, y1: 30 };
    let part = render(&mut cpu(), &with_sky, &Settings { window: Some(window), ..lined });
    let part = part.f32(Aov::Color).expect("colours");
    for (n, y) in (window.y0..window.y1).enumerate() {
        let [first, end] = [window.x0, window.x1].map(|x| 3 * (y * SIZE[0] + x) as usize);
        let width = 3 * (window.x1 - window.x0) as usize;
        assert_eq!(part[n * width..(n + 1) * width], color[first..end], "row {y}");
    }
}

#[test]
fn what_has_no_lens_is_refused() {
    let scene = scene();
    let settings = settings(&[Aov::Color]);
    let error = |scene: &Scene, settings: &Settings| cpu().render(scene, settings).expect_err("an error");
    let one = error(&scene, &Settings { samples: 1, ..settings.clone() });
    assert!(matches!(&one, Error::Settings { .. }) && one.to_string().contains(SAMPLES), "{one}");
    let mut parallel = scene.clone();
    parallel.camera.lens = Lens::Orthographic { height: 3.0 };
    let error = error(&parallel, &settings);
    assert!(matches!(&error, Error::Scene { .. }) && error.to_string().contains("orthographic"), "{error}");
    let stream = Stream::new(&scene, &settings).map(drop).expect_err("an error");
    assert!(matches!(&stream, Error::Settings { .. }), "{stream}");
    let text = "[camera]\neye = [0, 0, 5]\nview = [0, 0, -1]\nup = [0, 1, 0]\nvfov = 40\n";
    let read = |more: &str| {
        let text = std::io::Cursor::new(format!("{text}{more}"));
        Sequence::from_reader(text, Path::new("lens.toml"), &ReadOptions::default())?.next_scene()
    };
    let found = read("aperture = 0.5\nfocus = 3\n").expect("a scene").expect("one");
    assert_eq!(found.aperture, Some(Aperture { diameter: 0.5, focus: Some(3.0) }));
    for (more, line, words) in [
        ("aperture = 0.5\n", "lens.toml:6", "camera.focus"),
        ("focus = 3\n", "lens.toml:6", "camera.focus"),
        ("focus = 3\naperture = -1\n", "lens.toml:7", "camera.aperture"),
        ("aperture = 1\nfocus = 0\n", "lens.toml:7", "camera.focus"),
    ] {
        let error = read(more).expect_err(more).to_string();
        assert!(error.contains(line) && error.contains(words), "{more}: {error}");
    }
}
