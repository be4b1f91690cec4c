//! Frames have the bits of the CPU path's frame of all spheres whatever power of two numbers are counted in: on an adapter, which takes its
//! unit from the box of all spheres, and in streams and parts, whose first block has another unit than the whole. Lenses down to 2^-100,
//! scenes from 2^-90 to 2^90, spheres up to 2^60 from each other in one frame.

use crate::adapter::cpu;
use crate::amount::amount;
use crate::bits::differing;
use crate::rng::Rng;
use crate::splat::Both;
use crate::stream::{blocks, settings};
use halfline::camera::{Camera, Lens};
use halfline::error::Result;
use halfline::render::stream::{Stream, Visible};
use halfline::scene::{ImagePlane, Scene, Spheres};

/// A whole number from `least` to `most`.
fn between(rng: &mut Rng, least: i32, most: i32) -> i32 {
    least + rng.below((most - least + 1) as usize) as i32
}

/// Spheres along the axis of a lens, most of them in sight, by depth: nearest or farthest first, so that the first ones have a unit of their
/// own, and one behind the eye or aside, of another size. Depths and distances span up to 2^`most`.
fn scene(rng: &mut Rng, most: i32) -> Scene {
    // Depths within a quarter of each other have a reference depth.
    let span = if rng.below(3) == 0 { 0 } else { between(rng, 0, most) };
    // A pixel is 2^-4 of this as a slope, and lengths of it are out of range below 2^-80 of the unit.
    let exponent = if rng.below(4) > 0 { between(rng, -94, -20) } else { between(rng, -100, 0) };
    // Many deep ones: some are hidden, in range in the unit of their part and not in the unit of all.
    let is_deep = rng.below(2) == 0;
    let (span, count) = if is_deep { (most, between(rng, 150, 250)) } else { (span, between(rng, 2, 100)) };
    let narrow = 2f64.powi(exponent);
    let world = 2f64.powi(between(rng, -90, 90));
    let is_parallel = rng.below(4) == 0;
    let lens = match is_parallel {
        true => Lens::Orthographic { height: narrow * world },
        false => Lens::Viewport { vw: narrow, vh: narrow, distance: 1.0 },
    };
    let depth = |rng: &mut Rng| world * 2f64.powf((0.1 + f64::from(span)) * rng.unit());
    let mut depths: Vec<f64> = (0..count).map(|_| depth(rng)).collect();
    depths.sort_unstable_by(f64::total_cmp);
    if rng.below(2) == 0 {
        depths.reverse();
    }
    let mut spheres = Spheres::default();
    let far = world * 2f64.powi(between(rng, -most / 2, most / 2));
    let ahead = if rng.below(2) == 0 { far } else { -far * 2f64.powi(between(rng, -most / 2, 0)) };
    let (far_center, is_first) = ([far, far, ahead], rng.below(2) == 0);
    if is_first && !is_deep {
        spheres.push(far_center, 0.5 * far.min(world), None);
    }
    for depth in depths {
        let across = if is_parallel { narrow * world } else { narrow * depth };
        let [x, y, _] = rng.cube();
        spheres.push([0.6 * x * across, 0.6 * y * across, -depth], across * 2f64.powf(-8.0 * rng.unit()), None);
    }
    if !is_first && !is_deep {
        spheres.push(far_center, 0.5 * far.min(world), None);
    }
    let camera = Camera { lens, ..Camera::CANONICAL };
    Scene {
        camera,
        image: ImagePlane { width: 16, height: 12, background: [0.0; 3] },
        spheres,
        lighting: Default::default(),
    }
}

#[test]
fn an_adapter_has_the_bits_of_the_cpu_path_in_any_unit() {
    let Some(mut both) = Both::new() else { return };
    let mut rng = Rng::new(0x1e);
    let mut hits = 0;
    for case in 0..amount("units on an adapter", [50, 150, 1500]) {
        let scene = scene(&mut rng, 60);
        let settings = settings();
        hits += both.compare(&format!("{case}: {:?}", scene.camera.lens), &scene, &settings).report.hits;
    }
    assert!(hits > 500, "{hits}");
    let most = both.compared / 2;
    both.done(most);
}

/// The spheres that a stream keeps of a scene's spheres, in blocks of 7; an error if they are too far apart.
fn streamed(scene: &Scene) -> Result<Visible> {
    let mut stream = Stream::new(scene, &settings())?;
    blocks(&scene.spheres, 7).try_for_each(|block| stream.add(&block))?;
    stream.finish()
}

/// The same of two parts, the second one first in every other case.
fn in_parts(scene: &Scene, is_reversed: bool) -> Result<Visible> {
    let half = scene.spheres.len() / 2;
    let mut parts = Vec::new();
    for (first, block) in [0, half].into_iter().zip(halves(&scene.spheres, half)) {
        let mut stream = Stream::of_part(scene, &settings(), first as u64)?;
        stream.add(&block)?;
        parts.push(stream.part()?);
    }
    if is_reversed {
        parts.reverse();
    }
    parts[0].clone().combine(&parts[1])?.visible(scene, &settings())
}

fn halves(spheres: &Spheres, half: usize) -> [Spheres; 2] {
    let mut halves = [Spheres::default(), Spheres::default()];
    for (n, (center, radius)) in spheres.centers.iter().zip(spheres.radii.iter()).enumerate() {
        halves[usize::from(n >= half)].push(*center, *radius, None);
    }
    halves
}

#[test]
fn streams_and_parts_have_the_bits_of_memory_in_any_unit() {
    let mut renderer = cpu();
    let mut rng = Rng::new(0x5e);
    let [mut hits, mut compared, mut refused] = [0; 3];
    for case in 0..amount("units of streams", [50, 150, 1500]) {
        let scene = scene(&mut rng, 120);
        let whole = renderer.render(&scene, &settings()).expect("a frame");
        for (way, visible) in [("streamed", streamed(&scene)), ("in parts", in_parts(&scene, case % 2 == 0))] {
            let Ok(visible) = visible else {
                refused += 1;
                continue;
            };
            let mut frame = renderer.render(&visible.scene, &settings()).expect("a frame");
            visible.ids.restore(&mut frame);
            let differ = differing(&whole, &frame);
            let lens = scene.camera.lens;
            assert!(differ.is_empty(), "{case}: {} spheres, {lens:?}, {way}: {differ:?} differ", scene.spheres.len());
            compared += 1;
            hits += whole.report.hits;
        }
    }
    println!("{compared} frames compared, {refused} refused because spheres are too far apart");
    assert!(hits > 500 && 2 * refused < compared, "{hits} {refused}");
}
