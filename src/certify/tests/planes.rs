//! The claims about spheres that planes cut, compared with exact arithmetic in every mode of the adversary.

use super::claims::{Case, Judged};
use super::wild::{Mode, Value, Wild, under};
use super::worlds::{FAMILIES, Make};
use crate::certify::general::general_roots;
use crate::certify::planes::{CutLow, Kept, OUT_OF_RANGE};
use crate::certify::projected::projected_roots;
use crate::certify::{Certify, GENERAL, TERMS, Terms};
use crate::exact::Root;
use crate::scene::camera::Camera;
use crate::scene::{CutPlane, ImagePlane, Scene, Spheres};
use crate::testing::Rng;
use crate::view::ray::dot3;
use glam::DVec3;

/// Scenes of each family.
const SCENES: u64 = 400;

/// Claims that were made: hits at roots, hits on faces, misses.
#[derive(Debug, Default)]
struct Claims {
    roots: u32,
    faces: u32,
    misses: u32,
    all: u32,
}

/// A plane that is hard for the rays of a scene: through a sphere, its surface or nearly that, the eye, or along a ray.
fn plane(scene: &Scene, pixel: [u32; 2], rng: &mut Rng) -> CutPlane {
    let mut any = || DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0));
    let (mut normal, other) = (any(), any().normalize());
    let ball = scene.spheres.ball(rng.below(scene.spheres.len() as u32));
    let inset = [0.0, 1.0, 1.0 - 1e-6, 0.5][rng.below(4) as usize];
    let mut through = DVec3::from_array(ball.center) + inset * ball.radius * other;
    match rng.below(6) {
        // Of a ray of the scene, its line lies almost in the plane.
        0 => {
            let ray = super::claims::Exact::of(scene, pixel, [0.0; 3], 1.0);
            let basis = scene.camera.basis().expect("a basis");
            let along = basis.u * ray.x.value() + basis.v * ray.y.value() - basis.w;
            normal = normal.cross(along);
        }
        1 => normal = other,
        2 => through = scene.camera.eye,
        3 => normal = scene.camera.basis().expect("a basis").w,
        _ => {}
    }
    normal *= rng.decade(-3.0, 3.0);
    CutPlane { normal: normal.to_array(), distance: dot3(normal.to_array(), through.to_array()) }
}

/// Counts the claims about the cut spheres of a pixel; or returns the one that is false.
fn check<R: Value + std::fmt::Debug>(
    case: &Case,
    twin: &Certify<'_, R>,
    judged: &Judged,
    claims: &mut Claims,
) -> Result<(), String> {
    let Some(planes) = twin.planes else { return Ok(()) };
    let [i, j] = judged.at;
    let s = twin.slopes(i, j);
    let frame = (&planes.head, (twin.projection, twin.terms));
    let parts = (0..).zip(&planes.planes);
    let kept =
        parts.fold(Kept::<R>::all(twin.projection), |kept, (n, plane)| kept.cut(&s, (plane, n), frame.0, frame.1));
    let projected = twin.entries(&s).map(|entry| entry as u32);
    let generals = (0..twin.generals.len() as u32).map(|place| GENERAL | place);
    for slot in projected.chain(generals).filter(|slot| twin.rank(*slot) > 0) {
        let (place, id) = (slot & !GENERAL, twin.id(slot));
        let truth = judged.each[id as usize];
        let roots = match slot & GENERAL {
            0 => projected_roots(&s, twin.projection, &twin.projected(place as usize), twin.terms),
            _ => general_roots(&s, &twin.generals[place as usize], twin.terms),
        };
        let found = CutLow::new(&kept, &roots);
        let says = |what: &str| format!("pixel {i} {j}: sphere {id}: {what}, {truth:?}, {found:?} of {kept:?}");
        claims.all += 1;
        let Some(hit) = truth else {
            if found.at_root || found.at_face {
                return Err(says("hit"));
            }
            claims.misses += u32::from(found.low == R::MISS);
            continue;
        };
        let (depth, spare) = (case.depth(&hit), case.spare(&hit));
        if found.low == R::MISS || found.low.value() > depth + spare {
            return Err(says("not below"));
        }
        if found.at_root && hit.root == Root::Face || found.at_face && hit.root != Root::Face {
            return Err(says("elsewhere"));
        }
        if found.at_face {
            let plane = &planes.planes[kept.plane as usize];
            let answer = kept.face(id, plane.normal);
            let error = (answer.offset.value() - depth).abs();
            if answer.low.value() > depth + spare || answer.high.value() < depth - spare {
                return Err(says("not between"));
            }
            if error > answer.depth_interval.value() + spare {
                return Err(says("too far"));
            }
            let [x, y, z] = answer.normal.map(Value::value);
            let basis = case.view.basis;
            let normal = basis.u * x + basis.v * y + basis.w * z;
            if (normal - DVec3::from_array(hit.normal)).length() > 1e-6 {
                return Err(says("another plane"));
            }
        }
        claims.roots += u32::from(found.at_root);
        claims.faces += u32::from(found.at_face);
    }
    Ok(())
}

/// The claims in scenes of a family, with these constants; or the first that is false.
fn family(make: Make, terms: &Terms, claims: &mut Claims) -> Result<(), String> {
    for n in 0..SCENES {
        let mut rng = Rng((n + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut world = make(&mut rng);
        if world.scene.spheres.is_empty() {
            continue;
        }
        let count = 1 + rng.below(3);
        let pixel = world.pixels[rng.below(world.pixels.len() as u32) as usize];
        let planes: Vec<CutPlane> = (0..count).map(|_| plane(&world.scene, pixel, &mut rng)).collect();
        if planes.iter().any(|plane| plane.check(|| "a plane".into()).is_err()) {
            continue;
        }
        world.scene.spheres.cut(&planes, None).expect("planes");
        let Some(case) = Case::new(world.scene, 1e-5, &world.pixels, terms) else { continue };
        for judged in &case.judged {
            let of_f32 = case.with::<f32, _>(&case.binned, terms, |twin| check(&case, twin, judged, claims));
            of_f32.map_err(|e| format!("{n}: {e}\n{:?}", case.scene))?;
            case.with::<Wild, _>(&case.binned, terms, |twin| {
                let mut modes = (0..).zip(Mode::BLIND.into_iter().chain([Mode::Random; 3]));
                modes.try_for_each(|(k, mode)| {
                    under(mode, k, || check(&case, twin, judged, claims))
                        .map_err(|e| format!("{n} {mode:?}: {e}\n{:?}", case.scene))
                })
            })?;
        }
    }
    Ok(())
}

#[test]
fn no_claim_about_cut_spheres_is_false_however_the_device_rounds() {
    let mut total = Claims::default();
    for (name, make) in FAMILIES {
        let mut claims = Claims::default();
        family(make, &TERMS, &mut claims).unwrap_or_else(|e| panic!("{name} {e}"));
        println!("{name:18} {claims:?}");
        total.roots += claims.roots;
        total.faces += claims.faces;
        total.misses += claims.misses;
    }
    assert!(total.roots > 10_000 && total.faces > 10_000 && total.misses > 10_000, "{total:?}");
}

/// Without the roundings of f32 in the places of planes some claim is false.
#[test]
fn the_bounds_of_planes_are_needed() {
    let exact = Terms { along: [0.0; 2], ..TERMS };
    let wrong = FAMILIES.iter().filter(|(_, make)| family(*make, &exact, &mut Claims::default()).is_err());
    let wrong: Vec<&str> = wrong.map(|(name, _)| *name).collect();
    println!("{wrong:?}");
    assert!(wrong.len() > 2, "{wrong:?}");
}

/// Products of a plane's denominator and the reach of cut spheres stay within f32.
#[test]
fn planes_of_a_reach_beyond_f32_are_unknown() {
    for (far, is_known) in [(2.9e36, false), (2.9e33, true)] {
        let mut spheres = Spheres::default();
        spheres.push([0.0, 0.0, -2e-36], 1e-36, None);
        spheres.push([0.0, 0.0, -far], 0.7 * far, None);
        spheres.cut(&[CutPlane { normal: [1.0, 0.0, 0.0], distance: 0.0 }], None).expect("a plane");
        let image = ImagePlane { width: 4, height: 4, background: [0.0; 3] };
        let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() };
        let case = Case::new(scene, 1e-5, &[[1, 1]], &TERMS).expect("a frame");
        let [plane] = &case.binned.planes.as_ref().expect("planes").planes[..] else { panic!("one plane") };
        assert_eq!(plane.state & OUT_OF_RANGE == 0, is_known, "{far}: {plane:?}");
    }
}
