//! A figure shows what the certified frame shows: at the centre of every pixel the path that holds it belongs to the sphere of the pixel.
//! Paths are read as SVG defines them, by code that knows nothing of spheres.

use super::*;
use halfline::camera::{Camera, Look};
use halfline::frame::Aov;
use halfline::render::Renderer;
use halfline::scene::{CutPlane, ImagePlane, Lighting, Spheres};
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
                // The row at an angle is the centre's row + a cos + b sin.
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

/// Planes of hard cases around a point, and the spheres that they cut.
fn cut(case: u64, at: [f64; 3], spheres: &mut Spheres) -> &'static str {
    let (mut rng, at) = (Rng(case + 77), DVec3::from_array(at));
    let mut any = || DVec3::from_array([0; 3].map(|_| rng.between(-1.0, 1.0)));
    let plane = |normal: DVec3, by: f64| CutPlane { normal: normal.into(), distance: normal.dot(at) + by };
    let (z, x) = (DVec3::Z, DVec3::X);
    let (name, planes) = match case % 7 {
        0 => ("toward the eye", vec![plane(z, 0.1)]),
        1 => ("oblique", vec![plane(any(), 0.05)]),
        2 => ("a slab", vec![plane(z + 0.3 * x, 0.4), plane(-z - 0.3 * x, 0.2)]),
        3 => ("crossing", vec![plane(any(), 0.1), plane(any(), 0.1)]),
        4 => ("along the view", vec![plane(x, 0.1)]),
        5 => ("along the view, and toward the eye", vec![plane(x, 0.1), plane(z, 0.2), plane(DVec3::Y, 0.3)]),
        _ => ("three, and whole spheres", vec![plane(any(), 0.1), plane(any(), 0.2), plane(any(), 0.3)]),
    };
    let may: Vec<bool> = (0..spheres.len()).map(|n| n % 5 != 0).collect();
    spheres.cut(&planes, (case % 7 == 6).then_some(&may[..])).expect("planes");
    name
}

/// Counts of places.
#[derive(Debug, Default)]
struct Count {
    places: u32,
    hits: u32,
    close: u32,
    joined: u64,
    faces: usize,
    wrong: Vec<String>,
}

/// Compares the figure of a scene with its frame, at the centre of every pixel. The path that holds it belongs to the sphere of the pixel,
/// and to a face where the normal is the plane's.
fn compare(name: &str, scene: &Scene, renderer: &mut Renderer, settings: &Settings, count: &mut Count) {
    let style = FigureStyle { detail: 0.0, ..FigureStyle::default() };
    let figure = Figure::new(scene, style, None).expect("a figure");
    count.joined += figure.counts().joined;
    let frame = renderer.render(scene, settings).expect("a frame");
    let normals = frame.f32(Aov::Normal).expect("normals");
    let planes = scene.spheres.cuts.as_ref().map_or(&[][..], |cuts| &cuts.planes);
    let paths: Vec<_> = figure.paths().map(|(surface, path)| (surface, lines(&path))).collect();
    let width = scene.image.width as usize;
    let of = |id: u32| (scene.spheres.centers[id as usize], scene.spheres.radii[id as usize]);
    for (n, id) in frame.ids().iter().enumerate() {
        let place = [(n % width) as f64 + 0.5, (n / width) as f64 + 0.5];
        let at = |place: [f64; 2]| {
            paths.iter().filter(|(_, lines)| is_inside(lines, place)).map(|(of, _)| *of).collect::<Vec<_>>()
        };
        let is_face = |face: u32| {
            let normal = DVec3::from_array(planes[face as usize].normal).normalize();
            // Normals are rounded to f32.
            normal.distance(DVec3::from_array([0, 1, 2].map(|k| f64::from(normals[3 * n + k])))) < 1e-5
        };
        let found = at(place);
        let is_right = match &found[..] {
            [] => *id < 0,
            // Of equal spheres a figure shows one.
            [Surface { sphere, face }] => *id >= 0 && of(*sphere) == of(*id as u32) && face.is_none_or(is_face),
            _ => false,
        };
        count.places += 1;
        count.hits += u32::from(*id >= 0);
        count.faces += found.iter().filter(|surface| surface.face.is_some()).count();
        if is_right {
            continue;
        }
        let around = [[NEAR, 0.0], [-NEAR, 0.0], [0.0, NEAR], [0.0, -NEAR]];
        let is_close = around.iter().any(|[x, y]| at([place[0] + x, place[1] + y]) != found);
        count.close += u32::from(is_close);
        if !is_close {
            count.wrong.push(format!("{name}, {:?}: {place:?} is in {found:?}, and shows {id}", scene.camera.lens));
        }
    }
}

fn check(count: &Count) {
    let Count { places, close, joined, faces, wrong, .. } = count;
    println!(
        "{places} centres, {faces} on faces, {close} within {NEAR} of a line, {} wrong, {joined} lines joined",
        wrong.len()
    );
    assert!(
        wrong.is_empty() && *joined == 0,
        "{} wrong: {:#?}, {joined} joined",
        wrong.len(),
        &wrong[..wrong.len().min(8)]
    );
    assert!(*close < places / 1000, "{close} of {places}");
}

/// A renderer of ids and normals, certified on the CPU path.
fn renderer() -> (Renderer, Settings) {
    let aovs = vec![Aov::Normal];
    let settings = Settings { backend: Backend::Cpu, accuracy: Accuracy::Certified, aovs, ..Settings::default() };
    (Renderer::new(&settings).expect("the CPU path"), settings)
}

/// Lenses; the last lens shows a part of a scene.
fn lenses() -> [Lens; 4] {
    [
        Lens::Vfov { degrees: 40.0, distance: 1.0 },
        Lens::Orthographic { height: 5.0 },
        Lens::Intrinsics { fx: 90.0, fy: 120.0, cx: 30.0, cy: 50.5 },
        Lens::Vfov { degrees: 9.0, distance: 1.0 },
    ]
}

#[test]
fn figures_show_what_frames_show() {
    let ((mut renderer, settings), mut count) = (renderer(), Count::default());
    for case in 0..24_u64 {
        for at in [[0.0; 3], [1e6, -3e5, 2e5]] {
            for lens in lenses() {
                let (name, spheres) = hard(case, at);
                let name = format!("{name} {case}, {at:?}");
                compare(&name, &scene(spheres, at, lens), &mut renderer, &settings, &mut count);
            }
        }
    }
    check(&count);
}

/// The outline of a ball beside the axis is tilted: it reaches behind the middle of the ball.
#[test]
fn off_axis_figures_show_what_frames_show() {
    let ((mut renderer, settings), mut count) = (renderer(), Count::default());
    for case in [0_u64, 5, 11, 17, 23, 29] {
        let (name, spheres) = hard(case, [0.0; 3]);
        let mut scene = scene(spheres, [0.0; 3], Lens::Orthographic { height: 5.0 });
        scene.camera.look = Look::At(DVec3::new(14.0, -9.0, 0.0));
        let basis = scene.camera.basis().expect("a basis");
        let slope = DVec2::new(basis.e.dot(basis.u), -basis.e.dot(basis.v)) / basis.e.dot(basis.w);
        // Frames count principal points in 256ths of a pixel.
        let [cx, cy] = [48.0 + 40.0 * slope.x, 36.0 + 40.0 * slope.y].map(f64::round);
        scene.camera.lens = Lens::Intrinsics { fx: 40.0, fy: 40.0, cx, cy };
        compare(&format!("{name} {case}, beside the axis"), &scene, &mut renderer, &settings, &mut count);
    }
    assert!(count.hits > 1000, "{} hits", count.hits);
    check(&count);
}

#[test]
fn figures_of_cut_spheres_show_what_frames_show() {
    let ((mut renderer, settings), mut count) = (renderer(), Count::default());
    for case in 0..84_u64 {
        for lens in lenses() {
            let at = if case % 2 == 0 { [0.0; 3] } else { [1e6, -3e5, 2e5] };
            // The lattices touch in planes of these.
            let (name, mut spheres) = hard(case / 7, at);
            let planes = cut(case, at, &mut spheres);
            let name = format!("{name} {case}, {at:?}, {planes}");
            compare(&name, &scene(spheres, at, lens), &mut renderer, &settings, &mut count);
        }
    }
    assert!(count.faces > 10_000, "{} on faces", count.faces);
    check(&count);
}

#[test]
fn what_has_no_ellipses_is_refused() {
    let (_, spheres) = hard(0, [0.0; 3]);
    let mut inside = scene(spheres, [0.0; 3], Lens::Vfov { degrees: 40.0, distance: 1.0 });
    inside.camera.eye = inside.spheres.centers[0].into();
    let words = |scene: &Scene| {
        Figure::new(scene, FigureStyle::default(), None).err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert!(words(&inside).contains("across the plane of the eye"), "{}", words(&inside));
}

/// Three spheres in two groups; two of the spheres have one colour and cross.
fn three() -> Scene {
    let mut spheres = Spheres::default();
    for ([x, y, z], color) in [([-0.5, 0.0, 0.0], 0.9), ([0.5, 0.0, 0.0], 0.9), ([0.0, 2.0, 0.0], 0.2)] {
        spheres.push([x, y, z], 0.8, Some([color, 0.1, 0.1]));
    }
    scene(spheres, [0.0; 3], Lens::Orthographic { height: 8.0 })
}

fn attributes(svg: &str, tag: &str, name: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).expect("well-formed XML");
    let tags = document.descendants().filter(|node| node.has_tag_name(tag));
    tags.filter_map(|node| node.attribute(name).map(str::to_owned)).collect()
}

#[test]
fn paths_have_names_and_groups() {
    let value = |column: usize, id: u32| match column {
        0 => ["a<1>", "a<1>", "b"][id as usize].to_owned(),
        _ => format!("\"{id}\""),
    };
    let names = FigureNames { columns: vec!["Chain".into(), "atom name".into()], groups: 1, value: &value };
    let style = FigureStyle::default();
    let svg = |shade: Shade, names: &FigureNames<'_>| {
        Figure::new(&three(), FigureStyle { shade, ..style }, Some(names)).expect("a figure").svg(None)
    };
    let shown = svg(Shade::Headlight, &names);
    assert_eq!(attributes(&shown, "g", "data-Chain"), ["a<1>", "b"]);
    assert_eq!(attributes(&shown, "path", "id").len(), 3);
    assert_eq!(attributes(&shown, "path", "data-atom-name").iter().filter(|value| *value == "\"2\"").count(), 1);
    // Of one colour in one group, and without a line between them.
    let flat = svg(Shade::Flat, &names);
    assert_eq!(attributes(&flat, "path", "id"), ["s0", "s2"]);
    assert!(attributes(&flat, "radialGradient", "id").is_empty());
    let alone = svg(Shade::Flat, &FigureNames { groups: 0, ..names });
    assert_eq!(attributes(&alone, "path", "id"), ["s0", "s1", "s2"]);
    // Colours of a sphere from its middle to its outline: one list for each of two, one gradient for each of three.
    assert_eq!(attributes(&shown, "radialGradient", "id").len(), 2 + 3);
}

#[test]
fn gradients_are_the_light_of_a_headlight() {
    let style = FigureStyle::default();
    for own in [[1.0; 3], [0.5, 0.02, 0.9], [0.0; 3]] {
        let stops = paint::gradient(own, style.toning);
        for n in 0..1000 {
            let share = f64::from(n) / 1000.0;
            let k = stops.iter().position(|stop| stop.at > share).expect("a stop at 1");
            let [a, b] = [stops[k - 1], stops[k]];
            let shown = paint::lighted(own, (1.0 - share * share).sqrt(), style.toning);
            let along = (share - a.at) / (b.at - a.at);
            for (shown, (a, b)) in shown.iter().zip(a.color.iter().zip(&b.color)) {
                let level = f64::from(*a) + along * (f64::from(*b) - f64::from(*a));
                // Two levels by the choice of the stops, and one between the places that it looks at.
                assert!((level - f64::from(*shown)).abs() <= 3.0, "{own:?} at {share}: {level}, not {shown}");
            }
        }
        assert!(stops.len() < 32, "{} stops", stops.len());
    }
}

#[test]
fn cubic_curves_are_near_their_ellipses() {
    let mut rng = Rng(9);
    let mut most = 0.0_f64;
    for _ in 0..2000 {
        let a = 10.0_f64.powf(rng.between(-2.0, 4.0));
        let axes = [a, a * rng.unit()];
        let (from, way) = (rng.between(-3.0, 3.0), rng.between(-2.6, 2.6));
        let at = |angle: f64| DVec2::new(axes[0] * angle.cos(), axes[1] * angle.sin());
        let mut start = at(from);
        for [p, q, end] in pdf::cubics(axes, from, way) {
            for n in 1..=16 {
                let t = f64::from(n) / 16.0;
                let s = 1.0 - t;
                let x = s * s * s * start + 3.0 * s * s * t * p + 3.0 * s * t * t * q + t * t * t * end;
                // The point of the ellipse at the same angle is not the nearest one.
                let on = at((x.y / axes[1]).atan2(x.x / axes[0]));
                most = most.max(x.distance(on));
            }
            start = end;
        }
        assert!(start.distance(at(from + way)) < 1e-9 * a.max(1.0));
    }
    println!("cubic curves within {most}");
    assert!(most < 5.1e-5, "{most}");
}

#[test]
fn files_are_whole() {
    let outline = Some(Outline::default());
    let figure = Figure::new(&three(), FigureStyle { outline, dpi: Some(300), ..FigureStyle::default() }, None);
    let figure = figure.expect("a figure");
    let svg = figure.svg(None);
    // 96 pixels of 300 in an inch of 25.4 mm.
    assert_eq!(attributes(&svg, "svg", "width"), ["8.128mm"]);
    assert_eq!(attributes(&svg, "path", "id").last().map(String::as_str), Some("lines"));
    let pdf = figure.pdf(None);
    assert!(pdf.starts_with(b"%PDF-1.7") && pdf.ends_with(b"%%EOF"), "{} bytes", pdf.len());
    let text = String::from_utf8_lossy(&pdf);
    assert!(text.contains("/MediaBox [0 0 23.04 17.28]"), "{text}");
    let transparent = Figure::new(&three(), FigureStyle { transparent: true, ..FigureStyle::default() }, None);
    assert!(attributes(&transparent.expect("a figure").svg(None), "rect", "fill").is_empty());
}
