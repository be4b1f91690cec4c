//! Whether lights and sky are hidden from hits, compared with exact arithmetic over all spheres, where f64 and every epsilon
//! go wrong.

pub(crate) mod families;

use super::super::hidden::{LightRay, all_but};
use crate::certify::given::AnyHit;
use crate::certify::surface::SurfacePoint;
use crate::exact::{Judge, LightQuestion, Toward};
use crate::scene::NumberedBall;
use crate::search::tree::Tree;
use crate::testing::Rng;
use crate::view::View;
use crate::view::picture_rays::PictureRays;
use families::{FAMILIES, Family};
use glam::DVec3;
use rayon::prelude::*;

/// The numbers of compared points and rays, of undecided rays, and of wrong answers.
#[derive(Debug, Default)]
struct Score {
    points: u32,
    rays: u32,
    unsure: u32,
    /// Lit in exact arithmetic, answered as hidden: acne.
    acne: u32,
    /// Hidden in exact arithmetic, answered as lit.
    leaks: u32,
}

impl Score {
    fn wrong(&self) -> u32 {
        self.acne + self.leaks
    }
}

/// Compares the answers at `count` hit points of one part of a family, each moved by `change` before its rays leave.
fn score(family: &Family, part: u64, count: u32, change: impl Fn(SurfacePoint) -> SurfacePoint) -> Score {
    let mut random = Rng(family.seed + 1000 * part);
    let mut score = Score::default();
    while score.points < count {
        let (scene, lights) = (family.make)(&mut random);
        let judge = Judge::new(&scene).expect("a scene");
        let bare = Judge::new(&scene.bare()).expect("a camera");
        let view = View::without_spheres(&scene).expect("a view");
        let tree = Tree::new(&scene.spheres.centers, &scene.spheres.radii).expect("spheres");
        for pixel in 0..scene.image.width * scene.image.height {
            let (i, j) = (pixel / scene.image.width, pixel % scene.image.width);
            let Some(truth) = judge.pixel(i, j) else { continue };
            let ball = scene.spheres.ball(truth.id);
            let named = NumberedBall { id: truth.id, ball };
            let hit = SurfacePoint::of_pixel(&view, &tree.placement, [i, j], named);
            let judged = || SurfacePoint::judged(&tree.placement, &truth, named);
            let point = change(if hit.is_sharp(&tree.placement) { hit } else { judged() });
            let first = random.below(lights.len() as u32) as usize;
            let chosen = lights.iter().cycle().skip(first).take(family.most.min(lights.len()));
            let lights: Vec<Toward> = chosen.map(|light| light.at(&mut random, &truth)).collect();
            let hidden = judge.hidden(i, j, &lights).expect("a hit");
            for (toward, hidden) in lights.iter().zip(hidden) {
                let mut among = all_but(None, &tree, None);
                let answer = match point.ray(&tree.placement, toward) {
                    Some(ray) => {
                        let ray = LightRay::new(&tree, &point, &ray, None);
                        among = ray.candidates();
                        ray.answer()
                    }
                    None => AnyHit::Unsure,
                };
                let question = LightQuestion::Hidden { toward: *toward, turned: false, among };
                score.unsure += u32::from(answer == AnyHit::Unsure);
                score.rays += 1;
                let answer = match answer {
                    AnyHit::Unsure => bare.ask(i, j, scene.spheres.solid(truth.id), &[question]).expect("a hit")[0],
                    answer => answer == AnyHit::Blocked,
                };
                score.acne += u32::from(answer && !hidden);
                score.leaks += u32::from(!answer && hidden);
            }
            score.points += 1;
        }
    }
    score
}

/// Compares the normals that f64 takes as sharp, which weigh rays to the sky, with the normals of the judge.
#[test]
fn sharp_normals_are_off_by_less_than_2_to_the_minus_29() {
    let of_family = |family: &Family| {
        let (random, mut worst, mut sharp, mut all) = (&mut Rng(family.seed), 0.0f64, 0, 0);
        for _ in 0..60 {
            let (scene, _) = (family.make)(random);
            let (judge, view) = (Judge::new(&scene).expect("a scene"), View::without_spheres(&scene).expect("a view"));
            let rays = PictureRays::new(&view, None);
            for pixel in 0..scene.image.width * scene.image.height {
                let Some(truth) = judge.pixel(pixel / scene.image.width, pixel % scene.image.width) else { continue };
                let hit = rays.hit(pixel, scene.spheres.ball(truth.id), false);
                let off = (hit.normal - DVec3::from_array(truth.normal)).length();
                all += 1;
                if hit.sharp {
                    (worst, sharp) = (worst.max(off), sharp + 1);
                }
            }
        }
        println!("{}: {sharp} of {all} normals are sharp, off by at most 2^{:.1}", family.name, worst.log2());
        // The judge rounds its normal to f64.
        assert!(worst <= 1.0 / f64::from(1 << 29) + 4.0 * f64::EPSILON, "{}: {worst:e}", family.name);
        sharp
    };
    let sharp: u32 = FAMILIES.par_iter().map(of_family).sum();
    assert!(sharp > 5000, "{sharp}");
}

/// Points of each family; with every light of the family two to four times as many rays.
const POINTS: u32 = 100;

#[test]
fn certified_answers_are_exact() {
    FAMILIES.par_iter().for_each(|family| {
        let score = score(family, 0, POINTS, |point| point);
        println!("{}: {score:?}", family.name);
        assert_eq!(score.wrong(), 0, "{}: {score:?}", family.name);
    });
}

/// The same for a million points, two rays from each: `cargo test --lib -- --ignored a_million_points --nocapture`.
#[test]
#[ignore = "takes half an hour"]
fn a_million_points_are_exact() {
    const PARTS: u64 = 16;
    let count = 1_000_000 / (PARTS as u32 * FAMILIES.len() as u32) + 1;
    let parts: Vec<_> = FAMILIES.iter().flat_map(|family| (1..=PARTS).map(move |part| (family, part))).collect();
    let scores = parts.into_par_iter().map(|(family, part)| {
        let two = Family { most: 2, ..*family };
        let score = score(&two, part, count, |point| point);
        println!("{} {part}: {score:?}", family.name);
        score
    });
    let all: Vec<Score> = scores.collect();
    let sum = |of: &dyn Fn(&Score) -> u32| all.iter().map(of).sum::<u32>();
    println!("{} points, {} rays, {} unsure", sum(&|s| s.points), sum(&|s| s.rays), sum(&|s| s.unsure));
    assert_eq!((sum(&|s| s.acne), sum(&|s| s.leaks)), (0, 0));
}

/// Negative control: rays start a thousandth of the radius off the surface, as in renderers with an epsilon. Some
/// answers are then wrong.
#[test]
fn a_planted_epsilon_is_caught() {
    let wrong = FAMILIES.par_iter().map(|family| {
        let score = score(family, 0, POINTS, |point| {
            let outward = DVec3::from_array(point.normal) * DVec3::from_array(point.offset).length();
            SurfacePoint { offset: (DVec3::from_array(point.offset) + 1e-3 * outward).to_array(), ..point }
        });
        println!("{}: {score:?}", family.name);
        score.wrong()
    });
    let wrong: u32 = wrong.sum();
    assert!(wrong > 0, "no answer is wrong");
}
