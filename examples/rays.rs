//! Given rays, for measurements: makes files of spheres and rays, and times them. benches/peers/rays compares with Embree.
//!
//! ```sh
//! cargo run --release --example rays -- make cloud 1e6 SPHERES    # equal spheres uniform in the unit cube
//! cargo run --release --example rays -- make inside 1e6 RAYS      # from points in the cube, in any direction
//! cargo run --release --example rays -- make outside 1e6 RAYS     # from points 3 away, to points in the cube
//! cargo run --release --example rays -- time SPHERES RAYS cpu certified 4 [HITS]
//! cargo run --release --example rays -- check SPHERES RAYS cpu    # certified against exact, asked about every sphere
//! ```
//!
//! Files hold f32: x y z r, or ox oy oz dx dy dz. `time` prints a line of JSON with milliseconds: to set up the spheres,
//! and of each call for the nearest hits and for any hits. HITS gets t (f64) and id (i32) of all rays.

mod cloud;

use halfline::{Accuracy, Aov, Backend, Hits, Rays, Renderer, Search, Settings, Spheres};
use std::error::Error;
use std::f64::consts::TAU;
use std::io::Write;
use std::time::Instant;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["make", kind, count, file] => make(kind, count.parse::<f64>()? as usize, file),
        ["time", spheres, rays, backend, accuracy, repeats] => {
            time([spheres, rays], backend.parse()?, accuracy.parse()?, repeats.parse()?, None)
        }
        ["time", spheres, rays, backend, accuracy, repeats, hits] => {
            time([spheres, rays], backend.parse()?, accuracy.parse()?, repeats.parse()?, Some(hits))
        }
        ["check", spheres, rays, backend] => check([spheres, rays], backend.parse()?),
        _ => Err("see the head of examples/rays.rs".into()),
    }
}

fn make(kind: &str, count: usize, file: &str) -> Outcome<()> {
    let mut state = 77u64;
    // xorshift64* (Vigna 2016).
    let mut next = || {
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    };
    let on_sphere = |next: &mut dyn FnMut() -> f64| {
        let (z, angle) = (2.0 * next() - 1.0, TAU * next());
        let r = (1.0 - z * z).sqrt();
        [r * angle.cos(), r * angle.sin(), z]
    };
    let mut out = std::io::BufWriter::new(std::fs::File::create(file)?);
    let mut row = |numbers: &[f64]| numbers.iter().try_for_each(|x| out.write_all(&(*x as f32).to_le_bytes()));
    match kind {
        "cloud" => {
            let spheres = cloud::cloud(count).spheres;
            for (c, r) in spheres.centers.iter().zip(&spheres.radii) {
                row(&[c[0], c[1], c[2], *r])?;
            }
        }
        "inside" => {
            for _ in 0..count {
                let origin = [next(), next(), next()];
                row(&origin)?;
                row(&on_sphere(&mut next))?;
            }
        }
        "outside" => {
            for _ in 0..count {
                let origin = on_sphere(&mut next).map(|x| 0.5 + 3.0 * x);
                let to = [next(), next(), next()];
                let way: [f64; 3] = std::array::from_fn(|k| to[k] - origin[k]);
                let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
                row(&origin)?;
                row(&way.map(|x| x / length))?;
            }
        }
        _ => return Err(format!("no kind {kind}: cloud, inside, outside").into()),
    }
    Ok(out.flush()?)
}

fn floats(name: &str) -> Outcome<Vec<f64>> {
    let number = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    Ok(std::fs::read(name)?.chunks_exact(4).map(number).collect())
}

/// Spheres, and origins and directions of rays.
type Input = (Spheres, Vec<[f64; 3]>, Vec<[f64; 3]>);

fn input([spheres, rays]: [&str; 2]) -> Outcome<Input> {
    let mut scene = Spheres::default();
    for s in floats(spheres)?.chunks_exact(4) {
        scene.push([s[0], s[1], s[2]], s[3], None);
    }
    let rays = floats(rays)?;
    let three = |first: usize| rays.chunks_exact(6).map(|r| [r[first], r[first + 1], r[first + 2]]).collect();
    Ok((scene, three(0), three(3)))
}

/// Compares certified answers with exact ones, for which every ray asks every sphere.
fn check(files: [&str; 2], backend: Backend) -> Outcome<()> {
    let (scene, origins, directions) = input(files)?;
    let mut renderer = Renderer::new(&Settings { backend, ..Settings::default() })?;
    let mut trace = |accuracy, search, origins: &[[f64; 3]], directions: &[[f64; 3]]| {
        let settings = Settings { backend, accuracy, search, aovs: vec![Aov::Normal], ..Settings::default() };
        let rays = Rays { origins, directions, limits: &[] };
        let mut tracer = renderer.tracer(&scene, &settings)?;
        let answers = (tracer.hits(&rays)?, tracer.occluded(&rays)?);
        Ok::<_, halfline::Error>(answers)
    };
    let (mut wrong, mut settled, mut hits, mut worst) = (0, 0, 0, [0.0f64; 2]);
    for (origins, directions) in origins.chunks(1 << 18).zip(directions.chunks(1 << 18)) {
        let (ours, any) = trace(Accuracy::Certified, Search::Tree, origins, directions)?;
        let (truth, _) = trace(Accuracy::Exact, Search::All, origins, directions)?;
        for n in 0..truth.id.len() {
            let hit = truth.id[n] >= 0;
            settled += usize::from(ours.certainty[n] == 1);
            hits += usize::from(hit);
            wrong += usize::from(ours.id[n] != truth.id[n] || any.hit[n] != u8::from(hit));
            if hit {
                worst[0] = worst[0].max((ours.t[n] - truth.t[n]).abs() / truth.t[n]);
                let normal = |hits: &Hits| hits.normal.as_ref().map_or([0.0; 3], |normals| normals[n]);
                let off: f64 = normal(&ours).iter().zip(normal(&truth)).map(|(a, b)| f64::from(a - b).powi(2)).sum();
                worst[1] = worst[1].max(off.sqrt());
            }
        }
    }
    println!(
        "{{\"rays\": {}, \"hits\": {hits}, \"wrong\": {wrong}, \"settled\": {settled}, \"worst_t\": {:e}, \"worst_normal\": {:e}}}",
        origins.len(),
        worst[0],
        worst[1]
    );
    Ok(())
}

fn time(files: [&str; 2], backend: Backend, accuracy: Accuracy, repeats: usize, file: Option<&str>) -> Outcome<()> {
    let (scene, origins, directions) = input(files)?;
    let rays = Rays { origins: &origins, directions: &directions, limits: &[] };
    let settings = Settings { backend, accuracy, ..Settings::default() };
    let mut renderer = Renderer::new(&settings)?;
    let mut tracer = renderer.tracer(&scene, &settings)?;
    let (mut nearest, mut any) = (Vec::new(), Vec::new());
    let mut hits = tracer.hits(&Rays::default())?;
    for _ in 0..repeats {
        let start = Instant::now();
        hits = tracer.hits(&rays)?;
        nearest.push(start.elapsed().as_secs_f64() * 1e3);
        let start = Instant::now();
        tracer.occluded(&rays)?;
        any.push(start.elapsed().as_secs_f64() * 1e3);
    }
    let settled = hits.certainty.iter().filter(|c| **c == 1).count();
    let met = hits.id.iter().filter(|id| **id >= 0).count();
    println!(
        "{{\"adapter\": {:?}, \"build_ms\": {:.1}, \"nearest_ms\": {nearest:.1?}, \"any_ms\": {any:.1?}, \"hits\": {met}, \
         \"settled\": {settled}}}",
        tracer.adapter(),
        tracer.build_ms()
    );
    if let Some(file) = file {
        let mut out = std::io::BufWriter::new(std::fs::File::create(file)?);
        hits.t.iter().try_for_each(|t| out.write_all(&t.to_le_bytes()))?;
        hits.id.iter().try_for_each(|id| out.write_all(&id.to_le_bytes()))?;
        out.flush()?;
    }
    Ok(())
}
