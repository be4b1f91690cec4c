//! Times of a frame's stages for criterion, from the frame's report; used by kernel.rs and search.rs.

#[path = "../../examples/cloud/mod.rs"]
mod cloud;

use criterion::{BenchmarkGroup, Criterion, SamplingMode, measurement::WallTime};
use halfline::report::Report;
use halfline::{Renderer, Scene, Settings};
use std::time::Duration;

/// Image side.
pub(crate) const SIDE: u32 = 512;

/// A cloud in front of 512 x 512 pixels.
pub(crate) fn scene(count: usize) -> Scene {
    let mut scene = cloud::cloud(count);
    (scene.image.width, scene.image.height) = (SIDE, SIDE);
    scene
}

/// A group of few samples, because each takes long compared with the clock's resolution.
pub(crate) fn group<'a>(criterion: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
    group
}

/// A renderer, or the reason why there is none.
pub(crate) fn renderer(settings: &Settings) -> Option<Renderer> {
    Renderer::new(settings).map_err(|error| println!("SKIPPED {}: {error}", settings.backend.name())).ok()
}

/// The time of `part` in every frame, in milliseconds; the rest of the frame is rendered but not counted.
pub(crate) fn bench(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    renderer: &mut Renderer,
    (scene, settings): (&Scene, &Settings),
    part: impl Fn(&Report) -> f64,
) {
    group.bench_function(format!("{name}/{}", settings.backend.name()), |bencher| {
        bencher.iter_custom(|frames| {
            let mut spent = 0.0;
            for _ in 0..frames {
                let frame = renderer.render(scene, settings).expect("a frame");
                spent += part(&frame.report);
                renderer.recycle(frame);
            }
            Duration::from_secs_f64(spent * 1e-3)
        });
    });
}
