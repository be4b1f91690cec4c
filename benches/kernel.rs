//! The time of the kernel only: ids of 512 spheres in 512 x 512 pixels, by the adapter's clock if it has one; on the
//! CPU path the stage `trace`. Methods that test all spheres are also reported in ray-sphere tests per second.
//!
//! ```sh
//! cargo bench --bench kernel             # a minute
//! cargo bench --bench kernel -- --quick
//! ```

mod stages;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use halfline::{Accuracy, Aov, Backend, Method, Settings};
use stages::SIDE;

const SPHERES: usize = 512;

fn kernels(criterion: &mut Criterion) {
    let scene = stages::scene(SPHERES);
    let ids = Settings { aovs: vec![Aov::Id], ..Settings::default() };
    let stable = Settings { method: Some(Method::Stable), ..ids.clone() };
    let certified = Settings { accuracy: Accuracy::Certified, ..ids };
    let mut group = stages::group(criterion, "kernel");
    for backend in [Backend::Gpu, Backend::Cpu] {
        for (name, settings) in [("stable", &stable), ("certified", &certified)] {
            let settings = Settings { backend, ..settings.clone() };
            let Some(mut renderer) = stages::renderer(&settings) else { continue };
            let pixels = u64::from(SIDE) * u64::from(SIDE);
            // Of a certified frame the number of tests is not known, because a list is left after its hit: only pixels are
            // counted.
            let tests_per_pixel = if settings.method.is_some() { SPHERES as u64 } else { 1 };
            group.throughput(Throughput::Elements(pixels * tests_per_pixel));
            stages::bench(&mut group, name, &mut renderer, (&scene, &settings), |report| {
                report.kernel_ms.last().copied().unwrap_or_else(|| report.stages_ms["trace"])
            });
        }
    }
    group.finish();
}

criterion_group!(benches, kernels);
criterion_main!(benches);
