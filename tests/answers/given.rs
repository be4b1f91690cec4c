//! The promise: certified given rays agree with exact arithmetic: which sphere is hit first, if any, t within 1e-5 of
//! itself, the normal within 1e-3 rad, within exact limits. This holds in any order, from a tree or without.

use crate::adapter::{cpu, renderers};
use crate::given_families::{Family, families};
use crate::rng::Rng;
use glam::DVec3;
use halfline::frame::Aov;
use halfline::scene::{CutPlane, Spheres};
use halfline::settings::{Accuracy, Backend, Search, Settings};
use halfline::{Hits, Occlusion, Rays, Renderer};

fn settings(accuracy: Accuracy, search: Search) -> Settings {
    Settings { accuracy, search, aovs: vec![Aov::Normal, Aov::Bound], ..Settings::default() }
}

fn rays(family: &Family) -> Rays<'_> {
    Rays { origins: &family.origins, directions: &family.directions, limits: &family.limits }
}

fn trace(renderer: &mut Renderer, family: &Family, accuracy: Accuracy, search: Search) -> (Hits, Occlusion) {
    let backend = if renderer.is_gpu() { Backend::Gpu } else { Backend::Auto };
    let settings = Settings { backend, ..settings(accuracy, search) };
    let mut tracer = renderer.tracer(&family.spheres, &settings).expect("valid spheres");
    assert!(!tracer.is_gpu() && tracer.warning().is_none() && tracer.adapter() == "cpu");
    let rays = rays(family);
    (tracer.hits(&rays).expect("valid rays"), tracer.occluded(&rays).expect("valid rays"))
}

/// Compares certified answers with the exact ones; returns the share that was settled.
fn compare(place: &str, family: &Family, certified: &(Hits, Occlusion), exact: &(Hits, Occlusion)) -> f64 {
    let ((hits, any), (truth, blocked)) = (certified, exact);
    let (normals, true_normals) = (hits.normal.as_ref().expect("requested"), truth.normal.as_ref().expect("requested"));
    let bounds = [hits, truth].map(|hits| hits.bound.as_ref().expect("requested"));
    let mut worst = (0.0f64, 0.0f64);
    for n in 0..truth.id.len() {
        let what = format!(
            "{place}, {}, ray {n}: {:?} + t {:?}, t < {}",
            family.name, family.origins[n], family.directions[n], family.limits[n]
        );
        assert_eq!(hits.id[n], truth.id[n], "{what}, t {} and {}", hits.t[n], truth.t[n]);
        assert_eq!((any.hit[n], blocked.hit[n]), (u8::from(truth.id[n] >= 0), u8::from(truth.id[n] >= 0)), "{what}");
        assert!(hits.certainty[n] <= 1 && any.certainty[n] <= 1, "{what}: {}", hits.certainty[n]);
        if truth.id[n] < 0 {
            assert_eq!((hits.t[n], hits.distance[n], normals[n]), (f64::INFINITY, f64::INFINITY, [0.0; 3]), "{what}");
            assert_eq!(bounds[0][n], 0.0, "{what}");
            continue;
        }
        // The distance of the judge is rounded too. Beyond f64 it is +inf.
        let off = if truth.distance[n].is_finite() { (hits.distance[n] - truth.distance[n]).abs() } else { 0.0 };
        assert!(off <= bounds[0][n] + bounds[1][n], "{what}: off {off:e}, {:e} proved", bounds[0][n]);
        // Below the normal numbers f64 itself has less precision.
        let off = |a: f64, b: f64| if b.abs() < 1e-300 || b.is_infinite() { 0.0 } else { (a - b).abs() / b };
        let error = off(hits.t[n], truth.t[n]).max(off(hits.distance[n], truth.distance[n]));
        let [a, b] = [normals[n], true_normals[n]].map(|x| DVec3::from_array(x.map(f64::from)));
        worst = (worst.0.max(error), worst.1.max((a - b).length()));
        assert!(error <= 1e-5, "{what}: t {} and {}", hits.t[n], truth.t[n]);
        assert!((a - b).length() <= 1e-3, "{what}: normals {a} and {b}");
    }
    let settled = |certainty: &[u8]| certainty.iter().filter(|c| **c == 1).count() as f64 / certainty.len() as f64;
    println!(
        "{place}, {}: {} rays, settled {:.4} and {:.4}, worst t {:.1e}, worst normal {:.1e} rad",
        family.name,
        hits.id.len(),
        settled(&hits.certainty),
        settled(&any.certainty),
        worst.0,
        worst.1
    );
    settled(&hits.certainty)
}

#[test]
fn certified_rays_are_exact_at_the_extremes() {
    for family in families(1, 2000) {
        let exact = trace(&mut cpu(), &family, Accuracy::Exact, Search::All);
        assert_eq!(
            exact,
            {
                let (mut hits, any) = trace(&mut cpu(), &family, Accuracy::Exact, Search::Tree);
                hits.search = Search::All;
                (hits, any)
            },
            "{}: the tree loses nothing",
            family.name
        );
        for search in [Search::Tree, Search::All] {
            let certified = trace(&mut cpu(), &family, Accuracy::Certified, search);
            compare(search.name(), &family, &certified, &exact);
        }
    }
}

/// The families with planes that are hard for their rays: through points of rays, origins, centres and tangents, along rays, in pairs.
fn cut_families() -> Vec<Family> {
    let mut all = families(4, 1000);
    for (k, family) in all.iter_mut().enumerate() {
        let mut rng = Rng::new(0xc07 + k as u64);
        let (hits, _) = trace(&mut cpu(), family, Accuracy::Certified, Search::Tree);
        let met: Vec<usize> = (0..hits.id.len()).filter(|n| hits.id[*n] >= 0 && hits.t[*n].is_finite()).collect();
        let Some(&ray) = met.get(rng.below(met.len().max(1))) else { continue };
        let [origin, along] = [family.origins[ray], family.directions[ray]].map(DVec3::from_array);
        let ball = hits.id[ray] as usize;
        let (center, radius) = (DVec3::from_array(family.spheres.centers[ball]), family.spheres.radii[ball]);
        let (any, unit) = (DVec3::from_array(rng.cube()), along / along.abs().max_element());
        let plane = |normal: DVec3, point: DVec3| CutPlane { normal: normal.into(), distance: normal.dot(point) };
        let hit = origin + along * hits.t[ray];
        let planes = [
            vec![plane(any, hit)],
            vec![plane(unit, center)],
            vec![plane(-unit, center)],
            vec![plane(any.cross(unit), origin)],
            vec![plane(DVec3::X, center + DVec3::X * radius)],
            vec![plane(-unit, center), plane(-unit + 1e-9 * any, center)],
            vec![plane(any, center), plane(-any, center - any * radius)],
        ];
        let planes: Vec<CutPlane> =
            planes[k % 7].iter().copied().filter(|plane| plane.check(Default::default).is_ok()).collect();
        let may: Vec<bool> = (0..family.spheres.len()).map(|n| n % 7 != 3).collect();
        family.spheres.cut(&planes, Some(&may)).expect("planes");
    }
    all.retain(|family| family.spheres.cuts.is_some());
    all
}

/// Given rays among spheres that planes cut: ids, t, normals and limits of the judge's, from a tree and without.
#[test]
fn rays_among_cut_spheres_are_exact() {
    let (mut rays, mut families) = (0, 0);
    for mut family in cut_families() {
        families += 1;
        for round in 0..2 {
            let exact = trace(&mut cpu(), &family, Accuracy::Exact, Search::All);
            for search in [Search::Tree, Search::All] {
                let certified = trace(&mut cpu(), &family, Accuracy::Certified, search);
                compare(&format!("cut {round} {}", search.name()), &family, &certified, &exact);
            }
            rays += family.limits.len();
            // Then with limits at and beside the hits.
            for (n, limit) in family.limits.iter_mut().enumerate() {
                let t = if exact.0.id[n] < 0 { 1.0 } else { exact.0.t[n] };
                *limit = [t, t.next_up(), t.next_down(), t * 0.5, t * 1.5][n % 5];
            }
        }
    }
    println!("{rays} rays of {families} families");
    assert!(families > 5, "{families}");
}

/// Certified given rays are traced on the CPU path with every backend. A method does not know cut spheres.
#[test]
fn certified_rays_are_traced_on_the_host() {
    let cut = cut_families().swap_remove(0);
    let family = families(6, 300).swap_remove(0);
    let truth = trace(&mut cpu(), &family, Accuracy::Certified, Search::Auto);
    for (backend, mut renderer) in renderers() {
        assert!(trace(&mut renderer, &family, Accuracy::Certified, Search::Auto) == truth, "{backend:?}");
        let fast = Settings { backend, ..settings(Accuracy::Fast, Search::Auto) };
        let error = renderer.tracer(&cut.spheres, &fast).map(drop).expect_err("a method").to_string();
        assert!(error.contains("planes cut some spheres"), "{error}");
    }
}

/// Limits at, just above and just below the exact t of every hit, and between.
#[test]
fn limits_are_exact() {
    for mut family in families(2, 1000) {
        let (truth, _) = trace(&mut cpu(), &family, Accuracy::Exact, Search::Tree);
        for (n, limit) in family.limits.iter_mut().enumerate() {
            let t = if truth.id[n] < 0 { 1.0 } else { truth.t[n] };
            *limit = [t, t.next_up(), t.next_down(), t * 0.5, t * 1.5, 0.0, -1.0][n % 7];
        }
        let exact = trace(&mut cpu(), &family, Accuracy::Exact, Search::All);
        for (n, &limit) in family.limits.iter().enumerate() {
            // The exact t is within an ulp of the f64 that is given out, so further limits are told by it alone.
            let t = truth.t[n];
            if limit < t.next_down() || limit > t.next_up() {
                assert_eq!(exact.0.id[n] >= 0, t < limit && limit > 0.0, "{}, ray {n}: {t} of {limit}", family.name);
            }
        }
        let certified = trace(&mut cpu(), &family, Accuracy::Certified, Search::Tree);
        compare("limits", &family, &certified, &exact);
    }
}

/// A limit that is exactly the t of a hit excludes it, whatever is rounded: 3-4-5 triangles, both roots.
#[test]
fn a_hit_at_the_limit_does_not_count() {
    let mut spheres = halfline::Spheres::default();
    spheres.push([0.0; 3], 5.0, None);
    let origins = [[-13.0, 3.0, 0.0], [1.0, 3.0, 0.0], [-13.0, 5.0, 0.0]];
    // t of the near root, of the far root from inside, and of a tangent.
    let ts = [9.0, 3.0, 13.0];
    for accuracy in [Accuracy::Certified, Accuracy::Exact] {
        let mut renderer = cpu();
        let mut tracer = renderer.tracer(&spheres, &settings(accuracy, Search::Auto)).expect("valid spheres");
        for (limits, hit) in [(ts, 0), (ts.map(f64::next_up), 1), (ts.map(f64::next_down), 0)] {
            let rays = Rays { origins: &origins, directions: &[[1.0, 0.0, 0.0]; 3], limits: &limits };
            assert_eq!(tracer.occluded(&rays).expect("valid rays").hit, [hit; 3], "{limits:?}");
            let hits = tracer.hits(&rays).expect("valid rays");
            assert_eq!(hits.id, [hit as i32 - 1; 3], "{limits:?}");
        }
    }
}

#[test]
fn neither_order_nor_threads_change_an_answer() {
    for family in families(3, 3000) {
        let whole = trace(&mut cpu(), &family, Accuracy::Certified, Search::Tree);
        let count = family.origins.len();
        let reverse = Family {
            name: family.name,
            spheres: family.spheres.clone(),
            origins: family.origins.iter().rev().copied().collect(),
            directions: family.directions.iter().rev().copied().collect(),
            limits: family.limits.clone(),
        };
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        let (hits, any) = one.install(|| trace(&mut cpu(), &reverse, Accuracy::Certified, Search::Tree));
        for n in 0..count {
            let m = count - 1 - n;
            let bits = |hits: &Hits, n: usize| (hits.id[n], hits.t[n].to_bits(), hits.certainty[n]);
            assert_eq!(bits(&whole.0, n), bits(&hits, m), "{}, ray {n}", family.name);
            assert_eq!(whole.1.hit[n], any.hit[m], "{}, ray {n}", family.name);
        }
    }
}

/// A ray along a row of spheres that it passes by before it meets the last: more steps through the tree than a shader takes.
#[test]
fn a_ray_past_many_spheres_meets_the_last() {
    let count = 40_000;
    let mut spheres = Spheres::default();
    // On both sides, so that the boxes of some reach across the ray.
    let side = |n: i32| if n % 2 == 0 { 1.2 } else { -1.2 };
    (0..count).for_each(|n| spheres.push([0.0, side(n), f64::from(n) * -4.0], 1.0, None));
    spheres.push([0.0, 0.0, f64::from(count) * -4.0], 1.0, None);
    let given = Rays { origins: &[[0.0, 0.0, 4.0]; 20], directions: &[[0.0, 0.0, -1.0]; 20], limits: &[] };
    let (mut renderer, settings) = (cpu(), settings(Accuracy::Certified, Search::Auto));
    let mut tracer = renderer.tracer(&spheres, &settings).expect("valid spheres");
    let (hits, any) = (tracer.hits(&given).expect("valid rays"), tracer.occluded(&given).expect("valid rays"));
    let all = hits.id.iter().all(|id| *id == count) && any.hit.iter().all(|hit| *hit == 1);
    assert!(all, "{:?}", hits.id);
}
