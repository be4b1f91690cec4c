//! Builds the tree: halves the spheres at planes across their longest extent, each time so that full children come
//! first.

use super::{ABSENT, Block, MAX_SPHERES, Node, Tree, WIDE};
use crate::view::placement::{PLACED, Placement};
use halfline_ground::parallel::{self, CHEAP};
use std::sync::OnceLock;

/// A sphere while it is ordered: its centre in f32 in the tree's unit, and its index.
#[derive(Debug, Clone, Copy, bytemuck::Zeroable)]
struct Item {
    at: [f32; 3],
    id: u32,
}

/// Fewer items than this are ordered by one thread.
const PARALLEL_MIN_ITEMS: usize = 1 << 12;

impl Tree {
    /// The tree of these spheres; `None` for none or more than [`MAX_SPHERES`].
    pub(crate) fn new(centers: &[[f64; 3]], radii: &[f64]) -> Option<Self> {
        Self::of(centers, radii, radii.len(), |n| n as u32)
    }

    /// The tree of some of these spheres, which may be none of them, in the placement of all.
    pub(crate) fn of_some(centers: &[[f64; 3]], radii: &[f64], ids: &[u32]) -> Option<Self> {
        Self::of(centers, radii, ids.len(), |n| ids[n])
    }

    fn of(centers: &[[f64; 3]], radii: &[f64], count: usize, id: impl Fn(usize) -> u32 + Sync) -> Option<Self> {
        if radii.is_empty() || radii.len() > MAX_SPHERES {
            return None;
        }
        let placement = Placement::new(centers, radii);
        let item = |id: u32| Item { at: placement.point(centers[id as usize]).map(|x| x as f32), id };
        let mut items = parallel::from_fn(count, |n| item(id(n)));
        let mut sizes = vec![items.len().div_ceil(WIDE).div_ceil(WIDE).max(1)];
        while sizes[sizes.len() - 1] > 1 {
            sizes.push(sizes[sizes.len() - 1].div_ceil(WIDE));
        }
        sizes.reverse();
        halve(&mut items, WIDE.pow(sizes.len() as u32));
        let ids = parallel::map(&items, |item| item.id);
        drop(items);
        let mut firsts = vec![0u32];
        for size in &sizes {
            firsts.push(firsts[firsts.len() - 1] + *size as u32);
        }
        let exact = |&id: &u32| {
            let [x, y, z] = centers[id as usize];
            [x, y, z, radii[id as usize]]
        };
        let spheres = parallel::map(&ids, exact);
        let mut blocks = vec![Block::NONE; spheres.len().div_ceil(WIDE)];
        let mut boxes = vec![NOTHING; blocks.len()];
        parallel::fill((&mut blocks[..], &mut boxes[..]), CHEAP / WIDE, &|range, (blocks, boxes)| {
            let spheres = spheres[range.start * WIDE..].chunks(WIDE);
            for ((block, own), spheres) in blocks.iter_mut().zip(boxes).zip(spheres) {
                *own = fill(block, &placement, spheres);
            }
        });
        let mut nodes = vec![Node::of([]); firsts[sizes.len()] as usize];
        for level in (0..sizes.len()).rev() {
            let nodes = &mut nodes[firsts[level] as usize..firsts[level + 1] as usize];
            let mut unions = vec![NOTHING; nodes.len()];
            parallel::fill((nodes, &mut unions[..]), CHEAP / WIDE, &|range, (nodes, unions)| {
                let children = boxes[range.start * WIDE..].chunks(WIDE);
                for ((node, own), children) in nodes.iter_mut().zip(unions).zip(children) {
                    *node = Node::of(children.iter().copied());
                    *own = children.iter().fold(NOTHING, |all, one| union(all, *one));
                }
            });
            boxes = unions;
        }
        Some(Self { placement, nodes, firsts, blocks, ids, spheres, bounding: OnceLock::new() })
    }
}

/// Orders `items` so that each run of `full` of them, of `full`/8 and so on down to a block is compact: halves them
/// between such runs, across their longest extent. Ties go by index, so that the order is the same for any number of
/// threads.
fn halve(items: &mut [Item], full: usize) {
    let mut run = full;
    while run >= items.len() {
        if run <= WIDE {
            return;
        }
        run /= WIDE;
    }
    let middle = items.len().div_ceil(run).div_ceil(2) * run;
    let axis = longest(items);
    items.select_nth_unstable_by(middle, |a, b| a.at[axis].total_cmp(&b.at[axis]).then(a.id.cmp(&b.id)));
    let (a, b) = items.split_at_mut(middle);
    if a.len() < PARALLEL_MIN_ITEMS {
        halve(a, run * WIDE);
        halve(b, run * WIDE);
    } else {
        parallel::join(|| halve(a, run * WIDE), || halve(b, run * WIDE));
    }
}

/// The axis along which the items extend the farthest.
fn longest(items: &[Item]) -> usize {
    let one = |items: &[Item]| items.iter().fold(NOTHING, |all, item| union(all, [item.at; 2]));
    let [low, high] = if items.len() < PARALLEL_MIN_ITEMS {
        one(items)
    } else {
        let parts = parallel::blocks(0..items.len(), PARALLEL_MIN_ITEMS, &|range, _| one(&items[range]));
        parts.into_iter().fold(NOTHING, union)
    };
    let extent: [f32; 3] = std::array::from_fn(|n| high[n] - low[n]);
    (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0)
}

/// The box that contains nothing; a union with it changes no box.
const NOTHING: [[f32; 3]; 2] = [[ABSENT; 3], [-ABSENT; 3]];

/// The box around two boxes.
fn union(a: [[f32; 3]; 2], b: [[f32; 3]; 2]) -> [[f32; 3]; 2] {
    [std::array::from_fn(|n| least(a[0][n], b[0][n])), std::array::from_fn(|n| -least(-a[1][n], -b[1][n]))]
}

/// The lesser; of NaN the other.
fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The box of a sphere, rounded outward.
pub(super) fn bounds(placement: &Placement, &[x, y, z, radius]: &[f64; 4]) -> [[f32; 3]; 2] {
    let (at, reach) = (placement.point([x, y, z]), reach(placement, radius));
    [at.map(|x| ((x - reach) as f32).next_down()), at.map(|x| ((x + reach) as f32).next_up())]
}

/// The radius, in the tree's unit, around a sphere's place in f64 that contains the sphere: it adds the error of the
/// place.
fn reach(placement: &Placement, radius: f64) -> f64 {
    placement.radius(radius) + 2.0 * PLACED
}

/// Fills an empty block, and returns the box of its spheres.
fn fill(block: &mut Block, placement: &Placement, spheres: &[[f64; 4]]) -> [[f32; 3]; 2] {
    let mut all = NOTHING;
    for (lane, sphere) in spheres.iter().enumerate() {
        let at = placement.point([sphere[0], sphere[1], sphere[2]]);
        all = union(all, bounds(placement, sphere));
        for (n, x) in at.into_iter().enumerate() {
            block.center[n][lane] = x as f32;
        }
        block.radius[lane] = (reach(placement, sphere[3]) as f32).next_up();
    }
    all
}
