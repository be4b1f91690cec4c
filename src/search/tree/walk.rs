//! The traversal on the CPU path: eight boxes or eight spheres at a time.

use super::lanes::{LANE, Lanes, NEVER};
use super::{Block, BoxRay, LEVELS, Node, Tree, WIDE};

/// The test of a block's spheres in a traversal. A trait, because a closure would not be compiled with the vector
/// instructions of its caller.
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

/// Tests the blocks of spheres that the ray may meet before `limit`, roughly nearest first; with `ANY` until a test returns a
/// negative number, for rays that end at any sphere. The blocks of a node are then not sorted, which costs more than it saves.
///
/// At most one node of every level has children that wait. The nearest is found without branches, since which box is
/// entered first cannot be predicted.
#[inline(always)]
pub(crate) fn walk<const ANY: bool, L: Lanes>(l: L, tree: &Tree, ray: &BoxRay, mut limit: f32, test: &mut impl Test) {
    let lowest = tree.levels() - 1;
    if ANY && lowest == 0 {
        test_blocks(l, tree, 0, ray, limit, test);
        return;
    }
    let root = Children::<L> { keys: enter(l, &tree.nodes[0], ray, limit), first: 0 };
    let mut waiting = [root; LEVELS];
    let mut level = 0;
    loop {
        let now = &mut waiting[level];
        let key = l.take_least(&mut now.keys);
        let place = now.first + (key & LANE);
        // The limit of a ray that ends at any sphere does not change.
        if key == NEVER || !ANY && f32::from_bits(key & !LANE) > limit {
            if level == 0 {
                return;
            }
            level -= 1;
        } else if ANY && level + 1 == lowest {
            if !test_blocks(l, tree, place, ray, limit, test) {
                return;
            }
        } else if level == lowest {
            limit = test.test(place);
        } else {
            level += 1;
            let node = &tree.nodes[(tree.firsts[level] + place) as usize];
            waiting[level] = Children { keys: enter(l, node, ray, limit), first: place * WIDE as u32 };
        }
    }
}

/// Tests the blocks of a node of the lowest level that the ray enters before `limit`, until a test returns a negative
/// number; whether none did.
#[inline(always)]
fn test_blocks<L: Lanes>(l: L, tree: &Tree, node: u32, ray: &BoxRay, limit: f32, test: &mut impl Test) -> bool {
    let lowest = tree.firsts[tree.levels() - 1];
    let (near, far) = slabs(l, &tree.nodes[(lowest + node) as usize], ray, limit);
    let mut mask = l.at_most(near, far);
    while mask != 0 {
        if test.test(node * WIDE as u32 + mask.trailing_zeros()) < 0.0 {
            return false;
        }
        mask &= mask - 1;
    }
    true
}

/// The children whose boxes the ray enters before `limit`.
#[inline(always)]
fn enter<L: Lanes>(l: L, node: &Node, ray: &BoxRay, limit: f32) -> L::Keys {
    let (near, far) = slabs(l, node, ray, limit);
    l.keys(near, far)
}

/// t at which the ray enters each of the eight boxes of a node, and t at which it leaves them or ends. The first is
/// larger for a box that it misses.
#[inline(always)]
fn slabs<L: Lanes>(l: L, node: &Node, ray: &BoxRay, limit: f32) -> (L::Number, L::Number) {
    let (mut near, mut far) = (l.splat(0.0), l.splat(limit));
    for n in 0..3 {
        let (low, high) = (&node.planes[n], &node.planes[n + 3]);
        let (first, last) = if ray.inverse[n] < 0.0 { (high, low) } else { (low, high) };
        let inverse = l.splat(ray.inverse[n]);
        near = l.max(l.mul(l.sub(l.load(first), l.splat(ray.enter[n])), inverse), near);
        far = l.min(l.mul(l.sub(l.load(last), l.splat(ray.leave[n])), inverse), far);
    }
    (near, far)
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

/// Has all blocks tested, without the boxes, until the test ends the search.
#[inline(always)]
pub(crate) fn pass_all(tree: &Tree, test: &mut impl Test) {
    (0..tree.blocks.len() as u32).take_while(|block| test.test(*block) >= 0.0).for_each(drop);
}

/// The spheres of a block that the ray may meet before `limit`.
#[inline(always)]
pub(crate) fn may_intersect<L: Lanes>(l: L, tree: &Tree, block: u32, ray: &BoxRay, limit: f32) -> Places {
    let mask = Passing::new(l, &tree.blocks[block as usize], ray).may_intersect(limit);
    Places { first: block as usize * WIDE, mask }
}

/// [`may_intersect`] for a ray that ends at any sphere. `None` if the ray surely meets a sphere before `certain`. A sphere
/// on whose surface the ray starts is never surely met.
#[inline(always)]
pub(crate) fn may_pass<L: Lanes>(
    l: L,
    tree: &Tree,
    block: u32,
    ray: &BoxRay,
    [certain, limit]: [f32; 2],
) -> Option<Places> {
    let passing = Passing::new(l, &tree.blocks[block as usize], ray);
    let mask = passing.may_intersect(limit);
    let blocked = mask != 0 && passing.surely_intersects(certain) != 0;
    (!blocked).then_some(Places { first: block as usize * WIDE, mask })
}

/// The numbers that decide whether a ray meets each of eight spheres, in f32: docs/certificate.md, section 9.
struct Passing<'a, L: Lanes> {
    l: L,
    ray: &'a BoxRay,
    radius: L::Number,
    /// The radius and twice the padding.
    reach: L::Number,
    /// `reach` times the length of the direction.
    along: L::Number,
    /// From the start to the centre.
    p: [L::Number; 3],
    /// From the start to the centre, along the ray times the length of the direction.
    b: L::Number,
    /// The square of the distance of the centre from the line, times the square of the direction's length.
    g2: L::Number,
}

impl<'a, L: Lanes> Passing<'a, L> {
    #[inline(always)]
    fn new(l: L, block: &Block, ray: &'a BoxRay) -> Self {
        let d = ray.direction.map(|x| l.splat(x));
        let p: [L::Number; 3] = std::array::from_fn(|n| l.sub(l.load(&block.center[n]), l.splat(ray.origin[n])));
        let minor = |m: usize, n: usize| l.sub(l.mul(p[m], d[n]), l.mul(p[n], d[m]));
        let g = [minor(1, 2), minor(2, 0), minor(0, 1)];
        let radius = l.load(&block.radius);
        let reach = l.add(l.mul(radius, l.splat(1.0 + ROUNDED)), l.splat(ray.pad * 2.0));
        let along = l.mul(reach, l.splat(ray.length));
        Self { l, ray, radius, reach, along, p, b: dot(l, p, d), g2: dot(l, g, g) }
    }

    /// One bit for each sphere that may be met before `limit`.
    #[inline(always)]
    fn may_intersect(&self, limit: f32) -> u32 {
        let Self { l, ray, reach, along, b, g2, .. } = *self;
        let near = l.at_most(g2, l.mul(l.mul(reach, reach), l.splat(ray.a)));
        let ahead = l.at_most(l.sub(l.splat(0.0), along), b);
        let before = l.at_most(l.sub(b, along), l.splat(limit * ray.a));
        near & ahead & before
    }

    /// One bit for each sphere that is met before `certain` by a ray that starts outside, for certain.
    #[inline(always)]
    fn surely_intersects(&self, certain: f32) -> u32 {
        let Self { l, ray, radius, reach, along, p, b, g2 } = *self;
        let inner = l.sub(l.mul(radius, l.splat(1.0 - ROUNDED)), l.splat(ray.pad * 2.0));
        // `a` exceeds the square of the direction's length.
        let a = ray.a * (1.0 - 4.0 * ROUNDED);
        let large = l.at_most(l.splat(f32::MIN_POSITIVE), inner);
        let within = l.at_most(g2, l.mul(l.mul(inner, inner), l.splat(a)));
        let outside = l.at_most(l.mul(reach, reach), dot(l, p, p));
        let ahead = l.at_most(l.splat(ray.pad * 2.0 * ray.length), b);
        let before = l.at_most(l.add(b, along), l.splat(certain * a));
        large & within & outside & ahead & before
    }
}

#[inline(always)]
fn dot<L: Lanes>(l: L, a: [L::Number; 3], b: [L::Number; 3]) -> L::Number {
    l.add(l.add(l.mul(a[0], b[0]), l.mul(a[1], b[1])), l.mul(a[2], b[2]))
}

/// Bound of the relative rounding error of the numbers that are compared. Section 9 of docs/certificate.md.
const ROUNDED: f32 = 1.0 / (1u32 << 16) as f32;
