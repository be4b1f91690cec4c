//! The traversal on the CPU path: eight boxes or eight spheres at a time.

use super::lanes::{LANE, Lanes, NEVER};
use super::{Block, BoxRay, LEVELS, Node, Tree, WIDE};

/// What is done with the spheres of a block. A trait, because a closure would not be compiled with
/// the vector instructions of its caller.
pub(crate) trait Test {
    /// Tests the spheres of a block. Returns the new limit, in the boxes' t; a negative one ends the traversal.
    fn test(&mut self, block: u32) -> f32;
}

/// The children of one node that the ray enters and that wait.
#[derive(Clone, Copy)]
struct Children<L: Lanes> {
    /// t where the ray enters each of them.
    keys: L::Keys,
    /// The place of the first child among the nodes or blocks of its level.
    first: u32,
}

/// Tests the blocks of spheres that the ray may meet before `limit`, roughly nearest first.
///
/// At most one node of every level has children that wait. The nearest is found without branches, since which box is
/// entered first cannot be predicted.
#[inline(always)]
pub(crate) fn walk<L: Lanes>(l: L, tree: &Tree, ray: &BoxRay, limit: f32, test: &mut impl Test) {
    let mut limit = limit;
    let lowest = tree.levels() - 1;
    let root = Children::<L> { keys: enter(l, &tree.nodes[0], ray, limit), first: 0 };
    let mut waiting = [root; LEVELS];
    let mut level = 0;
    loop {
        let now = &mut waiting[level];
        let key = l.take_least(&mut now.keys);
        let place = now.first + (key & LANE);
        if key == NEVER || f32::from_bits(key & !LANE) > limit {
            if level == 0 {
                return;
            }
            level -= 1;
        } else if level == lowest {
            limit = test.test(place);
        } else {
            level += 1;
            let node = &tree.nodes[(tree.firsts[level] + place) as usize];
            waiting[level] = Children { keys: enter(l, node, ray, limit), first: place * WIDE as u32 };
        }
    }
}

/// The children whose boxes the ray enters before `limit`.
#[inline(always)]
fn enter<L: Lanes>(l: L, node: &Node, ray: &BoxRay, limit: f32) -> L::Keys {
    let (mut near, mut far) = (l.splat(0.0), l.splat(limit));
    for n in 0..3 {
        let (low, high) = (&node.planes[n], &node.planes[n + 3]);
        let (first, last) = if ray.inverse[n] < 0.0 { (high, low) } else { (low, high) };
        let inverse = l.splat(ray.inverse[n]);
        near = l.max(l.mul(l.sub(l.load(first), l.splat(ray.enter[n])), inverse), near);
        far = l.min(l.mul(l.sub(l.load(last), l.splat(ray.leave[n])), inverse), far);
    }
    l.keys(near, far)
}

/// Places of spheres in the order of the tree.
pub(crate) struct Places {
    /// The place of the block's first sphere.
    first: usize,
    /// One bit for each sphere of the block that is left.
    mask: u32,
}

impl Iterator for Places {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.mask.trailing_zeros();
        self.mask &= self.mask.wrapping_sub(1);
        (lane < WIDE as u32).then_some(self.first + lane as usize)
    }
}

/// The spheres of a block that the ray may meet before `limit`.
#[inline(always)]
pub(crate) fn may_meet<L: Lanes>(l: L, tree: &Tree, block: u32, ray: &BoxRay, limit: f32) -> Places {
    Places { first: block as usize * WIDE, mask: mask(l, &tree.blocks[block as usize], ray, limit) }
}

/// The same, one bit each.
#[inline(always)]
fn mask<L: Lanes>(l: L, block: &Block, ray: &BoxRay, limit: f32) -> u32 {
    let d = ray.direction.map(|x| l.splat(x));
    let p: [L::Number; 3] = std::array::from_fn(|n| l.sub(l.load(&block.center[n]), l.splat(ray.origin[n])));
    let reach = l.add(l.mul(l.load(&block.radius), l.splat(1.0 + ROUNDED)), l.splat(ray.pad * 2.0));
    let dot =
        |a: [L::Number; 3], b: [L::Number; 3]| l.add(l.add(l.mul(a[0], b[0]), l.mul(a[1], b[1])), l.mul(a[2], b[2]));
    let minor = |m: usize, n: usize| l.sub(l.mul(p[m], d[n]), l.mul(p[n], d[m]));
    let g = [minor(1, 2), minor(2, 0), minor(0, 1)];
    let b = dot(p, d);
    let along = l.mul(reach, l.splat(ray.length));
    let aside = l.at_most(dot(g, g), l.mul(l.mul(reach, reach), l.splat(ray.a)));
    let ahead = l.at_most(l.sub(l.splat(0.0), along), b);
    let before = l.at_most(l.sub(b, along), l.splat(limit * ray.a));
    aside & ahead & before
}

/// Roundings of the numbers that are compared, of themselves.
const ROUNDED: f32 = 1.0 / (1u32 << 16) as f32;
