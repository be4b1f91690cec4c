//! Spheres that a frame depends on though no ray may hit them: those whose numbers are the extremes of all.

use crate::scene::Spheres;
use crate::view::size_from;
use glam::DVec3;
use rayon::prelude::*;

/// A sphere with its id.
#[derive(Debug, Clone, Copy)]
pub(super) struct Witness {
    pub(super) id: u32,
    pub(super) center: [f64; 3],
    pub(super) radius: f64,
    pub(super) color: Option<[f32; 3]>,
}

/// The spheres with the least and the largest sizes, depths and coordinates so far.
#[derive(Debug)]
pub(super) struct Witnesses {
    eye: DVec3,
    /// The greatest score of each kind, with its sphere.
    best: [Option<(f64, Witness)>; SCORES + 2],
}

/// Scores of a sphere: the size that the frame's unit depends on, and the box around all, each as a maximum.
const SCORES: usize = 8;

/// Spheres that one job scores.
const TOGETHER: usize = 1 << 12;

impl Witnesses {
    /// No spheres yet, seen from `eye`.
    pub(super) fn new(eye: DVec3) -> Self {
        Self { eye, best: [None; SCORES + 2] }
    }

    /// Takes the spheres of a block, whose first has the id `first`. `depths` are the least and the largest depth, with the
    /// indices of their spheres, in the unit 2^`unit`.
    pub(super) fn see(&mut self, block: &Spheres, first: u32, depths: Option<[(f64, u32); 2]>, unit: i32) {
        let eye = self.eye;
        let job = |(centers, radii): (&[[f64; 3]], &[f64])| {
            centers.iter().zip(radii).fold([f64::NEG_INFINITY; SCORES], |best, (center, radius)| {
                let score = scores(eye, *center, *radius);
                std::array::from_fn(|k| if score[k] > best[k] { score[k] } else { best[k] })
            })
        };
        let jobs = block.centers.par_chunks(TOGETHER).zip(block.radii.par_chunks(TOGETHER));
        let all: Vec<[f64; SCORES]> = jobs.map(job).collect();
        for (n, best) in all.into_iter().enumerate() {
            for (k, score) in best.into_iter().enumerate() {
                if self.best[k].is_none_or(|(known, _)| score > known) {
                    let mut range = n * TOGETHER..((n + 1) * TOGETHER).min(block.len());
                    let place = range.find(|n| scores(eye, block.centers[*n], block.radii[*n])[k] == score);
                    self.best[k] = place.map(|place| (score, witness(block, first, place)));
                }
            }
        }
        let scaled = |depth: f64| crate::double_double::ldexp(depth, unit);
        let ends = depths.map(|[least, most]| [(-scaled(least.0), least.1), (scaled(most.0), most.1)]);
        for (known, (score, place)) in self.best[SCORES..].iter_mut().zip(ends.into_iter().flatten()) {
            if known.is_none_or(|(known, _)| score > known) {
                *known = Some((score, witness(block, first, place as usize)));
            }
        }
    }

    /// All of them; one sphere may occur several times.
    pub(super) fn all(&self) -> impl Iterator<Item = Witness> + '_ {
        self.best.iter().flatten().map(|(_, witness)| *witness)
    }
}

fn witness(block: &Spheres, first: u32, place: usize) -> Witness {
    Witness {
        id: first + place as u32,
        center: block.centers[place],
        radius: block.radii[place],
        color: block.colors.as_ref().map(|colors| colors[place]),
    }
}

#[inline(always)]
fn scores(eye: DVec3, [x, y, z]: [f64; 3], r: f64) -> [f64; SCORES] {
    let size = size_from(eye, [x, y, z], r);
    [size, -size, x + r, y + r, z + r, r - x, r - y, r - z]
}
