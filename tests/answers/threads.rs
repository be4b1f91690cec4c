//! The promise of a process with many renderers: threads that make, use and drop one each, side by side, all have the answers of one.

use crate::adapter::gpu_or_skip;
use crate::amount::amount;
use crate::weekend::weekend;
use halfline::frame::{Aov, Frame};
use halfline::render::Renderer;
use halfline::settings::{Accuracy, Backend, Settings};
use std::thread;

/// The renderers of a round.
const RENDERERS: usize = 16;

#[test]
fn sixteen_renderers_begin_and_end_in_sixteen_threads() {
    let Some(mut first) = gpu_or_skip() else { return };
    let mut scene = weekend();
    (scene.image.width, scene.image.height) = (32, 20);
    let aovs = vec![Aov::Distance];
    let settings = Settings { backend: Backend::Gpu, accuracy: Accuracy::Certified, aovs, ..Settings::default() };
    let answers = |frame: &Frame| {
        let distances = frame.f64(Aov::Distance).expect("distances").iter().map(|x| x.to_bits());
        (frame.ids().to_vec(), distances.collect::<Vec<_>>())
    };
    let expected = answers(&first.render(&scene, &settings).expect("a frame"));
    // As many as a machine with a card was asked to try.
    for round in 0..amount("rounds of sixteen renderers", [1, 1, 100]) {
        let one = || {
            let mut renderer = Renderer::new(&settings).expect("an adapter");
            answers(&renderer.render(&scene, &settings).expect("a frame"))
        };
        let all = thread::scope(|scope| {
            let threads: Vec<_> = (0..RENDERERS).map(|_| scope.spawn(one)).collect();
            threads.into_iter().map(|thread| thread.join().expect("a thread")).collect::<Vec<_>>()
        });
        assert!(all.iter().all(|answers| *answers == expected), "round {round}");
    }
}
