//! The promise of watching: what is told only grows and comes to its end, and what is ended leaves no trace.

#[expect(dead_code, reason = "the helpers of tests that walk the methods")]
mod common;

use common::{cpu, gpu};
use halfline::{
    Accuracy, Aov, Cancel, Error, Method, Progress, ReadOptions, Renderer, Scene, Search, Settings, Step, Watch,
};
use std::path::Path;
use std::sync::{Arc, Mutex};

fn weekend(width: u32, height: u32) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/weekend.toml");
    let mut scene = Scene::read(&path, &ReadOptions::default()).expect("weekend");
    (scene.image.width, scene.image.height) = (width, height);
    scene
}

fn renderers() -> Vec<Renderer> {
    [Some(cpu()), gpu()].into_iter().flatten().collect()
}

fn settings(accuracy: Accuracy) -> Settings {
    Settings { accuracy, aovs: vec![Aov::Color, Aov::Id, Aov::Distance], ..Settings::default() }
}

/// Everything that is heard.
type Heard = Arc<Mutex<Vec<Progress>>>;

#[test]
fn every_step_is_told_from_its_beginning_to_its_end() {
    let scene = weekend(75, 50);
    let spheres = scene.spheres.len() as u64;
    for renderer in renderers() {
        let heard = Heard::default();
        let ear = Arc::clone(&heard);
        let watch = Watch::default().telling(move |progress| ear.lock().expect("an ear").push(progress));
        let mut renderer = renderer.watched_by(watch);
        for (accuracy, steps) in [
            (Accuracy::Fast, &[(Step::Stage, spheres), (Step::Trace, 75 * 50)][..]),
            (Accuracy::Certified, &[(Step::Stage, spheres), (Step::Trace, 75 * 50), (Step::Settle, 0)]),
            (Accuracy::Exact, &[(Step::Stage, spheres), (Step::Settle, 75 * 50)]),
        ] {
            let frame = renderer.render(&scene, &settings(accuracy)).expect("a frame");
            let heard = std::mem::take(&mut *heard.lock().expect("an ear"));
            let told: Vec<&[Progress]> = heard.chunk_by(|a, b| a.step == b.step).collect();
            assert_eq!(told.len(), steps.len(), "{accuracy:?}: {told:?}");
            for (told, (step, total)) in told.into_iter().zip(steps) {
                // How many are settled is the frame's own word.
                let total = if *total == 0 { frame.report.settled } else { *total };
                assert!(total > 0 && told.iter().all(|p| (p.step, p.total) == (*step, total)), "{told:?}");
                assert_eq!((told[0].done, told[told.len() - 1].done), (0, total), "{told:?}");
                assert!(told.is_sorted_by_key(|p| p.done), "{told:?}");
            }
        }
    }
}

#[test]
fn a_frame_that_was_ended_leaves_the_next_one_whole() {
    for renderer in renderers() {
        // On an adapter, heavy enough for more than one submission.
        let (scene, settings) = match renderer.is_gpu() {
            true => (
                weekend(1200, 1000),
                Settings { method: Some(Method::Stable), search: Search::All, ..settings(Accuracy::Auto) },
            ),
            false => (weekend(120, 80), settings(Accuracy::Certified)),
        };
        let (cancel, heard) = (Cancel::default(), Heard::default());
        let (token, ear) = (cancel.clone(), Arc::clone(&heard));
        let watch = Watch::default().cancelled_by(&cancel).telling(move |progress| {
            ear.lock().expect("an ear").push(progress);
            if progress.step == Step::Trace && progress.done > 0 {
                token.cancel();
            }
        });
        let mut renderer = renderer.watched_by(watch);
        let error = renderer.render(&scene, &settings).expect_err("it was cancelled");
        assert!(matches!(error, Error::Interrupted), "{error}");
        let last = *heard.lock().expect("an ear").last().expect("something");
        assert!(last.step == Step::Trace && last.done < last.total, "{last:?}");
        assert!(matches!(renderer.render(&scene, &settings), Err(Error::Interrupted)), "until the token is reset");
        let mut renderer = renderer.watched_by(Watch::default());
        let again = renderer.render(&scene, &settings).expect("a frame");
        let fresh = if renderer.is_gpu() { gpu().expect("a GPU") } else { cpu() }.render(&scene, &settings);
        assert!(again.buffers == fresh.expect("a frame").buffers, "{} forgets", renderer.adapter());
    }
}

#[test]
fn nothing_begins_that_is_ended_already() {
    for renderer in renderers() {
        let (cancel, heard) = (Cancel::default(), Heard::default());
        let ear = Arc::clone(&heard);
        let hear = move |progress| ear.lock().expect("an ear").push(progress);
        let mut renderer = renderer.watched_by(Watch::default().cancelled_by(&cancel).telling(hear));
        cancel.cancel();
        assert!(matches!(renderer.render(&weekend(8, 8), &settings(Accuracy::Fast)), Err(Error::Interrupted)));
        assert!(heard.lock().expect("an ear").is_empty());
        cancel.reset();
        assert!(renderer.render(&weekend(8, 8), &settings(Accuracy::Fast)).is_ok());
    }
}
