//! The promise of planes that cut spheres: every pixel shows what exact arithmetic decides, in every buffer, on every backend.
//!
//! Gold standard: the judge over all spheres, whose decisions about planes its own tests compare with whole numbers. Tolerances: of
//! certified depths the promised one, of normals 1e-3 rad.

use crate::adapter::{cpu, renderers};
use crate::amount::amount;
use crate::bits::{Bits, differing};
use crate::cloud::cloud;
use crate::oblique::{self, vfov};
use crate::rng::Rng;
use crate::truth::Digits;
use glam::DVec3;
use halfline::camera::{Camera, Curve, Lens};
use halfline::exact::{Judge, Root, Toward};
use halfline::frame::{Aov, Frame};
use halfline::scene::{CutPlane, ImagePlane, Light, LightSource, Lighting, Scene, Sky, Spheres};
use halfline::settings::{Accuracy, Settings, Tolerance};
use halfline::shade::Shade;
use halfline::window::Window;
use serde::Deserialize;

const SIZE: [u32; 2] = [49, 35];

/// A fisheye with rays on all sides.
fn fisheye() -> Lens {
    Lens::Curved { curve: Curve::Fisheye { k: [0.0; 4] }, fx: 14.0, fy: 14.0, cx: 24.5, cy: 17.5 }
}

/// A plane with this normal through a point.
fn through(normal: [f64; 3], point: [f64; 3]) -> CutPlane {
    CutPlane { normal, distance: (0..3).map(|k| normal[k] * point[k]).sum() }
}

/// Planes that are hard: toward the eye, along the view, through the eye, a slab, nearly parallel ones, through a centre, at a tangent.
fn planes(spheres: &Spheres, eye: [f64; 3], rng: &mut Rng) -> Vec<(&'static str, Vec<CutPlane>)> {
    let middle = spheres.middle().to_array();
    let toward: [f64; 3] = std::array::from_fn(|k| eye[k] - middle[k]);
    let side = [toward[1], -toward[0], 0.0];
    let (center, radius) = (spheres.centers[3], spheres.radii[3]);
    let back = toward.map(|x| -x);
    let tilted = |n: usize| toward.map(|x| x + 1e-9 * n as f64);
    vec![
        ("toward the eye", vec![through(toward, middle)]),
        ("along the view", vec![through(side, middle)]),
        ("through the eye", vec![through(rng.cube(), eye)]),
        ("a slab", vec![through(toward, middle), through(back, center)]),
        ("nearly parallel", (0..40).map(|n| through(tilted(n), middle)).collect()),
        ("tangent", vec![CutPlane { normal: [0.0, 0.0, 1.0], distance: center[2] + radius }]),
        ("drawn", (0..3).map(|_| through(rng.cube(), spheres.centers[rng.below(spheres.len())])).collect()),
    ]
}

/// Spheres of a cloud, with nested ones around some of their centres, and equal ones.
fn spheres(seed: u64, at: [f64; 3]) -> Spheres {
    let mut all = cloud(0xc0 + seed, 150, at, 4.0, 0.5);
    for n in 0..20 {
        let (center, radius) = (all.centers[n], all.radii[n]);
        all.push(center, radius * (0.5 + 0.1 * (n % 6) as f64), None);
    }
    all
}

/// The pixels of a frame that differ from the judge's, in words, and the number of faces.
fn wrong(frame: &Frame, judge: &Judge) -> (Vec<String>, u64) {
    let [depth, distance] = [Aov::Depth, Aov::Distance].map(|aov| frame.f64(aov).expect("a buffer"));
    let normals = frame.f32(Aov::Normal).expect("normals");
    let (mut all, mut faces) = (Vec::new(), 0);
    for (pixel, id) in frame.ids().iter().enumerate() {
        let (i, j) = (pixel as u32 / SIZE[0], pixel as u32 % SIZE[0]);
        let truth = judge.pixel(i, j);
        faces += u64::from(truth.is_some_and(|truth| truth.root == Root::Face));
        let is_same = truth.map_or(*id == -1 && depth[pixel] == f64::INFINITY, |truth| {
            // Depths through a fisheye may be near 0, whose distances are not.
            let near = |found: f64, exact: f64| (found - exact).abs() <= 2f64.powi(-20) * truth.distance;
            let normal = [0, 1, 2].map(|k| f64::from(normals[3 * pixel + k]));
            let turn: f64 = (0..3).map(|k| (normal[k] - truth.normal[k]).powi(2)).sum::<f64>().sqrt();
            let is_near = near(depth[pixel], truth.depth) && near(distance[pixel], truth.distance);
            *id == truth.id as i32 && is_near && turn < 1e-3
        });
        if !is_same {
            all.push(format!("row {i}, column {j}: {id} at {} is {truth:?}", depth[pixel]));
        }
    }
    (all, faces)
}

#[test]
fn pixels_of_cut_spheres_are_those_of_the_judge() {
    let aovs = vec![Aov::Id, Aov::Depth, Aov::Distance, Aov::Normal, Aov::Position, Aov::Color];
    let settings = Settings { aovs, shade: Shade::Headlight, ..Settings::default() };
    let seeds = amount("clouds with cuts", [1, 1, 20]);
    let (mut pixels, mut faces) = (0_u64, 0_u64);
    for (seed, at) in (0..seeds as u64).flat_map(|seed| [(seed, [0.0; 3]), (seed, [1e8, -3e7, 2e7])]) {
        let mut rng = Rng::new(0xc07 + seed);
        for (lens, eye) in [
            (vfov(45.0), [1.0, 2.0, 9.0]),
            (Lens::Orthographic { height: 5.0 }, [2.0, -1.0, 9.0]),
            (vfov(80.0), [0.2, 0.1, 0.3]),
            (vfov(165.0), [0.5, 1.0, 3.0]),
            (fisheye(), [0.2, 0.1, 0.3]),
        ] {
            let (whole, eye) = (spheres(seed, at), std::array::from_fn(|k| eye[k] + at[k]));
            for (name, planes) in planes(&whole, eye, &mut rng) {
                let mut cut = whole.clone();
                cut.cut(&planes, None).expect("planes");
                let scene = oblique::scene(SIZE, eye, at, lens, cut);
                let judge = Judge::new(&scene).expect("a scene");
                for (backend, mut renderer) in renderers() {
                    let frame = renderer.render(&scene, &settings).expect("a frame");
                    let (wrong, own) = wrong(&frame, &judge);
                    assert!(
                        wrong.is_empty(),
                        "{seed} {at:?} {name} {lens:?} {backend:?}: {:#?}",
                        &wrong[..wrong.len().min(3)]
                    );
                    (pixels, faces) = (pixels + frame.ids().len() as u64, faces + own);
                    // A part has the bits of the whole, though its pixels are decided among others.
                    let window = Window { x0: 17, y0: 11, x1: 30, y1: 23 };
                    let part = renderer.render(&scene, &Settings { window: Some(window), ..settings.clone() });
                    let differing = differing(&part.expect("a part"), &frame.cut(window));
                    assert!(differing.is_empty(), "{seed} {name} {lens:?} {backend:?}: {differing:?}");
                }
            }
        }
    }
    println!("{pixels} pixels, {faces} of them faces");
    assert!(faces > pixels / 10, "{faces} faces of {pixels}");
}

#[derive(Deserialize)]
struct Case {
    eye: [Digits; 3],
    viewport: [Digits; 2],
    parallel: bool,
    spheres: Vec<[Digits; 4]>,
    planes: Vec<[Digits; 4]>,
    spared: Vec<bool>,
    /// Of each pixel the letter of its sphere, as a capital on a face; `.` for none.
    rows: Vec<String>,
}

impl Case {
    fn scene(&self) -> Scene {
        let mut spheres = Spheres::default();
        for sphere in &self.spheres {
            let [x, y, z, radius] = sphere.each_ref().map(Digits::number);
            spheres.push([x, y, z], radius, None);
        }
        let plane = |plane: &[Digits; 4]| {
            let [x, y, z, distance] = plane.each_ref().map(Digits::number);
            CutPlane { normal: [x, y, z], distance }
        };
        let planes: Vec<CutPlane> = self.planes.iter().map(plane).collect();
        let may: Vec<bool> = self.spared.iter().map(|spared| !spared).collect();
        spheres.cut(&planes, Some(&may)).expect("planes");
        let [vw, vh] = self.viewport.each_ref().map(Digits::number);
        let lens =
            if self.parallel { Lens::Orthographic { height: vh } } else { Lens::Viewport { vw, vh, distance: 1.0 } };
        let camera = Camera { eye: self.eye.each_ref().map(Digits::number).into(), lens, ..Camera::CANONICAL };
        let image = ImagePlane { width: 9, height: 7, ..ImagePlane::default() };
        Scene { camera, image, spheres, lighting: Lighting::default() }
    }
}

/// The fixture is made by `python3 tests/truth/cuts.py`, in fractions.
#[test]
fn first_hits_of_cut_spheres_are_those_of_fractions() {
    let cases: Vec<Case> = serde_json::from_str(include_str!("../truth/cuts.json")).expect("the fixture");
    let (mut faces, mut wrong) = (0, Vec::new());
    let mut renderers = renderers();
    for (n, case) in cases.iter().enumerate() {
        let scene = case.scene();
        let judge = Judge::new(&scene).expect("a scene");
        let letters: Vec<char> = case.rows.iter().flat_map(|row| row.chars()).collect();
        let id = |letter: char| if letter == '.' { -1 } else { letter.to_ascii_lowercase() as i32 - 'a' as i32 };
        for (backend, renderer) in &mut renderers {
            for accuracy in [Accuracy::Certified, Accuracy::Exact] {
                let settings = Settings { accuracy, aovs: vec![Aov::Id], ..Settings::default() };
                let frame = renderer.render(&scene, &settings).expect("a frame");
                for (pixel, (found, letter)) in frame.ids().iter().zip(&letters).enumerate() {
                    if *found != id(*letter) {
                        wrong.push(format!(
                            "scene {n}, pixel {pixel}, {backend:?}, {accuracy:?}: {found} is not {letter}"
                        ));
                    }
                }
            }
        }
        for (pixel, letter) in (0..).zip(&letters) {
            let is_face = judge.pixel(pixel / 9, pixel % 9).is_some_and(|truth| truth.root == Root::Face);
            if is_face != letter.is_ascii_uppercase() {
                wrong.push(format!("scene {n}, pixel {pixel}: {letter} of the judge is on a face: {is_face}"));
            }
            faces += u32::from(is_face);
        }
    }
    assert!(faces > 1000 && cases.len() == 200, "{faces} faces of {} scenes", cases.len());
    assert!(wrong.is_empty(), "{} are wrong: {:#?}", wrong.len(), &wrong[..wrong.len().min(5)]);
}

/// Cases in which bounds that forget a part of the rule are wrong: an eye in a cut sphere beside a smaller one ahead, a plane next to
/// underflow from the eye, a normal whose square underflows, a tolerance and bounds that f64 does not keep.
#[test]
fn cut_spheres_are_exact_at_the_extremes() {
    let scene = |eye: [f64; 3], plane: CutPlane, balls: &[([f64; 3], f64)]| {
        let mut cut = Spheres::default();
        balls.iter().for_each(|(center, radius)| cut.push(*center, *radius, None));
        cut.cut(&[plane], None).expect("a plane");
        let camera = Camera { eye: eye.into(), lens: vfov(40.0), ..Camera::CANONICAL };
        let image = ImagePlane { width: SIZE[0], height: SIZE[1], ..ImagePlane::default() };
        Scene { camera, image, spheres: cut, lighting: Lighting::default() }
    };
    let up = |distance: f64| CutPlane { normal: [0.0, 0.0, 1.0], distance };
    let aovs = vec![Aov::Id, Aov::Depth, Aov::Distance, Aov::Normal];
    let settings = Settings { aovs: aovs.clone(), ..Settings::default() };
    let bounded = Settings { aovs: [&aovs[..], &[Aov::Bound]].concat(), ..settings.clone() };
    let sharp = Settings {
        tolerance: Some(Tolerance::new(1e-15).expect("a tolerance")),
        accuracy: Accuracy::Certified,
        ..settings.clone()
    };
    for (name, scene) in [
        ("an eye in a cut sphere", scene([0.0; 3], up(-1e-22), &[([0.0; 3], 1.0), ([0.0, 0.0, -3e-20], 1e-20)])),
        ("a plane next to underflow", scene([0.0, 0.0, 5e-324], up(0.0), &[([0.0; 3], 4.0), ([0.0, 0.0, -2.0], 0.5)])),
        ("an eye on the plane", scene([0.0; 3], up(0.0), &[([0.0; 3], 4.0), ([0.0, 0.0, -2.0], 0.5)])),
        (
            "a short normal",
            scene(
                [0.0, 0.0, 9.0],
                CutPlane { normal: [1e-170, 1e-170, 0.0], distance: 1e-171 },
                &[([0.0; 3], 2.0), ([1.0, 0.0, 1.0], 1.5)],
            ),
        ),
        ("equal spheres", scene([0.0, 0.0, 9.0], up(0.25), &[([0.0; 3], 2.0), ([0.0; 3], 2.0), ([0.0; 3], 1.0)])),
        (
            "numbers of f64",
            scene([2.0, 3.0, 7.0], CutPlane { normal: [1.5, 0.25, -0.5], distance: 0.0 }, &[([1.0, 2.0, 0.0], 3.0)]),
        ),
    ] {
        let judge = Judge::new(&scene).expect("a scene");
        for (backend, mut renderer) in renderers() {
            for settings in [&settings, &bounded, &sharp] {
                let frame = renderer.render(&scene, settings).expect("a frame");
                let (wrong, _) = wrong(&frame, &judge);
                assert!(wrong.is_empty(), "{name} {backend:?}: {} {:#?}", wrong.len(), &wrong[..wrong.len().min(3)]);
                let distance = frame.f64(Aov::Distance).expect("distances");
                let allowed = |pixel: usize, exact: f64| match frame.f64(Aov::Bound) {
                    Some(bound) => bound[pixel],
                    None => settings.tolerance.unwrap_or_default().relative() * exact,
                };
                for (pixel, found) in distance.iter().enumerate().filter(|(_, found)| found.is_finite()) {
                    let truth = judge.pixel(pixel as u32 / SIZE[0], pixel as u32 % SIZE[0]).expect("a hit");
                    let off = (found - truth.distance).abs();
                    assert!(off <= allowed(pixel, truth.distance), "{name} {backend:?} {pixel}: {off:e} of {found}");
                }
            }
        }
    }
}

/// A scene of flat colours, whose spheres a plane toward the eye and a slanted one cut.
fn halved(lens: Lens) -> Scene {
    let mut cut = spheres(3, [0.0; 3]);
    let planes = [through([1.0, 2.0, 9.0], [0.0; 3]), through([0.6, -0.8, 0.1], [1.0, 0.0, 0.0])];
    cut.cut(&planes, None).expect("planes");
    oblique::scene(SIZE, [1.0, 2.0, 9.0], [0.0; 3], lens, cut)
}

/// Colours under a sun without shadows follow the normals of faces, and what is drawn over colours knows their depths.
#[test]
fn pictures_of_cut_spheres_have_the_normals_and_depths_of_faces() {
    for lens in [vfov(45.0), Lens::Orthographic { height: 5.0 }] {
        let mut scene = halved(lens);
        let judge = Judge::new(&scene).expect("a scene");
        let sun = DVec3::new(0.3, 0.5, 1.0).normalize();
        let source = LightSource::Direction(sun);
        scene.lighting =
            Lighting { lights: vec![Light { source, color: [1.0; 3], intensity: 1.0 }], ..Lighting::default() };
        let plain = Settings { aovs: vec![Aov::Color, Aov::Depth], ..Settings::default() };
        for (backend, mut renderer) in renderers() {
            let frame = renderer.render(&scene, &plain).expect("a frame");
            let color = frame.f32(Aov::Color).expect("colours");
            let (mut factors, mut faces) = (Vec::new(), 0);
            for (pixel, id) in frame.ids().iter().enumerate().filter(|(_, id)| **id >= 0) {
                let truth = judge.pixel(pixel as u32 / SIZE[0], pixel as u32 % SIZE[0]).expect("a hit");
                let own = scene.spheres.colors.as_ref().expect("colours")[*id as usize];
                let cosine = DVec3::from_array(truth.normal).dot(sun).max(0.0);
                let found = f64::from(color[3 * pixel]);
                if cosine > 0.05 {
                    factors.push(found / (f64::from(own[0]) * cosine));
                    faces += u32::from(truth.root == Root::Face);
                } else {
                    assert!(found <= 0.06, "{backend:?}: a light from behind: {found}");
                }
            }
            let [least, most] = factors.iter().fold([f64::INFINITY, 0.0], |[a, b], x| [a.min(*x), f64::max(b, *x)]);
            assert!(
                most - least < 1e-5 * most && faces > 150,
                "{backend:?} {lens:?}: {least} to {most}, {faces} faces"
            );
            // A cue fades colours toward the background by the depth alone.
            let dark = Scene { lighting: Lighting::default(), ..scene.clone() };
            let flat = Settings { shade: Shade::Flat, ..plain.clone() };
            let faded = Settings { depth_cue: true, depth_cue_strength: Some(0.8), ..flat.clone() };
            let [bare, cued] = [&flat, &faded].map(|settings| renderer.render(&dark, settings).expect("a frame"));
            let [bare, cued] = [&bare, &cued].map(|frame| frame.f32(Aov::Color).expect("colours").to_vec());
            let depth = frame.f64(Aov::Depth).expect("depths");
            let share = |pixel: usize| {
                let [from, to, end] = [bare[3 * pixel], cued[3 * pixel], scene.image.background[0]].map(f64::from);
                ((from - end).abs() > 0.2).then(|| (depth[pixel], (to - end) / (from - end)))
            };
            let mut shares: Vec<(f64, f64)> =
                (0..frame.ids().len()).filter(|n| frame.ids()[*n] >= 0).filter_map(share).collect();
            shares.sort_by(|a, b| a.0.total_cmp(&b.0));
            let fades = shares.windows(2).all(|two| two[1].1 <= two[0].1 + 1e-5);
            assert!(
                fades && shares.len() > 200 && shares[0].1 - shares[shares.len() - 1].1 > 0.1,
                "{backend:?} {lens:?}: {} from {:?} to {:?}",
                shares.len(),
                shares.first(),
                shares.last()
            );
        }
    }
}

/// Faces of one plane have lines between them, and their edges lines before the rest of their spheres, under every shading.
#[test]
fn faces_have_lines_around_them() {
    let mut pair = Spheres::default();
    for (x, radius) in [(-1.0, 1.5), (1.0, 1.5), (-1.0, 0.6)] {
        pair.push([x, 0.0, 0.0], radius, Some([0.5; 3]));
    }
    pair.cut(&[through([0.0, 0.0, 1.0], [0.0; 3])], None).expect("planes");
    let mut scene = oblique::scene([98, 70], [0.0, 0.0, 9.0], [0.0; 3], Lens::Orthographic { height: 5.0 }, pair);
    scene.image.background = [1.0; 3];
    let bare = Settings { aovs: vec![Aov::Color], shade: Shade::Headlight, ..Settings::default() };
    let lined = Settings { silhouette: true, ..bare.clone() };
    for (backend, mut renderer) in renderers() {
        let [bare, lined] = [&bare, &lined].map(|settings| renderer.render(&scene, settings).expect("a frame"));
        let colors = [&bare, &lined].map(|frame| frame.f32(Aov::Color).expect("colours"));
        // Rows through the middle: x is (column - 48.5) / 14.
        let is_dark = |column: usize| {
            let [bare, lined] = colors.map(|colors| colors[3 * (35 * 98 + column)]);
            lined < 0.5 * bare
        };
        let dark = |x: f64| {
            let column = (14.0 * x + 48.5).round() as usize;
            (column - 1..=column + 1).any(is_dark)
        };
        // Between both faces, around the nested one, and around all.
        for x in [-2.5, -1.6, -0.4, 2.5] {
            assert!(dark(x), "{backend:?}: no line at {x}");
        }
        let between = bare.ids()[35 * 98..36 * 98].windows(2).position(|two| two[0] == 0 && two[1] == 1);
        assert!(between.is_some_and(|column| (column..column + 2).any(is_dark)), "{backend:?}: {between:?}");
        assert!(![-2.0, -1.0, 1.0, 1.8].map(dark).contains(&true), "{backend:?}: a line within a face");
    }
}

/// The samples of a pixel see the cut as its centre does: where all around is one sphere, its colour is the sphere's.
#[test]
fn samples_of_cut_spheres_are_cut() {
    let scene = halved(vfov(45.0));
    let settings = Settings { aovs: vec![Aov::Color], shade: Shade::Flat, samples: 9, ..Settings::default() };
    for (backend, mut renderer) in renderers() {
        let frame = renderer.render(&scene, &settings).expect("a frame");
        let (ids, color) = (frame.ids(), frame.f32(Aov::Color).expect("colours"));
        let (width, mut inner) = (SIZE[0] as usize, 0);
        for (x, y) in (1..SIZE[1] as usize - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y))) {
            let id = ids[y * width + x];
            let around = (y - 1..y + 2).flat_map(|y| ids[y * width + x - 1..y * width + x + 2].iter());
            if id < 0 || !around.into_iter().all(|other| *other == id) {
                continue;
            }
            let own = scene.spheres.colors.as_ref().expect("colours")[id as usize];
            let found = &color[3 * (y * width + x)..][..3];
            let is_own = found.iter().zip(own).all(|(found, own)| (found - own).abs() < 1e-5);
            inner += u32::from(is_own);
            // Another sphere may show between the centres, seldom.
            assert!(
                is_own || found.iter().zip(own).all(|(found, own)| (found - own).abs() < 0.6),
                "{backend:?} {x} {y}"
            );
        }
        assert!(inner > 100, "{backend:?}: {inner}");
    }
}

/// Lights and sky at the hits of cut scenes: shadows of single rays agree with the judge, and all others with a frame whose every ray
/// the judge decides. With spared spheres beyond planes, from far away, from inside, by parallel rays.
#[test]
fn light_at_cut_spheres_is_exact() {
    let aovs = vec![Aov::Id, Aov::Shadow, Aov::Occlusion, Aov::Color, Aov::Certainty];
    let settings = Settings { aovs, accuracy: Accuracy::Certified, ..Settings::default() };
    let seeds = amount("lit clouds with cuts", [1, 1, 8]);
    let (mut rays, mut hidden, mut turn) = (0_u64, 0_u64, 0);
    for (seed, at) in (0..seeds as u64).flat_map(|seed| [(seed, [0.0; 3]), (seed, [1e8, -3e7, 2e7])]) {
        let mut rng = Rng::new(0xc17 + seed);
        for (lens, eye) in [
            (vfov(45.0), [1.0, 2.0, 9.0]),
            (Lens::Orthographic { height: 5.0 }, [2.0, -1.0, 9.0]),
            (vfov(80.0), [0.2, 0.1, 0.3]),
            (fisheye(), [0.2, 0.1, 0.3]),
        ] {
            let (whole, eye) = (spheres(seed, at), std::array::from_fn(|k| eye[k] + at[k]));
            // Every second family with spared spheres, in the next scene the others.
            for (name, planes) in planes(&whole, eye, &mut rng) {
                turn += 1;
                let may = (turn % 2 > 0).then(|| (0..whole.len()).map(|n| n % 7 != 0).collect::<Vec<bool>>());
                let mut cut = whole.clone();
                cut.cut(&planes, may.as_deref()).expect("planes");
                let mut scene = oblique::scene(SIZE, eye, at, lens, cut);
                let place = DVec3::from_array(std::array::from_fn(|k| at[k] + [3.0, 4.0, 1.0][k]));
                let sources = [
                    LightSource::Direction(DVec3::new(0.3, 0.5, 1.0)),
                    LightSource::Point(place),
                    LightSource::Direction(planes[0].normal.into()),
                ];
                let lights = sources.map(Light::white).to_vec();
                let sky = Some(Sky { rays: 4, ..Sky::AT_CENTERS });
                scene.lighting = Lighting { lights, shadows: true, sky, ..Lighting::default() };
                let judge = Judge::new(&scene).expect("a scene");
                let (renderer, what) = (&mut cpu(), format!("{seed} {at:?} {name} {lens:?} {}", may.is_some()));
                let found = renderer.render(&scene, &settings).expect("a frame");
                // A ray that the judge decides takes a thousand times as long: only rays of a part.
                let window = Window { x0: 20, y0: 13, x1: 32, y1: 19 };
                let exact = Settings { accuracy: Accuracy::Exact, window: Some(window), ..settings.clone() };
                let exact = renderer.render(&scene, &exact).expect("a frame");
                for aov in [Aov::Id, Aov::Shadow, Aov::Occlusion] {
                    assert_eq!(found.cut(window).bits(aov), exact.bits(aov), "{what}: {aov:?}");
                }
                // Suns alone go down the tree together, without f64 for each ray.
                let mut suns = scene.clone();
                suns.lighting.lights.remove(1);
                let alone = Settings { aovs: vec![Aov::Id, Aov::Shadow], ..settings.clone() };
                let streamed = renderer.render(&suns, &alone).expect("a frame");
                let streamed = streamed.f32(Aov::Shadow).expect("shadows").chunks_exact(2);
                let one_by_one =
                    found.f32(Aov::Shadow).expect("shadows").chunks_exact(3).map(|three| [three[0], three[2]]);
                for (pixel, (two, expected)) in streamed.zip(one_by_one).enumerate() {
                    assert_eq!(two, expected, "{what}: suns at pixel {pixel}");
                }
                let toward = sources.map(|source| match source {
                    LightSource::Point(place) => Toward::Point(place.to_array()),
                    LightSource::Direction(direction) => Toward::Direction(direction.to_array()),
                    _ => unreachable!("without a size"),
                });
                let shadow = found.f32(Aov::Shadow).expect("shadows");
                for pixel in (0..found.ids().len()).step_by(61) {
                    let (i, j) = (pixel as u32 / SIZE[0], pixel as u32 % SIZE[0]);
                    let Some(expected) = judge.hidden(i, j, &toward) else { continue };
                    for (n, is_hidden) in expected.into_iter().enumerate() {
                        assert_eq!(shadow[sources.len() * pixel + n] > 0.5, is_hidden, "{what}: {i}, {j}, light {n}");
                        (rays, hidden) = (rays + 1, hidden + u64::from(is_hidden));
                    }
                }
            }
        }
    }
    println!("{rays} rays, {hidden} of them hidden");
    assert!(hidden > rays / 10 && hidden < rays / 10 * 9, "{hidden} of {rays}");
}

/// The light of a picture of more pixels, whose rays toward the sky go down the tree together, has the bits of one whose rays the judge
/// decides.
#[test]
fn pictures_of_cut_spheres_have_the_light_of_the_judge() {
    let (window, mut rng) = (Window { x0: 140, y0: 90, x1: 150, y1: 96 }, Rng::new(0xc47));
    for (n, (lens, eye)) in
        [(vfov(45.0), [1.0, 2.0, 9.0]), (Lens::Orthographic { height: 5.0 }, [2.0, -1.0, 9.0])].into_iter().enumerate()
    {
        let whole = spheres(6, [0.0; 3]);
        for (name, planes) in planes(&whole, eye, &mut rng).into_iter().filter(|(name, _)| *name != "nearly parallel") {
            let mut cut = whole.clone();
            let may: Option<Vec<bool>> = (n > 0).then(|| (0..cut.len()).map(|n| n % 7 != 0).collect());
            cut.cut(&planes, may.as_deref()).expect("planes");
            let mut scene = oblique::scene([300, 200], eye, [0.0; 3], lens, cut);
            let lights = vec![Light::white(LightSource::Direction(DVec3::new(0.3, 0.5, 1.0)))];
            scene.lighting = Lighting { lights, shadows: true, sky: Some(Sky::AT_CENTERS), ..Lighting::default() };
            let settings = Settings { aovs: vec![Aov::Color], accuracy: Accuracy::Certified, ..Settings::default() };
            let found = cpu().render(&scene, &settings).expect("a picture").cut(window);
            let exact = Settings { accuracy: Accuracy::Exact, window: Some(window), ..settings };
            let exact = cpu().render(&scene, &exact).expect("a picture");
            assert_eq!(found.bits(Aov::Color), exact.bits(Aov::Color), "{name} {lens:?}");
        }
    }
}

/// Translucent spheres count once for a ray, at their surface or at their face, in the order of the judge.
#[test]
fn layers_of_cut_spheres_are_in_order() {
    let (mut rng, mut faces) = (Rng::new(0xc37), 0);
    for (lens, eye, at) in [
        (vfov(45.0), [1.0, 2.0, 9.0], [0.0; 3]),
        (Lens::Orthographic { height: 5.0 }, [2.0, -1.0, 9.0], [0.0; 3]),
        (vfov(80.0), [1e8 + 0.2, 0.1, 0.3], [1e8, 0.0, 0.0]),
        (fisheye(), [0.2, 0.1, 0.3], [0.0; 3]),
    ] {
        let whole = spheres(5, at);
        for (name, planes) in planes(&whole, eye, &mut rng) {
            let mut cut = whole.clone();
            let opacities = (0..cut.len()).map(|n| if n % 3 > 0 { 0.2 + 0.1 * (n % 6) as f32 } else { 1.0 });
            cut.opacities = Some(opacities.collect::<Vec<f32>>().into());
            let may: Vec<bool> = (0..cut.len()).map(|n| n % 11 > 0).collect();
            cut.cut(&planes, Some(&may)).expect("planes");
            let scene = oblique::scene(SIZE, eye, at, lens, cut);
            let judge = Judge::new(&scene).expect("a scene");
            let settings = Settings { aovs: vec![Aov::Color], shade: Shade::Flat, layers: 4, ..Settings::default() };
            let frame = cpu().render(&scene, &settings).expect("a picture");
            let color = frame.f32(Aov::Color).expect("colours");
            let own = scene.spheres.colors.as_ref().expect("colours");
            for pixel in (0..frame.ids().len()).step_by(7) {
                let (i, j) = (pixel as u32 / SIZE[0], pixel as u32 % SIZE[0]);
                let (mut open, mut hits): (Vec<u32>, Vec<u32>) = ((0..whole.len() as u32).collect(), Vec::new());
                while let Some(truth) = judge.among(i, j, &open) {
                    faces += u32::from(truth.root == Root::Face && !hits.is_empty());
                    hits.push(truth.id);
                    if scene.spheres.opacity(truth.id) == 1.0 {
                        break;
                    }
                    open.retain(|id| *id != truth.id);
                }
                let back = hits.last().filter(|id| scene.spheres.opacity(**id) == 1.0);
                let mut expected = back.map_or(scene.image.background, |id| own[*id as usize]);
                let through = hits.iter().filter(|id| scene.spheres.opacity(**id) < 1.0).take(4).collect::<Vec<_>>();
                for id in through.into_iter().rev() {
                    let opacity = scene.spheres.opacity(*id);
                    expected.iter_mut().zip(own[*id as usize]).for_each(|(c, over)| *c += opacity * (over - *c));
                }
                let found = &color[3 * pixel..][..3];
                assert!(
                    found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-5),
                    "{name} {lens:?} {i}, {j}: {found:?} is not {expected:?} of {hits:?}"
                );
            }
        }
    }
    assert!(faces > 500, "{faces}");
}

/// A picture that would take a cut sphere for a whole one is refused.
#[test]
fn what_takes_spheres_for_whole_is_refused() {
    let mut cut = spheres(1, [0.0; 3]);
    cut.cut(&[through([0.0, 0.0, 1.0], [0.0; 3])], None).expect("a plane");
    let scene = oblique::scene(SIZE, [0.0, 0.0, 9.0], [0.0; 3], vfov(40.0), cut);
    let plain = Settings { aovs: vec![Aov::Color], ..Settings::default() };
    for (backend, mut renderer) in renderers() {
        renderer.render(&scene, &plain).expect("a picture");
        let fast = Settings { accuracy: Accuracy::Fast, ..plain.clone() };
        let mut fisheye_scene = scene.clone();
        fisheye_scene.camera.lens = fisheye();
        for scene in [&scene, &fisheye_scene] {
            let error = renderer.render(scene, &fast).map(drop).expect_err("fast").to_string();
            assert!(error.contains("planes cut some spheres"), "{backend:?}: {error}");
        }
    }
}
