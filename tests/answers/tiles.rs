//! The promise of the search by tiles: an uncertified method gives the same answers as with a search of all spheres,
//! wherever those are right.
//!
//! The rule: where the search of all spheres shows the certified sphere at a distance within `MARGIN` of the certified one,
//! the search by tiles gives the same bits; and it shows no more wrong spheres. Gold standard: certified frames. Elsewhere
//! the search by tiles may be better, because it does not test spheres that are out of view.

use crate::adapter::{admitted, cpu, gpu_or_skip};
use crate::cloud;
use crate::oblique::{self, vfov};
use halfline::camera::Lens;
use halfline::frame::{Aov, Frame};
use halfline::intersect::Method;
use halfline::render::Renderer;
use halfline::scene::{Scene, Spheres};
use halfline::settings::{Accuracy, Search, Settings};

/// The largest relative error of t that the rule covers; see src/search/tile_candidates.rs.
const MARGIN: f64 = 1.0 / 1024.0;

const AOVS: [Aov; 4] = [Aov::Color, Aov::Distance, Aov::Normal, Aov::Id];

fn scene(eye: [f64; 3], lens: Lens, spheres: Spheres) -> Scene {
    oblique::scene([97, 61], eye, [0.0; 3], lens, spheres)
}

/// Spheres of radius `r` to 3 r in a cube of half side 1 about the origin, then twenty of them again in reverse.
fn cloud(seed: u64, count: usize, r: f64) -> Spheres {
    let mut spheres = cloud::cloud(seed, count, [0.0; 3], 1.0, r);
    for twin in (0..20).rev() {
        spheres.push(spheres.centers[twin], spheres.radii[twin], Some([1.0; 3]));
    }
    spheres
}

fn scenes() -> Vec<(&'static str, Scene)> {
    let mut scenes = vec![
        ("a cloud from outside", scene([3.0, 2.0, 4.0], vfov(40.0), cloud(1, 700, 0.05))),
        ("a cloud from inside, spheres behind", scene([0.1, 0.2, 0.3], vfov(100.0), cloud(2, 500, 0.04))),
        ("a cloud beyond the image's edges", scene([0.0, 0.3, 2.0], vfov(9.0), cloud(3, 900, 0.03))),
        ("a cloud from far away", scene([2e3, -1e3, 3e3], vfov(0.03), cloud(4, 600, 0.05))),
    ];
    let mut inside = cloud(5, 300, 0.05);
    inside.push([0.5, 0.5, 1.5], 0.8, Some([0.9, 0.1, 0.1]));
    scenes.push(("the eye in a sphere", scene([0.6, 0.6, 1.6], vfov(60.0), inside)));
    let mut ground = cloud(6, 300, 0.05);
    ground.push([0.0, -1000.9, 0.0], 1000.0, Some([0.2, 0.8, 0.2]));
    ground.push([0.0, 0.0, 4000.0], 3000.0, Some([0.2, 0.2, 0.8]));
    scenes.push(("a large ground, and a planet behind", scene([3.0, 0.5, 2.0], vfov(50.0), ground)));
    scenes
}

fn frame(renderer: &mut Renderer, scene: &Scene, accuracy: Accuracy, method: Option<Method>, search: Search) -> Frame {
    let settings = Settings { accuracy, method, search, aovs: AOVS.to_vec(), ..Settings::default() };
    let frame = renderer.render(scene, &settings).expect("a frame");
    assert!(search == Search::Auto || frame.report.search == search.name(), "{:?}", frame.report.warnings);
    frame
}

/// The pixels that break the rule, and the number of pixels that it covers.
fn broken(tiles: &Frame, all: &Frame, truth: &Frame) -> (Vec<usize>, usize) {
    let distance = |frame: &Frame| frame.f64(Aov::Distance).expect("a requested buffer").to_vec();
    let normal = |frame: &Frame| frame.f32(Aov::Normal).expect("a requested buffer").to_vec();
    let color = |frame: &Frame| frame.f32(Aov::Color).expect("a requested buffer").to_vec();
    let (ours, theirs, right) = (distance(tiles), distance(all), distance(truth));
    let vectors = [(normal(tiles), normal(all)), (color(tiles), color(all))];
    let is_right = |k: &usize| {
        all.ids()[*k] == truth.ids()[*k]
            && (right[*k] == theirs[*k] || (theirs[*k] - right[*k]).abs() <= MARGIN * right[*k])
    };
    let same = |k: usize| {
        tiles.ids()[k] == all.ids()[k]
            && ours[k] == theirs[k]
            && vectors.iter().all(|(a, b)| a[3 * k..3 * k + 3] == b[3 * k..3 * k + 3])
    };
    let covered: Vec<_> = (0..right.len()).filter(is_right).collect();
    (covered.iter().copied().filter(|k| !same(*k)).collect(), covered.len())
}

fn wrong(frame: &Frame, truth: &Frame) -> usize {
    frame.ids().iter().zip(truth.ids()).filter(|(a, b)| a != b).count()
}

fn check(renderer: &mut Renderer, methods: &[Method]) {
    for (name, scene) in scenes() {
        let truth = frame(&mut cpu(), &scene, Accuracy::Certified, None, Search::Auto);
        assert!(truth.report.hits > 500, "{name} has hits");
        for &method in methods {
            let what = format!("{name}, {}", method.name());
            let all = frame(renderer, &scene, Accuracy::Fast, Some(method), Search::All);
            let tiles = frame(renderer, &scene, Accuracy::Fast, Some(method), Search::Tiles);
            let (broken, covered) = broken(&tiles, &all, &truth);
            assert!(broken.is_empty(), "{what}: {} pixels differ, first {:?}", broken.len(), broken.first());
            // From far away, the lecture's methods are almost always wrong.
            let able = matches!(method, Method::Stable | Method::Native64 | Method::DoubleFloat);
            assert!(!able || 10 * covered > 9 * truth.ids().len(), "{what}: the rule covers {covered} pixels");
            assert!(wrong(&tiles, &truth) <= wrong(&all, &truth), "{what}");
        }
    }
}

#[test]
fn a_search_by_tiles_answers_as_one_of_all_spheres_on_the_cpu() {
    check(&mut cpu(), Method::ALL);
}

#[test]
fn a_search_by_tiles_answers_as_one_of_all_spheres_on_the_gpu() {
    let Some(mut gpu) = gpu_or_skip() else { return };
    let methods = admitted(&mut gpu);
    check(&mut gpu, &methods);
}

/// Negative control: a sphere that the search does not test.
#[test]
fn a_missing_sphere_is_found() {
    let (_, scene) = scenes().swap_remove(0);
    let method = Some(Method::Stable);
    let truth = frame(&mut cpu(), &scene, Accuracy::Certified, None, Search::Auto);
    let all = frame(&mut cpu(), &scene, Accuracy::Fast, method, Search::All);
    let mut without = scene.clone();
    let id = all.ids().iter().find(|id| **id >= 20).expect("a sphere without a twin");
    without.spheres.centers.to_mut()[*id as usize] = [1e3; 3];
    let tiles = frame(&mut cpu(), &without, Accuracy::Fast, method, Search::Tiles);
    assert!(!broken(&tiles, &all, &truth).0.is_empty());
}

#[test]
fn a_lens_too_wide_for_tiles_searches_all_spheres_with_a_warning() {
    let lens = Lens::Viewport { vw: 1e7, vh: 1e7, distance: 1.0 };
    let scene = scene([3.0, 2.0, 4.0], lens, cloud(7, 100, 0.1));
    let settings =
        |search| Settings { method: Some(Method::Stable), search, aovs: vec![Aov::Id], ..Settings::default() };
    let tiles = cpu().render(&scene, &settings(Search::Tiles)).expect("a frame");
    assert_eq!(tiles.report.search, "all");
    assert!(tiles.report.warnings.iter().any(|w| w.contains("too wide")), "{:?}", tiles.report.warnings);
    let all = cpu().render(&scene, &settings(Search::All)).expect("a frame");
    assert_eq!(tiles.ids(), all.ids());
    assert!(!all.report.warnings.iter().any(|w| w.contains("too wide")));
}
