//! Given rays by a method: every ray tests all spheres and answers alone, up to a number of spheres.

use crate::adapter::{cpu, gpu_or_skip};
use crate::rng::Rng;
use halfline::error::Error;
use halfline::intersect::Method;
use halfline::quote::setting::ACCURACY;
use halfline::scene::Spheres;
use halfline::settings::{Accuracy, Search, Settings};

fn cloud(random: &mut Rng, count: usize) -> Spheres {
    let mut spheres = Spheres::default();
    (0..count).for_each(|_| spheres.push(random.cube(), 0.1 * (1.0 + 2.0 * random.unit()), None));
    spheres
}

/// Rays that run side by side on a device wait for each other, but answer alone; of equal t the lower id is hit.
#[test]
fn the_order_of_rays_changes_no_answer_of_a_method() {
    let random = &mut Rng::new(11);
    let some = cloud(random, 40);
    let mut twice = some.clone();
    (0..40).rev().for_each(|n| twice.push(some.centers[n], some.radii[n], None));
    let origins: Vec<_> = (0..1500).map(|_| random.cube().map(|x| 3.0 * x)).collect();
    let directions: Vec<_> = (0..1500).map(|_| random.cube()).collect();
    for mut renderer in gpu_or_skip().into_iter().chain([cpu()]) {
        let settings = Settings { method: Some(Method::Stable), ..Settings::default() };
        let mut traced = |origins: &[[f64; 3]], directions: &[[f64; 3]]| {
            let hits = renderer.trace(&twice, origins, directions, &settings).expect("hits");
            assert_eq!(hits.search, Search::All);
            hits.id.into_iter().zip(hits.t.into_iter().map(f64::to_bits)).collect::<Vec<_>>()
        };
        let answers = traced(&origins, &directions);
        let reversed = |of: &[[f64; 3]]| of.iter().rev().copied().collect::<Vec<_>>();
        let mut other = traced(&reversed(&origins), &reversed(&directions));
        other.reverse();
        assert!(answers == other && answers.iter().any(|(id, _)| *id >= 0));
        assert!(answers.iter().all(|(id, _)| *id < 40), "of two equal spheres the first is hit");
    }
}

#[test]
fn more_spheres_than_a_method_tests_are_refused() {
    let spheres = cloud(&mut Rng::new(12), 10_001);
    let trace = |accuracy| {
        let settings = Settings { accuracy, ..Settings::default() };
        cpu().trace(&spheres, &[[3.0; 3]], &[[-1.0; 3]], &settings)
    };
    let error = trace(Accuracy::Fast).expect_err("too many spheres");
    assert!(matches!(&error, Error::Limits { .. }), "{error}");
    let words = error.to_string();
    let certified = format!("{ACCURACY} certified");
    assert!(["10001", "10000", &certified].iter().all(|word| words.contains(word)), "{words}");
    assert_eq!(trace(Accuracy::Certified).expect("a certified hit").search, Search::Tree);
}

#[test]
fn a_search_that_does_not_apply_is_refused() {
    let spheres = cloud(&mut Rng::new(13), 9);
    let trace = |spheres: &Spheres, settings: &Settings| cpu().trace(spheres, &[[0.0; 3]], &[[1.0; 3]], settings);
    let refused = |settings: &Settings| trace(&spheres, settings).expect_err("another search").to_string();
    let tree = Settings { search: Search::Tree, ..Settings::default() };
    let by_tree = refused(&Settings { method: Some(Method::Stable), ..tree.clone() });
    assert!(by_tree.contains("a method tests all spheres"), "{by_tree}");
    let nothing = trace(&Spheres::default(), &Settings { method: Some(Method::Stable), ..Settings::default() });
    let nothing = nothing.expect("nothing to hit");
    assert_eq!((nothing.id, nothing.search), (vec![-1], Search::All));
}
