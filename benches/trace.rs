//! 1e5 given rays and spheres in a unit cube: by a method among all spheres, and certified by a tree, which is rebuilt for
//! every call.
//!
//! ```sh
//! cargo bench --bench trace             # cases of more than some seconds a call are left out
//! cargo bench --bench trace -- 1e4/certified
//! ```

#[path = "../examples/cloud/mod.rs"]
mod cloud;

use cloud::cloud;
use criterion::{Criterion, criterion_group, criterion_main};
use halfline::{Accuracy, Backend, Renderer, Settings};
use std::time::Duration;

const RAYS: usize = 100_000;

/// The limit of ray-sphere tests per call; larger cases are skipped.
const PATIENCE: usize = 200_000_000;

/// Points on a circle about the cube, and directions to points in it by the additive recurrence of the plastic number
/// (Roberts 2018): rays from one point, or from as many as there are rays.
fn rays(spread: bool) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let eye = |n: usize| {
        let angle = if spread { 0.001 * n as f64 } else { 0.9 };
        [0.5 + 2.5 * angle.cos(), 1.6, 0.5 + 2.5 * angle.sin()]
    };
    let to = |n: usize| [0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9].map(|x| (n as f64 * x).fract());
    let direction = |n: usize| std::array::from_fn(|k| to(n)[k] - eye(n)[k]);
    ((0..if spread { RAYS } else { 1 }).map(eye).collect(), (0..RAYS).map(direction).collect())
}

fn traces(criterion: &mut Criterion) {
    for count in ["1e3", "1e4", "1e5", "1e6"] {
        let spheres = cloud(count.parse::<f64>().expect("a count") as usize).spheres;
        let mut group = criterion.benchmark_group(count);
        group.sample_size(10).sampling_mode(criterion::SamplingMode::Flat);
        group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(4));
        for backend in [Backend::Gpu, Backend::Cpu] {
            let mut renderer = match Renderer::new(&Settings { backend, ..Settings::default() }) {
                Ok(renderer) => renderer,
                Err(error) => {
                    println!("SKIPPED {count} on {}: {error}", backend.name());
                    continue;
                }
            };
            for accuracy in [Accuracy::Certified, Accuracy::Fast] {
                if accuracy == Accuracy::Fast && spheres.len() * RAYS > PATIENCE {
                    println!("SKIPPED {count}/fast/{}: more than {PATIENCE} tests", backend.name());
                    continue;
                }
                let settings = Settings { backend, accuracy, ..Settings::default() };
                for (name, spread) in [("shared", false), ("spread", true)] {
                    let (origins, directions) = rays(spread);
                    group.bench_function(format!("{}/{name}/{}", accuracy.name(), backend.name()), |bencher| {
                        bencher.iter(|| renderer.trace(&spheres, &origins, &directions, &settings).expect("hits"));
                    });
                }
            }
        }
        group.finish();
    }
}

criterion_group!(benches, traces);
criterion_main!(benches);
