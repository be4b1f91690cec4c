//! Given rays in more than one block: hits, truths and bounds are the judge's; interruptions.

use super::certified::LEAST;
use crate::answers::assemble::settled_bound;
use crate::exact::{Truth, judge_ray};
use crate::frame::Aov;
use crate::render::Renderer;
use crate::render::trace::Rays;
use crate::scene::Spheres;
use crate::settings::{Accuracy, Backend, Settings};
use crate::testing::Rng;
use halfline_ground::error::Error;
use halfline_ground::progress::Watch;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Every ray with this remainder touches the first sphere exactly, so that bounds decide nothing.
const TOUCHING: [usize; 2] = [1009, 7];

/// Spheres, and rays from two places through them.
fn rays(count: usize) -> (Spheres, Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let mut rng = Rng(0xb10c);
    let mut spheres = Spheres::default();
    spheres.push([0.0; 3], 5.0, None);
    (0..300).for_each(|_| spheres.push([0; 3].map(|_| rng.between(-30.0, 30.0)), rng.between(0.5, 2.0), None));
    let mut ray = |n: usize| match n % TOUCHING[0] == TOUCHING[1] {
        true => ([-13.0, 5.0, 0.0], [1.0, 0.0, 0.0]),
        false => {
            ([[0; 3].map(|_| rng.between(-40.0, 40.0)), [1.0, 2.0, 3.0]][n % 2], [0; 3].map(|_| rng.between(-1.0, 1.0)))
        }
    };
    let (origins, directions) = (0..count).map(&mut ray).unzip();
    (spheres, origins, directions)
}

fn settings(accuracy: Accuracy) -> Settings {
    Settings { backend: Backend::Cpu, accuracy, aovs: vec![Aov::Normal, Aov::Bound], ..Settings::default() }
}

#[test]
fn answers_of_blocks_are_those_of_the_judge() {
    for (accuracy, count) in [(Accuracy::Certified, 2 * LEAST + 5), (Accuracy::Exact, 2000)] {
        let (spheres, origins, directions) = rays(count);
        let settings = settings(accuracy);
        let mut renderer = Renderer::new(&settings).expect("the CPU path");
        let mut tracer = renderer.tracer(&spheres, &settings).expect("valid spheres");
        let given = Rays { origins: &origins, directions: &directions, limits: &[] };
        let (hits, settled) = tracer.certified_hits(&given).expect("valid rays");
        let truth = |n: usize| judge_ray(origins[n], directions[n], &spheres);
        let of: Vec<usize> = (0..count).filter(|n| hits.certainty[*n] == 1).collect();
        assert!(
            settled.iter().map(|settled| settled.pixel as usize).eq(of.iter().copied()),
            "in the order of the rays"
        );
        // Without the depth, which is NaN.
        let numbers = |truth: Option<Truth>| truth.map(|truth| (truth.id, truth.t, truth.distance, truth.normal));
        assert!(settled.iter().all(|settled| numbers(settled.truth) == numbers(truth(settled.pixel as usize))));
        let touches = |n: &usize| n % TOUCHING[0] == TOUCHING[1];
        assert!(
            (0..count).filter(touches).all(|n| of.contains(&n))
                && (accuracy == Accuracy::Exact || of.len() < count / 500)
        );
        let bounds = hits.bound.as_ref().expect("requested");
        for n in (0..count).filter(|n| n % 41 == 0 || hits.certainty[*n] == 1) {
            let (id, distance) = truth(n).map_or((-1, f64::INFINITY), |truth| (truth.id as i32, truth.distance));
            assert_eq!(hits.id[n], id, "ray {n}");
            if id < 0 {
                assert_eq!((hits.distance[n], bounds[n]), (distance, 0.0), "ray {n}");
                continue;
            }
            // The judge's distance is rounded too.
            let error = (hits.distance[n] - distance).abs();
            assert!(error <= bounds[n] + settled_bound(distance), "ray {n}: {error:e}, {:e}", bounds[n]);
            assert!(bounds[n] > 0.0 && bounds[n] <= 1.01e-5 * distance, "ray {n}: {:e} of {distance}", bounds[n]);
            assert!(hits.certainty[n] == 0 || bounds[n] == settled_bound(distance), "ray {n}");
        }
    }
}

#[test]
fn blocks_are_interrupted() {
    let count = 3 * LEAST;
    let (spheres, origins, directions) = rays(count);
    let given = Rays { origins: &origins, directions: &directions, limits: &[] };
    let settings = settings(Accuracy::Certified);
    // Before the call, in one of its blocks, while the judge decides.
    for most in [0, 1, 3, 20] {
        let calls = AtomicUsize::new(0);
        let watch = Watch::default().while_true(move || calls.fetch_add(1, Relaxed) < most);
        let mut renderer = Renderer::new(&settings).expect("the CPU path").watched_by(watch);
        let mut tracer = renderer.tracer(&spheres, &settings).expect("valid spheres");
        let found = tracer.hits(&given);
        assert!(matches!(found, Err(Error::Interrupted)), "{most}: {:?}", found.map(|hits| hits.id.len()));
    }
}

#[test]
fn nothing_is_proved_by_a_method() {
    let (spheres, origins, directions) = rays(200);
    let settings = settings(Accuracy::Fast);
    let mut renderer = Renderer::new(&settings).expect("the CPU path");
    let given = Rays { origins: &origins, directions: &directions, limits: &[] };
    let hits = renderer.tracer(&spheres, &settings).and_then(|mut tracer| tracer.hits(&given)).expect("valid rays");
    let bounds = hits.bound.expect("requested");
    assert!(hits.id.iter().zip(&bounds).all(|(id, bound)| *bound == if *id < 0 { 0.0 } else { f64::INFINITY }));
}
