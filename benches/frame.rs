//! Whole frames, colour with id, distance and normal, 512 x 512, without files.
//!
//! ```sh
//! cargo bench -- cloud            # only benchmarks with "cloud" in the name
//! cargo bench -- certified/gpu    # on halfline's default adapter
//! ```

#[path = "../examples/cloud/mod.rs"]
mod cloud;

use cloud::cloud;
use criterion::{Criterion, criterion_group, criterion_main};
use halfline::{Accuracy, Aov, Backend, Renderer, Scene, Settings, Watch};
use halfline_files::read::{self, ReadOptions};
use std::time::{Duration, Instant};

fn scene(name: &str) -> Scene {
    let mut scene = match name.strip_prefix("cloud ") {
        Some(count) => cloud(count.parse::<f64>().expect("a count") as usize),
        None => {
            let file = format!("{}/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
            let scene = read::scene(file.as_ref(), &ReadOptions::default()).expect("a scene of the repository");
            // Viewing rays alone.
            Scene { lighting: Default::default(), ..scene }
        }
    };
    (scene.image.width, scene.image.height) = (512, 512);
    scene
}

/// Criterion takes at least ten samples, so a frame of more than a second is skipped.
fn probe(scene: &Scene, settings: &Settings) -> Result<(), Box<dyn std::error::Error>> {
    let renderer = Renderer::new(settings)?;
    let began = Instant::now();
    let watch = Watch::default().while_true(move || began.elapsed() < Duration::from_secs(1));
    let cancelled = renderer.watched_by(watch).render(scene, settings);
    cancelled.map(drop).map_err(|_| "a frame takes more than a second".into())
}

fn frames(criterion: &mut Criterion) {
    let gpu = Settings { backend: Backend::Gpu, ..Settings::default() };
    let cpu = Settings { backend: Backend::Cpu, ..Settings::default() };
    for name in ["weekend", "cloud 1e4", "cloud 1e5"] {
        let scene = scene(name);
        let mut group = criterion.benchmark_group(name);
        // A frame takes long compared with the clock's resolution: few samples, flat, about two minutes in total.
        group.sample_size(10).sampling_mode(criterion::SamplingMode::Flat);
        group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(4));
        for backend in [&gpu, &cpu] {
            let mut renderer = match Renderer::new(backend) {
                Ok(renderer) => renderer,
                Err(error) => {
                    println!("SKIPPED {name} on {}: {error}", backend.backend.name());
                    continue;
                }
            };
            for accuracy in [Accuracy::Certified, Accuracy::Fast] {
                let aovs = vec![Aov::Color, Aov::Id, Aov::Distance, Aov::Normal];
                let settings = Settings { accuracy, aovs, ..backend.clone() };
                if let Err(error) = probe(&scene, &settings) {
                    println!("SKIPPED {name}/{}/{}: {error}", accuracy.name(), backend.backend.name());
                    continue;
                }
                group.bench_function(format!("{}/{}", accuracy.name(), backend.backend.name()), |bencher| {
                    bencher.iter(|| {
                        let frame = renderer.render(&scene, &settings).expect("a frame");
                        renderer.recycle(frame);
                    });
                });
            }
        }
        group.finish();
    }
}

criterion_group!(benches, frames);
criterion_main!(benches);
