//! Certified and exact frames at the ends of f64 equal the frames of the lecture's formulas in hundreds of digits.
//!
//! The fixture is made by `python3 tests/truth/frames.py`, which shares neither the camera's basis nor the exact arithmetic
//! with the program. Its families, by the letter of the name:
//!
//! - A: `up` almost along the view, and a lens of 2e-17: the basis must be more accurate than double-double.
//! - B: the eye is so near a surface that its power underflows in f64.
//! - C: eye and `at` are some steps of the subnormal numbers apart, or the whole range.
//! - D: everything is subnormal, or so large that squares overflow.

use crate::adapter::renderers;
use crate::truth::Digits;
use halfline::camera::{Camera, Lens, Look};
use halfline::frame::Aov;
use halfline::scene::{ImagePlane, Scene, Spheres};
use halfline::settings::{Accuracy, Settings};
use serde::Deserialize;

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
    /// `.` for a miss, else the digit of the sphere.
    rows: Vec<String>,
}

impl Case {
    fn scene(&self) -> Scene {
        let vector = |a: &[Digits; 3]| a.each_ref().map(Digits::number).into();
        let look = match (&self.at, &self.view) {
            (Some(at), None) => Look::At(vector(at)),
            (None, Some(view)) => Look::View(vector(view)),
            _ => panic!("{}: either at or view", self.name),
        };
        let [[vw, vh], distance] = [self.viewport.each_ref().map(Digits::number), [self.distance.number(); 2]];
        let lens = match distance[0].is_infinite() {
            true => Lens::Orthographic { height: vh },
            false => Lens::Viewport { vw, vh, distance: distance[0] },
        };
        let mut spheres = Spheres::default();
        for sphere in &self.spheres {
            let [x, y, z, radius] = sphere.each_ref().map(Digits::number);
            spheres.push([x, y, z], radius, None);
        }
        Scene {
            camera: Camera { eye: vector(&self.eye), look, up: vector(&self.up), lens },
            image: ImagePlane { width: self.size[0], height: self.size[1], ..ImagePlane::default() },
            spheres,
            lighting: Default::default(),
        }
    }

    fn ids(&self) -> Vec<i32> {
        let pixels = self.rows.iter().flat_map(|row| row.chars());
        pixels.map(|c| c.to_digit(10).map_or(-1, |id| id as i32)).collect()
    }
}

#[test]
fn frames_at_the_ends_of_f64_equal_those_of_hundreds_of_digits() {
    let cases: Vec<Case> = serde_json::from_str(include_str!("../truth/frames.json")).expect("the fixture");
    assert!(cases.len() > 60, "{} frames", cases.len());
    let mut renderers = renderers();
    let mut wrong = Vec::new();
    for case in &cases {
        let (scene, truth) = (case.scene(), case.ids());
        for (backend, renderer) in &mut renderers {
            for accuracy in [Accuracy::Certified, Accuracy::Exact] {
                let settings = Settings { accuracy, aovs: vec![Aov::Distance, Aov::Normal], ..Settings::default() };
                let frame = renderer.render(&scene, &settings).unwrap_or_else(|e| panic!("{}: {e}", case.name));
                let off = frame.ids().iter().zip(&truth).filter(|(shown, true_id)| shown != true_id).count();
                if off > 0 {
                    wrong.push(format!(
                        "{}, {}, {}: {off} wrong of {}",
                        case.name,
                        backend.name(),
                        accuracy.name(),
                        truth.len()
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
