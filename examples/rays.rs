//! Times given rays: `rays SPHERES RAYS BACKEND ACCURACY REPEATS [OUT]`, files as of benches/peers/embree_rays.cpp.
//! Prints one line of JSON, times in milliseconds; t (f64) and id (i32) go to OUT.

use halfline::{Accuracy, Backend, Rays, Renderer, Settings, Spheres};
use std::io::Write;
use std::time::Instant;

fn floats(name: &str) -> Vec<f64> {
    let bytes = std::fs::read(name).expect("a file of f32");
    bytes.chunks_exact(4).map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))).collect()
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut spheres = Spheres::default();
    for s in floats(&arguments[0]).chunks_exact(4) {
        spheres.push([s[0], s[1], s[2]], s[3], None);
    }
    let rays = floats(&arguments[1]);
    let origins: Vec<[f64; 3]> = rays.chunks_exact(6).map(|r| [r[0], r[1], r[2]]).collect();
    let directions: Vec<[f64; 3]> = rays.chunks_exact(6).map(|r| [r[3], r[4], r[5]]).collect();
    let backend: Backend = arguments[2].parse().expect("a backend");
    let accuracy: Accuracy = arguments[3].parse().expect("an accuracy");
    let repeats: usize = arguments[4].parse().expect("a count");
    let settings = Settings { backend, accuracy, ..Settings::default() };
    let mut renderer = Renderer::new(&settings).expect("a renderer");
    let mut tracer = renderer.tracer(&spheres, &settings).expect("a tracer");
    let rays = Rays { origins: &origins, directions: &directions, limits: &[] };
    let (mut nearest, mut any) = (Vec::new(), Vec::new());
    let mut hits = None;
    for _ in 0..repeats {
        let start = Instant::now();
        hits = Some(tracer.hits(&rays).expect("hits"));
        nearest.push(start.elapsed().as_secs_f64() * 1e3);
    }
    for _ in 0..repeats {
        let start = Instant::now();
        tracer.occluded(&rays).expect("answers");
        any.push(start.elapsed().as_secs_f64() * 1e3);
    }
    let hits = hits.expect("hits");
    let settled = hits.certainty.iter().filter(|c| **c == 1).count();
    let met = hits.id.iter().filter(|id| **id >= 0).count();
    println!(
        "{{\"build_ms\": {:.1}, \"nearest_ms\": {nearest:.1?}, \"any_ms\": {any:.1?}, \"hits\": {met}, \"settled\": {settled}}}",
        tracer.build_ms()
    );
    if let Some(out) = arguments.get(5) {
        let mut file = std::io::BufWriter::new(std::fs::File::create(out).expect("a file"));
        for t in &hits.t {
            file.write_all(&t.to_le_bytes()).expect("space");
        }
        for id in &hits.id {
            file.write_all(&id.to_le_bytes()).expect("space");
        }
    }
}
