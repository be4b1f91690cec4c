//! The judge compared with answers of a thousand digits, computed in Python by the lecture's formulas.
//!
//! The fixture is made by `python3 -m pip install mpmath==1.3.0 && python3 tests/truth/make.py`, which shares neither
//! code nor algebra with `src/exact`. Where a thousand digits do not suffice, the answers are known by construction.

use crate::adapter::cpu;
use crate::bits::Bits as _;
use halfline::camera::{Camera, Lens, Look};
use halfline::exact::{Judge, Root, Toward, Truth, judge_ray};
use halfline::frame::Aov;
use halfline::scene::{ImagePlane, Light, LightSource, Scene, Spheres};
use halfline::settings::{Accuracy, Settings};
use serde::Deserialize;

/// Hexadecimal digits of an f64's bits.
#[derive(Deserialize)]
#[serde(try_from = "String")]
pub(crate) struct Digits(f64);

impl TryFrom<String> for Digits {
    type Error = std::num::ParseIntError;
    fn try_from(digits: String) -> Result<Self, Self::Error> {
        u64::from_str_radix(&digits, 16).map(|bits| Self(f64::from_bits(bits)))
    }
}

impl Digits {
    pub(crate) fn number(&self) -> f64 {
        self.0
    }
}

#[derive(Deserialize)]
struct Case {
    name: String,
    eye: [Digits; 3],
    at: Option<[Digits; 3]>,
    view: Option<[Digits; 3]>,
    up: [Digits; 3],
    viewport: [Digits; 2],
    distance: Digits,
    size: [u32; 2],
    spheres: Vec<[Digits; 4]>,
    pixels: Vec<Pixel>,
    #[serde(default)]
    lights: Vec<Lamp>,
    /// Of balls.json: centre and radius of a light.
    ball: Option<[Digits; 4]>,
}

/// A light of lights.json.
#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Lamp {
    Direction([Digits; 3]),
    Position([Digits; 3]),
}

#[derive(Deserialize)]
struct Pixel {
    i: u32,
    j: u32,
    id: i64,
    #[serde(flatten)]
    answer: Option<Answer>,
    /// Whether each light is hidden.
    #[serde(default)]
    hidden: Vec<bool>,
    /// The share of the ball that is hidden.
    share: Option<f64>,
}

/// Decimal numbers with far more digits than f64 holds; t has 40, and `tail` is t minus the nearest f64.
#[derive(Deserialize)]
struct Answer {
    root: String,
    tangent: bool,
    t: String,
    tail: String,
    distance: String,
    depth: String,
    normal: [String; 3],
    position: [String; 3],
}

fn vector(a: &[Digits; 3]) -> [f64; 3] {
    a.each_ref().map(|x| x.0)
}

fn cases() -> Vec<Case> {
    serde_json::from_str(include_str!("../truth/cases.json")).expect("the fixture")
}

impl Case {
    fn scene(&self) -> Scene {
        let look = match (&self.at, &self.view) {
            (Some(at), None) => Look::At(vector(at).into()),
            (None, Some(view)) => Look::View(vector(view).into()),
            _ => panic!("{}: either at or view", self.name),
        };
        let [vw, vh, distance] = [self.viewport[0].0, self.viewport[1].0, self.distance.0];
        let lens = match distance.is_infinite() {
            true => Lens::Orthographic { height: vh },
            false => Lens::Viewport { vw, vh, distance },
        };
        let mut spheres = Spheres::default();
        for [x, y, z, r] in &self.spheres {
            spheres.push([x.0, y.0, z.0], r.0, None);
        }
        Scene {
            camera: Camera { eye: vector(&self.eye).into(), look, up: vector(&self.up).into(), lens },
            image: ImagePlane { width: self.size[0], height: self.size[1], ..ImagePlane::default() },
            spheres,
            lighting: Default::default(),
        }
    }
}

fn number(digits: &str) -> f64 {
    digits.parse().unwrap_or_else(|_| panic!("{digits}"))
}

/// Whether `x` is within an ulp of the number written in `digits`.
fn within_an_ulp(x: f64, digits: &str) -> bool {
    let real = number(digits);
    (real.next_down()..=real.next_up()).contains(&x)
}

/// Compares the judge's answer for a pixel with the fixture's.
fn check(case: &Case, pixel: &Pixel, judge: &Judge, truth: Option<&Truth>) {
    let place = format!("{} ({}, {}): {truth:?}", case.name, pixel.i, pixel.j);
    assert_eq!(truth.map_or(-1, |truth| i64::from(truth.id)), pixel.id, "{place}");
    assert_eq!(truth.is_some(), pixel.answer.is_some(), "{place}");
    let (Some(truth), Some(answer)) = (truth, &pixel.answer) else { return };
    assert_eq!((truth.root == Root::Far, truth.tangent), (answer.root == "far", answer.tangent), "{place}");
    for (x, digits) in [(truth.t, &answer.t), (truth.distance, &answer.distance), (truth.depth, &answer.depth)] {
        assert!(within_an_ulp(x, digits), "{place} against {digits}");
    }
    let radius = case.spheres[truth.id as usize][3].0;
    for k in 0..3 {
        // Twice what `Truth` documents: half an ulp of the component and 2^-64 of the scale.
        let near = |x: f64, digits: &str, scale: f64| {
            (x - number(digits)).abs() <= number(digits).abs() * f64::EPSILON + scale * 2f64.powi(-63)
        };
        assert!(near(truth.normal[k], &answer.normal[k], 1.0), "{place} against {}", answer.normal[k]);
        let scale = truth.distance.min(radius);
        assert!(near(truth.position[k], &answer.position[k], scale), "{place} against {}", answer.position[k]);
    }
    check_error(judge, pixel, truth, answer, &place);
}

/// Compares the measured errors of the f64 nearest to t and of its neighbour with the digits.
fn check_error(judge: &Judge, pixel: &Pixel, truth: &Truth, answer: &Answer, place: &str) {
    let (near, tail) = (number(&answer.t), &answer.tail);
    let error = |t| judge.relative_error_of_t(pixel.i, pixel.j, truth.id, truth.root, t);
    // Half an ulp is at most 2^-53 of a number.
    assert!(error(near).abs() <= 2f64.powi(-53), "{place}: {:e}", error(near));
    let step = (near.next_up() - near) / near;
    // The two errors differ by the step; each is rounded to 64 bits, and 1/(1 + error) moves the step by 2^-52 of it.
    assert!((error(near.next_up()) - error(near) - step).abs() <= step * 2f64.powi(-40), "{place}");
    let [hi, lo] = judge.t(pixel.i, pixel.j, truth.id, truth.root).expect("the line meets the sphere");
    assert_eq!(hi, near, "{place}");
    assert!((lo - number(tail)).abs() <= near.abs() * 2f64.powi(-100), "{place}: {lo:e} against {tail}");
}

#[test]
fn the_judge_agrees_with_a_thousand_digits() {
    let cases = cases();
    assert!(cases.len() > 100, "the fixture is there");
    for case in &cases {
        let scene = case.scene();
        let lens = scene.camera.viewport(scene.image.width, scene.image.height).expect("a viewport");
        assert_eq!(
            [lens.vw, lens.vh, lens.d],
            [case.viewport[0].0, case.viewport[1].0, case.distance.0],
            "{}",
            case.name
        );
        let judge = Judge::new(&scene).expect("a scene");
        for pixel in &case.pixels {
            check(case, pixel, &judge, judge.pixel(pixel.i, pixel.j).as_ref());
        }
    }
}

#[test]
fn the_order_of_candidates_does_not_matter() {
    for case in cases() {
        let judge = Judge::new(&case.scene()).expect("a scene");
        let backwards: Vec<u32> = (0..case.spheres.len() as u32).rev().collect();
        for Pixel { i, j, .. } in case.pixels {
            assert_eq!(judge.among(i, j, &backwards), judge.pixel(i, j), "{} ({i}, {j})", case.name);
        }
    }
}

#[test]
fn rays_along_the_axes_are_judged_without_a_camera() {
    let flat = |case: &Case| vector(&case.eye) == [0.0; 3] && case.name.starts_with("touch");
    let cases: Vec<Case> = cases().into_iter().filter(flat).collect();
    assert!(cases.len() >= 20, "the touches are there");
    for case in cases {
        let truth = judge_ray([0.0; 3], [0.0, 0.0, -1.0], &case.scene().spheres);
        assert_eq!(truth.map_or(-1, |truth| i64::from(truth.id)), case.pixels[0].id, "{}", case.name);
    }
}

/// The fixture is made by `tests/truth/lights.py`.
#[test]
fn lights_are_hidden_where_a_thousand_digits_say_so() {
    let cases: Vec<Case> = serde_json::from_str(include_str!("../truth/lights.json")).expect("the fixture");
    let mut counts = [0, 0];
    for case in &cases {
        let mut scene = case.scene();
        let toward = |lamp: &Lamp| match lamp {
            Lamp::Direction(direction) => Toward::Direction(vector(direction)),
            Lamp::Position(position) => Toward::Point(vector(position)),
        };
        let source = |lamp: &Lamp| match lamp {
            Lamp::Direction(direction) => LightSource::Direction(vector(direction).into()),
            Lamp::Position(position) => LightSource::Point(vector(position).into()),
        };
        let lights: Vec<Toward> = case.lights.iter().map(toward).collect();
        scene.lighting.lights = case.lights.iter().map(|lamp| Light::white(source(lamp))).collect();
        let settings = Settings { accuracy: Accuracy::Certified, aovs: vec![Aov::Shadow], ..Settings::default() };
        let frame = cpu().render(&scene, &settings).expect("a frame");
        let shares = frame.f32(Aov::Shadow).expect("a requested buffer");
        let judge = Judge::new(&scene).expect("a scene");
        for pixel in &case.pixels {
            let place = format!("{} ({}, {})", case.name, pixel.i, pixel.j);
            assert_eq!(judge.hidden(pixel.i, pixel.j, &lights).expect("a hit"), pixel.hidden, "{place}");
            let first = (pixel.i * case.size[0] + pixel.j) as usize * lights.len();
            let rendered: Vec<bool> = shares[first..][..lights.len()].iter().map(|share| *share == 1.0).collect();
            assert_eq!(rendered, pixel.hidden, "{place}");
            pixel.hidden.iter().for_each(|hidden| counts[usize::from(*hidden)] += 1);
        }
    }
    println!("{} lights seen, {} hidden", counts[0], counts[1]);
    assert!(counts.iter().all(|count| *count > 300), "{counts:?}");
}

/// Compares a frame with a case of balls.json. Returns the number of hits, and a description of each whose share is
/// wrong.
fn compare_balls(case: &Case, accuracy: Accuracy) -> (usize, Vec<String>) {
    let mut scene = case.scene();
    let [x, y, z, radius] = case.ball.as_ref().expect("a ball").each_ref().map(|x| x.0);
    scene.lighting.lights = vec![Light::white(LightSource::Ball { center: [x, y, z].into(), radius })];
    let settings = Settings { accuracy, aovs: vec![Aov::Shadow, Aov::Certainty], ..Settings::default() };
    let frame = cpu().render(&scene, &settings).expect("a frame");
    let shares = frame.f32(Aov::Shadow).expect("a requested buffer");
    let mut wrong = Vec::new();
    for pixel in &case.pixels {
        let place = (pixel.i * case.size[0] + pixel.j) as usize;
        let (share, known) = (f64::from(shares[place]), pixel.share.expect("a share"));
        // Points on a disc: five standard errors of 0.5 / 64^(3/4) (src/view/directions.rs).
        let near = if known == 0.0 || known == 1.0 { share == known } else { (share - known).abs() <= 0.11 };
        if !near || frame.bits(Aov::Certainty)[place] > 1 {
            wrong.push(format!("{} ({}, {}): {share}, not {known}", case.name, pixel.i, pixel.j));
        }
    }
    (case.pixels.len(), wrong)
}

/// The fixture is made by `tests/truth/balls.py`, which knows the share of a light as an area, not by points. Scenes from 2^-1000 to
/// 2^990, lights of 2^-1000 and at up to 2^1020, hits that are on a light and a step beside it.
#[test]
fn shares_of_balls_are_those_of_two_thousand_digits() {
    let cases: Vec<Case> = serde_json::from_str(include_str!("../truth/balls.json")).expect("the fixture");
    for (accuracy, every) in [(Accuracy::Certified, 1), (Accuracy::Exact, 5)] {
        let found: Vec<_> = cases.iter().step_by(every).map(|case| compare_balls(case, accuracy)).collect();
        let hits: usize = found.iter().map(|(hits, _)| hits).sum();
        let wrong: Vec<_> = found.into_iter().flat_map(|(_, wrong)| wrong).collect();
        println!(
            "{accuracy:?}: {} scenes, {hits} hits, {} rays, {} wrong",
            cases.len().div_ceil(every),
            80 * hits,
            wrong.len()
        );
        assert!(wrong.is_empty() && hits > 400 / every, "{} of {hits}: {}", wrong.len(), wrong.join("; "));
    }
}
