//! The promise of progress and cancellation: progress only grows and reaches its total, and a cancelled frame does not change
//! the next one.

use crate::adapter::{cpu, gpu, renderers};
use crate::weekend;
use halfline::{Accuracy, Aov, Cancel, Error, Method, Progress, Scene, Settings, Step, Watch};
use std::sync::{Arc, Mutex};

fn weekend(width: u32, height: u32) -> Scene {
    let mut scene = weekend::weekend();
    (scene.image.width, scene.image.height) = (width, height);
    scene
}

fn settings(accuracy: Accuracy) -> Settings {
    Settings { accuracy, aovs: vec![Aov::Color, Aov::Id, Aov::Distance], ..Settings::default() }
}

/// All progress that was reported.
type Reported = Arc<Mutex<Vec<Progress>>>;

#[test]
fn every_step_is_reported_from_0_to_its_total() {
    let scene = weekend(75, 50);
    let spheres = scene.spheres.len() as u64;
    for (_, renderer) in renderers() {
        let reported = Reported::default();
        let list = Arc::clone(&reported);
        let watch = Watch::default().on_progress(move |progress| list.lock().expect("the list").push(progress));
        let mut renderer = renderer.watched_by(watch);
        for (accuracy, steps) in [
            (Accuracy::Fast, &[(Step::Stage, spheres), (Step::Trace, 75 * 50)][..]),
            (Accuracy::Certified, &[(Step::Stage, spheres), (Step::Trace, 75 * 50), (Step::Settle, 0)]),
            (Accuracy::Exact, &[(Step::Stage, spheres), (Step::Settle, 75 * 50)]),
        ] {
            let frame = renderer.render(&scene, &settings(accuracy)).expect("a frame");
            let reported = std::mem::take(&mut *reported.lock().expect("the list"));
            let steps_reported: Vec<&[Progress]> = reported.chunk_by(|a, b| a.step == b.step).collect();
            assert_eq!(steps_reported.len(), steps.len(), "{accuracy:?}: {steps_reported:?}");
            for (progress, (step, total)) in steps_reported.into_iter().zip(steps) {
                // The frame's report has the number of settled pixels.
                let total = if *total == 0 { frame.report.settled } else { *total };
                assert!(total > 0 && progress.iter().all(|p| (p.step, p.total) == (*step, total)), "{progress:?}");
                assert_eq!((progress[0].done, progress[progress.len() - 1].done), (0, total), "{progress:?}");
                assert!(progress.is_sorted_by_key(|p| p.done), "{progress:?}");
            }
        }
    }
}

#[test]
fn a_cancelled_frame_does_not_change_the_next_one() {
    for (_, renderer) in renderers() {
        // Heavy enough for more than one submission on an adapter.
        let (scene, settings) = match renderer.is_gpu() {
            true => (weekend(1200, 1000), Settings { method: Some(Method::Stable), ..settings(Accuracy::Auto) }),
            false => (weekend(120, 80), settings(Accuracy::Certified)),
        };
        let (cancel, reported) = (Cancel::default(), Reported::default());
        let (token, list) = (cancel.clone(), Arc::clone(&reported));
        let watch = Watch::default().cancelled_by(&cancel).on_progress(move |progress| {
            list.lock().expect("the list").push(progress);
            if progress.step == Step::Trace && progress.done > 0 {
                token.cancel();
            }
        });
        let mut renderer = renderer.watched_by(watch);
        let error = renderer.render(&scene, &settings).expect_err("it was cancelled");
        assert!(matches!(error, Error::Interrupted), "{error}");
        let last = *reported.lock().expect("the list").last().expect("something");
        assert!(last.step == Step::Trace && last.done < last.total, "{last:?}");
        assert!(matches!(renderer.render(&scene, &settings), Err(Error::Interrupted)), "until the token is reset");
        let mut renderer = renderer.watched_by(Watch::default());
        let again = renderer.render(&scene, &settings).expect("a frame");
        let fresh = if renderer.is_gpu() { gpu().expect("a GPU") } else { cpu() }.render(&scene, &settings);
        assert!(again.buffers == fresh.expect("a frame").buffers, "the next frame on {}", renderer.adapter());
    }
}

#[test]
fn a_cancelled_token_stops_a_frame_before_its_first_step() {
    for (_, renderer) in renderers() {
        let (cancel, reported) = (Cancel::default(), Reported::default());
        let list = Arc::clone(&reported);
        let report = move |progress| list.lock().expect("the list").push(progress);
        let mut renderer = renderer.watched_by(Watch::default().cancelled_by(&cancel).on_progress(report));
        cancel.cancel();
        assert!(matches!(renderer.render(&weekend(8, 8), &settings(Accuracy::Fast)), Err(Error::Interrupted)));
        assert!(reported.lock().expect("the list").is_empty());
        cancel.reset();
        assert!(renderer.render(&weekend(8, 8), &settings(Accuracy::Fast)).is_ok());
    }
}
