//! The candidate search of a certified frame: the view, and the stage that bins and sorts the spheres of a cloud into
//! tiles of 512 x 512 pixels. It runs on the host for both backends.
//!
//! ```sh
//! cargo bench --bench search
//! ```

mod stages;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use halfline::{Accuracy, Aov, Backend, Settings};

fn searches(criterion: &mut Criterion) {
    let settings =
        Settings { accuracy: Accuracy::Certified, backend: Backend::Cpu, aovs: vec![Aov::Id], ..Settings::default() };
    let Some(mut renderer) = stages::renderer(&settings) else { return };
    let mut group = stages::group(criterion, "search");
    for count in ["1e4", "1e5", "1e6"] {
        let scene = stages::scene(count.parse::<f64>().expect("a count") as usize);
        group.throughput(Throughput::Elements(scene.spheres.len() as u64));
        stages::bench(&mut group, count, &mut renderer, (&scene, &settings), |report| {
            report.stages_ms["view"] + report.stages_ms["stage"]
        });
    }
    group.finish();
}

criterion_group!(benches, searches);
criterion_main!(benches);
