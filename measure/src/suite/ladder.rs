//! A wall of spheres from near to far, to measure the effect of distance alone on each method.

use super::Random;
use glam::DVec3;
use halfline::error::Result;
use halfline::scene::camera::{Camera, Lens, Look};
use halfline::scene::{ImagePlane, Scene, Spheres};

/// Distances of the nearest centre in radii. At 2 the wall fills half the space in front of the eye; the others are
/// decades.
pub const RUNGS: [f64; 11] = [2.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10];

/// Pixels along a side of each picture.
pub const SIDE: u32 = 512;

/// Spheres along a side of the wall.
const WALL: u32 = 8;

/// Distance between neighbours, in radii. Reduced by 2 JITTER they still do not touch.
const PITCH: f64 = 2.5;

/// The largest random offset of a centre along the wall in each direction, and into it, in radii.
const JITTER: f64 = 0.2;

/// The viewport's distance. Powers of ten up to 1e10 are exact in f32, so with a viewport at distance 1 t would be
/// exact, which does not happen in real scenes.
const LENS: f64 = 0.7;

/// The same offsets on every rung.
const SEED: u64 = 0x5eed_1add;

/// The rung's name.
#[must_use]
pub fn name(rung: f64) -> String {
    if rung < 100.0 { format!("{rung} radii") } else { format!("{rung:e} radii") }
}

/// 64 unit spheres in a jittered wall that fills the picture, seen along (1, 2, 3) from a distance of `rung` radii of
/// the one in the middle, which is the nearest.
///
/// # Errors
/// Errors of [`Camera::basis`]; it has none for the direction of the wall, whatever `rung` is.
pub fn scene(rung: f64) -> Result<Scene> {
    let view = DVec3::new(1.0, 2.0, 3.0).normalize();
    let mut camera = Camera { eye: DVec3::ZERO, look: Look::View(view), up: DVec3::Y, lens: Camera::CANONICAL.lens };
    let axes = camera.basis()?;
    let mut random = Random(SEED);
    let mut spheres = Spheres::default();
    let middle = WALL / 2;
    for n in 0..WALL * WALL {
        let [column, row] = [n % WALL, n / WALL];
        let [x, y, z] = if [column, row] == [middle, middle] { [0.0; 3] } else { random.cube() };
        let along = |k: u32, jitter: f64| PITCH * (f64::from(k) - f64::from(middle)) + JITTER * jitter;
        // Only into the wall, so that no sphere is nearer than the one in the middle.
        let center = axes.u * along(column, x) + axes.v * along(row, y) - axes.w * (JITTER * z.abs());
        spheres.push(center.to_array(), 1.0, Some(color(n)));
    }
    camera.eye = -view * rung;
    // The wall extends half a pitch farther to one side than to the other.
    let side = PITCH * f64::from(WALL + 1);
    camera.lens = Lens::Viewport { vw: LENS * side / rung, vh: LENS * side / rung, distance: LENS };
    let image = ImagePlane { width: SIDE, height: SIDE, background: [0.02, 0.02, 0.03] };
    Ok(Scene { camera, image, spheres, lighting: Default::default() })
}

/// Hues that differ between neighbours: multiples of the golden ratio, each primary a triangle wave of the hue.
fn color(n: u32) -> [f32; 3] {
    let hue = f64::from(n) * 0.618_033_988_749_895;
    [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|shift| (0.25 + 1.4 * ((hue + shift).fract() - 0.5).abs()) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rung_is_a_full_wall_without_overlaps_at_its_distance() {
        for rung in RUNGS {
            let scene = scene(rung).expect("a scene");
            scene.check().expect("a good scene");
            let centers: Vec<_> = scene.spheres.centers.iter().map(|c| DVec3::from_array(*c)).collect();
            assert_eq!(centers.len(), 64);
            let nearest = centers.iter().map(|c| c.distance(scene.camera.eye)).fold(f64::INFINITY, f64::min);
            assert!((nearest / rung - 1.0).abs() < 1e-12, "{rung}: {nearest}");
            for (n, a) in centers.iter().enumerate() {
                assert!(centers[..n].iter().all(|b| a.distance(*b) > 2.0), "{rung}: sphere {n} touches another");
            }
            let judge = halfline::exact::Judge::new(&scene).expect("a judge");
            assert_eq!(judge.pixel(SIDE / 2, SIDE / 2).map(|truth| truth.id), Some(36), "the middle one");
            let found: std::collections::BTreeSet<_> = (0..SIDE * SIDE)
                .step_by(7)
                .filter_map(|k| judge.pixel(k / SIDE, k % SIDE).map(|truth| truth.id))
                .collect();
            // At a small distance, spheres at the edge hide others behind them.
            assert!(found.len() >= if rung > 2.0 { 64 } else { 40 }, "{rung}: {} seen", found.len());
        }
    }
}
