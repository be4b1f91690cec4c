//! Spheres around groups of sixteen, in the order of the tree: what streams of rays descend.

use super::records::{ABSENT, Block, WIDE};
use bytemuck::Zeroable;
use halfline_ground::parallel;

/// Children of a group, and spheres of a lowest one: the lanes of a vector of 512 bits.
pub(crate) const SIXTEEN: usize = 2 * WIDE;

/// Sixteen spheres, in the tree's unit. A missing one has the radius -[`ABSENT`].
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, PartialEq, Zeroable)]
pub(crate) struct Balls {
    pub(crate) center: [[f32; SIXTEEN]; 3],
    pub(crate) radius: [f32; SIXTEEN],
}

/// Spheres around groups of a tree's spheres.
#[derive(Debug)]
pub(crate) struct Bounding {
    /// Level by level, the root first, which is one vector. The spheres of the last level are around sixteen spheres of the tree each, the
    /// spheres of a level above around sixteen of the next.
    pub(crate) levels: Vec<Vec<Balls>>,
}

/// Bound of the error of a sphere's centre as f32, with more to spare. Section 10a of docs/certificate.md.
const ROUNDED: f32 = 1.0 / (1u32 << 22) as f32;
/// Above the rounding of a distance in f32, relative. Section 10a of docs/certificate.md.
const LONGER: f32 = 1.0 + 1.0 / (1u32 << 20) as f32;

impl Bounding {
    /// The spheres around the groups of these blocks.
    pub(crate) fn of(all: &[Block]) -> Self {
        let (mut levels, mut each) = (Vec::new(), SIXTEEN);
        loop {
            let count = (all.len() * WIDE).div_ceil(each).div_ceil(SIXTEEN).max(1);
            let mut level = vec![Balls::zeroed(); count];
            let blocks = each / WIDE;
            parallel::fill(&mut level[..], 1, &|range, level: &mut [Balls]| {
                for (n, balls) in range.zip(level) {
                    for l in 0..SIXTEEN {
                        let first = all.len().min((n * SIXTEEN + l) * blocks);
                        let group = &all[first..all.len().min(first + blocks)];
                        let ([x, y, z], radius) = around(group);
                        [balls.center[0][l], balls.center[1][l], balls.center[2][l]] = [x, y, z];
                        balls.radius[l] = radius;
                    }
                }
            });
            levels.push(level);
            if count == 1 {
                break;
            }
            each *= SIXTEEN;
        }
        levels.reverse();
        Self { levels }
    }

    /// Whether `may` holds for a sphere of the blocks, by its place; it holds for a group if it may hold for a sphere in it.
    pub(crate) fn any(&self, blocks: &[Block], may: &dyn Fn([f32; 3], f32) -> bool) -> bool {
        self.any_below(blocks, 0, 0, may)
    }

    fn any_below(&self, blocks: &[Block], level: usize, n: usize, may: &dyn Fn([f32; 3], f32) -> bool) -> bool {
        let Some(balls) = self.levels.get(level).map(|level| &level[n]) else {
            return [2 * n, 2 * n + 1].into_iter().filter_map(|n| blocks.get(n)).any(|block| {
                (0..WIDE).any(|l| block.radius[l] >= 0.0 && may(block.center.map(|x| x[l]), block.radius[l]))
            });
        };
        (0..SIXTEEN).any(|l| {
            let (center, radius) = (balls.center.map(|x| x[l]), balls.radius[l]);
            radius >= 0.0 && may(center, radius) && self.any_below(blocks, level + 1, n * SIXTEEN + l, may)
        })
    }
}

/// The sphere around the spheres of some blocks: the middle of their box, and the farthest point of any.
fn around(blocks: &[Block]) -> ([f32; 3], f32) {
    let spheres = || {
        let of = |block: &Block| (0..WIDE).map(|l| (block.center.map(|x| x[l]), block.radius[l])).collect::<Vec<_>>();
        blocks.iter().flat_map(of).filter(|(_, radius)| *radius >= 0.0)
    };
    let (mut low, mut high) = ([ABSENT; 3], [-ABSENT; 3]);
    for (center, radius) in spheres() {
        for k in 0..3 {
            (low[k], high[k]) = (low[k].min(center[k] - radius), high[k].max(center[k] + radius));
        }
    }
    if low[0] > high[0] {
        return ([0.0; 3], -ABSENT);
    }
    let middle: [f32; 3] = std::array::from_fn(|k| 0.5 * (low[k] + high[k]));
    let reach = |(center, radius): ([f32; 3], f32)| {
        let [x, y, z]: [f32; 3] = std::array::from_fn(|k| center[k] - middle[k]);
        (x * x + y * y + z * z).sqrt() * LONGER + radius
    };
    (middle, spheres().map(reach).fold(0.0, f32::max) * LONGER + ROUNDED)
}
