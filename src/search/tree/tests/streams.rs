//! Streams of rays: they answer as exact arithmetic does or not at all, on every kind of vectors, and their margin is needed.

use super::{point, scenes};
use crate::exact::judge_ray;
use crate::scene::Spheres;
use crate::search::tree::bounding::SIXTEEN;
use crate::search::tree::sixteen::{Loops, Sixteen, Work16, dispatch};
use crate::search::tree::streams::{Blockers, Chosen, ERROR, Hidden, Starts, Stream};
use crate::search::tree::{Tree, WIDE};
use crate::testing::Rng;
use crate::view::ray::NONE;
use glam::DVec3;

#[test]
fn every_sphere_is_in_the_spheres_around_it() {
    for (name, spheres) in scenes() {
        let tree = Tree::new(&spheres.centers, &spheres.radii).expect("a tree");
        let levels = &tree.bounding().levels;
        assert_eq!(levels[0].len(), 1, "{name}");
        for (place, [x, y, z, radius]) in tree.spheres.iter().enumerate() {
            let center = DVec3::from_array(tree.placement.point([*x, *y, *z]));
            let mut child = place / SIXTEEN;
            for level in levels.iter().rev() {
                let (balls, l) = (&level[child / SIXTEEN], child % SIXTEEN);
                let around = DVec3::from_array(balls.center.map(|x| x[l].into()));
                let reach = (center - around).length() + tree.placement.radius(*radius);
                assert!(reach <= balls.radius[l].into(), "{name}: sphere {place}");
                child /= SIXTEEN;
            }
        }
    }
}

/// Rays of one direction.
struct Trace<'a> {
    blockers: Blockers<'a>,
    direction: [f64; 3],
    starts: &'a Starts,
}

impl Work16 for &Trace<'_> {
    type Output = Vec<Hidden>;

    #[inline(always)]
    fn work<S: Sixteen>(self, lanes: S) -> Vec<Hidden> {
        let mut stream = Stream::default();
        let ids = &self.starts.ids;
        let chosen: Vec<u32> =
            (0..ids.len().div_ceil(SIXTEEN)).map(|n| (1 << (ids.len() - n * SIXTEEN).min(SIXTEEN)) - 1).collect();
        stream.begin(self.direction, self.starts);
        stream.trace(lanes, self.blockers, false, Chosen { chosen: &chosen, ids, ends: None });
        let forward: Vec<Hidden> = stream.answers().map(|(_, answer)| answer).collect();
        // The same way by its opposite.
        stream.begin(self.direction.map(|x| -x), self.starts);
        stream.trace(lanes, self.blockers, true, Chosen { chosen: &chosen, ids, ends: None });
        assert!(stream.answers().zip(&forward).all(|((_, backward), forward)| is_alike(backward, *forward)));
        forward
    }
}

/// Whether answers do not contradict each other.
fn is_alike(a: Hidden, b: Hidden) -> bool {
    a == b || a == Hidden::Unsure || b == Hidden::Unsure
}

/// A scene, and rays of one direction from points outside of all its spheres; many rays touch one.
struct Case {
    spheres: Spheres,
    direction: [f64; 3],
    points: Vec<[f64; 3]>,
}

impl Case {
    fn new(random: &mut Rng) -> Self {
        let count = [3u32, 40, 300, 700][random.below(4) as usize];
        // Less than half of the space is in spheres, so that points outside are found.
        let [large, small] = [random.decade(-2.0, -0.1) / f64::from(count).cbrt(), random.decade(-7.0, 0.0)];
        let mut spheres = Spheres::default();
        for _ in 0..count {
            let radius = large * if random.below(4) == 0 { small } else { 1.0 };
            spheres.push(point(random), radius, None);
            if random.below(8) == 0 {
                spheres.push(spheres.centers[spheres.len() - 1], radius, None);
            }
        }
        let toward = DVec3::from_array(point(random));
        let single = toward.normalize().as_vec3().as_dvec3();
        let direction = if random.below(2) == 0 { single } else { toward * random.decade(-20.0, 20.0) };
        let mut points = Vec::new();
        for _ in 0..300 {
            // A point at the distance of the radius, or nearly, from the line through a centre.
            let id = random.below(spheres.len() as u32) as usize;
            let (center, radius) = (DVec3::from_array(spheres.centers[id]), spheres.radii[id]);
            let across = direction.cross(DVec3::from_array(point(random))).normalize();
            let off = radius * random.sign() * 2f64.powf(random.between(-40.0, -16.0));
            let away = if random.below(4) == 0 { random.unit() * radius } else { radius + off };
            let p = center + across * away - direction.normalize() * random.between(-0.5, 1.0);
            let outside =
                |id: usize| (p - DVec3::from_array(spheres.centers[id])).length() > spheres.radii[id] * (1.0 + 1e-12);
            if p.abs().max_element() <= 1.0 && (0..spheres.len()).all(outside) {
                points.push(p.to_array());
            }
        }
        Self { spheres, direction: direction.to_array(), points }
    }

    /// Of each ray with a margin the answer, and whether exact arithmetic finds a hit.
    fn answers(&self, error: f32) -> Vec<(Hidden, bool)> {
        let tree = Tree::new(&self.spheres.centers, &self.spheres.radii).expect("a tree");
        let blockers = Blockers { tree: &tree, error };
        let mut starts = Starts::default();
        for p in &self.points {
            let at = tree.placement.point(*p);
            (0..3).for_each(|k| starts.at[k].push(at[k]));
            starts.ids.push(NONE);
        }
        let trace = Trace { blockers, direction: self.direction, starts: &starts };
        let found = dispatch(&trace);
        assert_eq!(found, (&trace).work(Loops), "loops");
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = pulp::x86::V3::try_new() {
            assert_eq!(found, (&trace).work(lanes), "AVX2");
        }
        let hits = |p: &[f64; 3]| judge_ray(*p, self.direction, &self.spheres).is_some();
        found.into_iter().zip(self.points.iter().map(hits)).collect()
    }
}

/// Wrong, undecided, hidden and all rays of some scenes.
fn count(error: f32) -> [usize; 4] {
    let mut random = Rng(11);
    let mut sums = [0; 4];
    for _ in 0..60 {
        for (answer, is_hidden) in Case::new(&mut random).answers(error) {
            sums[0] += usize::from(answer == if is_hidden { Hidden::No } else { Hidden::Yes });
            sums[1] += usize::from(answer == Hidden::Unsure);
            sums[2] += usize::from(is_hidden);
            sums[3] += 1;
        }
    }
    sums
}

#[test]
fn answers_are_those_of_exact_arithmetic() {
    let [wrong, unsure, hidden, rays] = count(ERROR);
    println!("{rays} rays, {hidden} hidden, {unsure} undecided");
    assert_eq!(wrong, 0);
    assert!(unsure > 100 && hidden > 1000, "{unsure} undecided, {hidden} hidden");
}

#[test]
fn the_margin_is_needed() {
    let [wrong, ..] = count(0.0);
    assert!(wrong > 0, "no ray is wrong without it");
}

#[test]
fn a_ray_leaves_its_own_sphere_behind_and_is_hidden_inside_none() {
    let mut spheres = Spheres::default();
    (0..WIDE + 1).for_each(|n| spheres.push([n as f64 * 1e-9, 0.0, 0.0], 1e-8, None));
    spheres.push([0.0, 0.0, 1.0], 0.1, None);
    let tree = Tree::new(&spheres.centers, &spheres.radii).expect("a tree");
    let blockers = Blockers { tree: &tree, error: ERROR };
    let at = tree.placement.point([0.0, 0.0, 1e-8]);
    let mut starts = Starts { at: at.map(|x| vec![x]), ids: vec![0] };
    // Spheres smaller than the margin decide nothing, but the one of the point.
    let answer = |starts: &Starts, direction| dispatch(&Trace { blockers, direction, starts })[0];
    assert_eq!(answer(&starts, [0.0, 1.0, 1e-3]), Hidden::Unsure);
    assert_eq!(answer(&starts, [0.0, 0.0, 1.0]), Hidden::Yes);
    let mut alone = Spheres::default();
    alone.push([0.0; 3], 1e-8, None);
    alone.push([0.0, 0.0, 1.0], 0.1, None);
    let tree = Tree::new(&alone.centers, &alone.radii).expect("a tree");
    let blockers = Blockers { tree: &tree, error: ERROR };
    starts.at = tree.placement.point([0.0, 0.0, 1e-8]).map(|x| vec![x]);
    assert_eq!(dispatch(&Trace { blockers, direction: [0.0, 1.0, 1e-3], starts: &starts })[0], Hidden::No);
}
