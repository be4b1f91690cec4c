//! Groups of spheres: each claim about a box holds for every sphere in it.

use crate::certify::TERMS;
use crate::certify::projection::ProjectionBounds;
use crate::certify::projection::enclose::Enclosed;
use crate::certify::projection::stage::Staged;
use crate::exact::Judge;
use crate::scene::Scene;
use crate::scene::camera::Lens;
use crate::scene::instances::enclosure::Enclosure;
use crate::testing::Rng;
use crate::view::View;
use crate::{Camera, ImagePlane, Spheres};
use glam::DVec3;

const SIZE: [u32; 2] = [93, 61];

/// Boxes at all distances around an eye, each with spheres at its corners and within, of the least and the largest radius.
fn boxes(rng: &mut Rng, camera: &Camera, lens: &Lens) -> Vec<(Enclosure, Spheres)> {
    let narrow = match lens {
        Lens::Vfov { degrees, .. } => degrees.to_radians() / 2.0,
        _ => 0.5,
    };
    let mut each = || {
        let depth = rng.decade(-1.0, 5.0) * if rng.between(0.0, 1.0) < 0.1 { -1.0 } else { 1.0 };
        let [x, y] = [0, 1].map(|_| rng.between(-2.0, 2.0) * depth * narrow);
        let middle = camera.eye + DVec3::new(x, y, -depth);
        let half = DVec3::from_array([0, 1, 2].map(|_| rng.decade(-5.0, 0.0) * depth.abs() * narrow));
        let radii = [rng.decade(-5.0, -0.5), rng.decade(-5.0, -0.5)].map(|r| r * depth.abs() * narrow);
        let radii = [radii[0].min(radii[1]), radii[0].max(radii[1])];
        let mut spheres = Spheres::default();
        for n in 0..16 {
            let mut side =
                |k: usize| if n < 8 { if n >> k & 1 == 0 { -1.0 } else { 1.0 } } else { rng.between(-1.0, 1.0) };
            let sides = DVec3::new(side(0), side(1), side(2));
            spheres.push((middle + half * sides).to_array(), radii[(n + n / 4) % 2], None);
        }
        let around = spheres.centers.iter().zip(&spheres.radii);
        (around.fold(Enclosure::NOTHING, |all, (c, r)| all.with(&Enclosure::of(*c, *r))), spheres)
    };
    (0..4000).map(|_| each()).collect()
}

/// The faults of the claims about a box, and which claims were made.
fn faults(lens: &ProjectionBounds, around: &Enclosure, spheres: &Spheres) -> (usize, usize) {
    let (claim, [near, far]) = (lens.enclose(around), lens.depths(around));
    let mut faults = 0;
    for (center, radius) in spheres.centers.iter().zip(&spheres.radii) {
        let right = match (&claim, lens.stage(0, *center, *radius, 0.0)) {
            (Enclosed::Unseen, staged) => matches!(staged, Staged::Unseen),
            (Enclosed::Projected { .. }, Staged::Unseen) => true,
            (Enclosed::Projected { .. }, Staged::General(_)) => false,
            (Enclosed::Projected { least, pixels }, Staged::Projected(landed)) => {
                let inside = |k: usize| {
                    let ([first, last], [from, to]) = (landed.pixels[k], pixels[k]);
                    from <= first && last <= to
                };
                inside(0) && inside(1) && *least <= landed.bin.chunk_min_depth
            }
            (Enclosed::Missed, staged) => !matches!(staged, Staged::Projected(_)),
            (Enclosed::Unknown, _) => true,
        };
        let depth = match lens.stage(0, *center, *radius, 0.0) {
            Staged::Projected(landed) => Some(landed.placed.depth),
            _ => None,
        };
        faults += usize::from(!right || depth.is_some_and(|depth| depth < near || depth > far));
    }
    let kind = match claim {
        Enclosed::Unseen => 0,
        Enclosed::Projected { .. } => 1,
        Enclosed::Unknown => 2,
        Enclosed::Missed => 3,
    };
    (faults, kind)
}

fn lenses() -> [Lens; 5] {
    let vfov = |degrees| Lens::Vfov { degrees, distance: 1.0 };
    [vfov(40.0), vfov(0.01), vfov(1e-7), vfov(120.0), Lens::Orthographic { height: 50.0 }]
}

fn scene(lens: Lens) -> Scene {
    let camera = Camera { eye: DVec3::new(1e3, -20.0, 7.0), up: DVec3::new(0.2, 1.0, 0.1), lens, ..Camera::CANONICAL };
    let image = ImagePlane { width: SIZE[0], height: SIZE[1], background: [0.0; 3] };
    let mut spheres = Spheres::default();
    spheres.push((camera.eye + DVec3::new(0.0, 0.0, -100.0)).to_array(), 1.0, None);
    Scene { camera, image, spheres, lighting: Default::default() }
}

#[test]
fn what_holds_for_a_box_holds_for_its_spheres() {
    let mut rng = Rng(11);
    let (mut kinds, mut smaller) = ([0; 4], 0);
    for lens in lenses() {
        let scene = scene(lens);
        let view = View::new(&scene).expect("a view");
        let projection = ProjectionBounds::new(&scene.camera, &view, SIZE, &TERMS).expect("a lens");
        for (around, spheres) in boxes(&mut rng, &scene.camera, &lens) {
            let (found, kind) = faults(&projection, &around, &spheres);
            assert_eq!(found, 0, "{lens:?} {around:?}");
            kinds[kind] += 1;
            // Negative control: a box that is too small by a hundredth, or radii that are.
            let less = (around.high - around.low) / 200.0;
            let shrunk = Enclosure { low: around.low + less, high: around.high - less, ..around };
            let thin = Enclosure { radii: around.radii.map(|r| r * 0.99), ..around };
            smaller += usize::from(faults(&projection, &shrunk, &spheres).0 > 0);
            smaller += usize::from(faults(&projection, &thin, &spheres).0 > 0);
        }
    }
    println!("unseen, projected, unknown, missed: {kinds:?}; too small and found so: {smaller}");
    assert!(kinds[..3].iter().all(|count| *count > 100) && kinds[3] > 0 && smaller > 1000, "{kinds:?} {smaller}");
}

/// A box that is missed is missed by every ray in exact arithmetic, also by spheres that are wider by a 32nd of their distance,
/// behind the eye too.
#[test]
fn missed_boxes_are_missed_by_a_margin() {
    let mut rng = Rng(13);
    let mut missed = 0;
    for lens in [Lens::Vfov { degrees: 40.0, distance: 1.0 }, Lens::Vfov { degrees: 110.0, distance: 1.0 }] {
        let mut scene = scene(lens);
        let view = View::new(&scene).expect("a view");
        let projection = ProjectionBounds::new(&scene.camera, &view, SIZE, &TERMS).expect("a lens");
        let boxes = boxes(&mut rng, &scene.camera, &lens);
        for (_, spheres) in boxes.iter().filter(|(around, _)| projection.misses(around)).take(40) {
            scene.spheres = spheres.clone();
            let eye = scene.camera.eye;
            for (center, radius) in spheres.centers.iter().zip(scene.spheres.radii.to_mut()) {
                *radius += DVec3::from_array(*center).distance(eye) / 32.0;
            }
            let judge = Judge::new(&scene).expect("a judge");
            let all: Vec<u32> = (0..spheres.len() as u32).collect();
            let pixels = (0..SIZE[1]).step_by(6).flat_map(|i| (0..SIZE[0]).step_by(4).map(move |j| (i, j)));
            for (i, j) in pixels.chain([(0, 0), (SIZE[1] - 1, SIZE[0] - 1)]) {
                assert!(judge.among(i, j, &all).is_none(), "{lens:?} {i} {j}");
            }
            missed += 1;
        }
    }
    assert!(missed > 50, "{missed}");
}
