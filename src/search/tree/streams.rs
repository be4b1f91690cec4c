//! Rays of one direction, which go down the spheres around groups together: docs/certificate.md, section 10a.
//!
//! Along their direction rays are points of a plane, spheres are discs with a height, and a ray is hidden where its point lies in a disc
//! that is higher.

#![expect(clippy::needless_range_loop, reason = "loops over lanes and rays of several arrays")]

use super::bounding::{Balls, SIXTEEN};
use super::sixteen::Sixteen;
use super::{Block, Tree, WIDE};
use bytemuck::Zeroable;
use glam::DVec3;

/// The most rays that go down together.
pub(crate) const MOST_RAYS: usize = 1 << 16;

/// Bound of the error of a comparison, as a length in the tree's unit: docs/certificate.md, section 10a.
pub(crate) const ERROR: f32 = 1.0 / (1u32 << 19) as f32;

/// The starts of rays, in the tree's coordinates, and the ids of the spheres that they are on.
#[derive(Debug, Default)]
pub(crate) struct Starts {
    pub(crate) at: [Vec<f64>; 3],
    pub(crate) ids: Vec<u32>,
}

/// The lengths at which rays from some starts end, in the tree's unit: bounds of them. Rays of no end have [`NO_END`].
#[derive(Debug, Default)]
pub(crate) struct Ends {
    pub(crate) low: Vec<f32>,
    pub(crate) high: Vec<f32>,
}

/// A length beyond all spheres from each of them, which lie in [-1, 1] in each coordinate. Section 9a.
pub(crate) const NO_END: f32 = 8.0;

/// Rays in one list, which are compared in vectors.
#[derive(Debug, Default)]
struct List {
    /// Place in the plane, and height along the direction.
    u: Vec<f32>,
    v: Vec<f32>,
    w: Vec<f32>,
    /// Their places in the list above, in the first list the places of their starts.
    above: Vec<u32>,
    /// A bit for each ray of a vector that nothing hides yet.
    open: Vec<u32>,
    count: usize,
}

impl List {
    fn reserve(&mut self, count: usize) {
        let room = count + 2 * SIXTEEN;
        if self.u.len() < room {
            for numbers in [&mut self.u, &mut self.v, &mut self.w] {
                numbers.resize(room, 0.0);
            }
            self.above.resize(room, 0);
            self.open.resize(room / SIXTEEN + 1, 0);
        }
    }

    /// Opens all its rays, so many.
    #[inline(always)]
    fn open_all(&mut self, count: usize) {
        self.count = count;
        let full = count / SIXTEEN;
        self.open[..full].fill((1 << SIXTEEN) - 1);
        self.open[full] = (1 << (count % SIXTEEN)) - 1;
    }

    #[inline(always)]
    fn close(&mut self, ray: usize) {
        self.open[ray / SIXTEEN] &= !(1 << (ray % SIXTEEN));
    }

    #[inline(always)]
    fn is_open(&self, ray: usize) -> bool {
        self.open[ray / SIXTEEN] >> (ray % SIXTEEN) & 1 == 1
    }

    /// Vectors of rays.
    #[inline(always)]
    fn vectors(&self) -> usize {
        self.count.div_ceil(SIXTEEN)
    }
}

/// The sixteen numbers from `first` on.
#[inline(always)]
fn sixteen<T>(values: &[T], first: usize) -> &[T; SIXTEEN] {
    values[first..].first_chunk().expect("rays fill whole vectors")
}

#[inline(always)]
fn sixteen_mut<T>(values: &mut [T], first: usize) -> &mut [T; SIXTEEN] {
    values[first..].first_chunk_mut().expect("rays fill whole vectors")
}

/// Sixteen spheres along a direction.
struct Discs<S: Sixteen> {
    u: S::Number,
    v: S::Number,
    /// The height of the centre.
    w: S::Number,
    radius: S::Number,
}

impl<S: Sixteen> Discs<S> {
    #[inline(always)]
    fn of(s: S, center: [S::Number; 3], radius: S::Number, axes: &[[f32; 3]; 3]) -> Self {
        let [u, v, w] = [along(s, center, &axes[0]), along(s, center, &axes[1]), along(s, center, &axes[2])];
        Self { u, v, w, radius }
    }

    #[inline(always)]
    fn of_balls(s: S, balls: &Balls, axes: &[[f32; 3]; 3]) -> Self {
        let [x, y, z] = &balls.center;
        Self::of(s, [s.load(x), s.load(y), s.load(z)], s.load(&balls.radius), axes)
    }

    #[inline(always)]
    fn of_blocks(s: S, [a, b]: [&Block; 2], axes: &[[f32; 3]; 3]) -> Self {
        let center = [0, 1, 2].map(|k| (&a.center[k], &b.center[k]));
        let [x, y, z] = [both(s, center[0]), both(s, center[1]), both(s, center[2])];
        Self::of(s, [x, y, z], both(s, (&a.radius, &b.radius)), axes)
    }

    /// The radii with a margin added.
    #[inline(always)]
    fn widened(&self, s: S, margin: f32) -> S::Number {
        s.add(self.radius, s.splat(margin))
    }

    /// Of spheres around groups: the square of the distance beyond which a ray meets nothing of the group, and the height above which it
    /// leaves the group behind.
    #[inline(always)]
    fn limits(&self, s: S, error: f32) -> [S::Number; 2] {
        let wide = self.widened(s, 2.0 * error);
        [s.mul(wide, wide), s.add(self.w, wide)]
    }
}

/// The products of sixteen vectors with an axis.
#[inline(always)]
fn along<S: Sixteen>(s: S, [x, y, z]: [S::Number; 3], axis: &[f32; 3]) -> S::Number {
    let (x, y, z) = (s.mul(x, s.splat(axis[0])), s.mul(y, s.splat(axis[1])), s.mul(z, s.splat(axis[2])));
    s.add(s.add(x, y), z)
}

/// The numbers of two blocks.
#[inline(always)]
fn both<S: Sixteen>(s: S, (a, b): (&[f32; WIDE], &[f32; WIDE])) -> S::Number {
    let mut both = [0.0; SIXTEEN];
    both[..WIDE].copy_from_slice(a);
    both[WIDE..].copy_from_slice(b);
    s.load(&both)
}

/// The squares of sixteen radii; negative of those that are not positive.
#[inline(always)]
fn squares<S: Sixteen>(s: S, radii: S::Number) -> [f32; SIXTEEN] {
    let mut squares = s.store(radii);
    for l in 0..SIXTEEN {
        squares[l] = if squares[l] > 0.0 { squares[l] * squares[l] } else { -1.0 };
    }
    squares
}

/// Numbers of a group's children.
struct Children {
    u: [f32; SIXTEEN],
    v: [f32; SIXTEEN],
    /// The square of the widened radius.
    reach: [f32; SIXTEEN],
    /// The height above which a ray leaves all of the child behind; below every ray for a missing one.
    top: [f32; SIXTEEN],
    /// The children that exist, the farthest toward the sky first.
    order: [u8; SIXTEEN],
    count: usize,
    next: usize,
    /// The group's place in its level.
    group: usize,
}

impl Children {
    #[inline(always)]
    fn of<S: Sixteen>(s: S, balls: &Balls, group: usize, axes: &[[f32; 3]; 3], error: f32) -> Self {
        let discs = Discs::of_balls(s, balls, axes);
        let [reach, top] = discs.limits(s, error);
        let (reach, top) = (s.store(reach), s.store(top));
        let (mut order, mut count) = ([0u8; SIXTEEN], 0);
        for child in (0..SIXTEEN).filter(|l| balls.radius[*l] >= 0.0) {
            let mut place = count;
            while place > 0 && top[usize::from(order[place - 1])] < top[child] {
                order[place] = order[place - 1];
                place -= 1;
            }
            order[place] = child as u8;
            count += 1;
        }
        Self { u: s.store(discs.u), v: s.store(discs.v), reach, top, order, count, next: 0, group }
    }
}

/// Sixteen spheres of the tree as rays are compared with them.
#[derive(Clone, Copy, Zeroable)]
struct Leaf {
    u: [f32; SIXTEEN],
    v: [f32; SIXTEEN],
    w: [f32; SIXTEEN],
    /// The squares of the radii with the margin added, and taken away; negative where no ray is within.
    outer: [f32; SIXTEEN],
    inner: [f32; SIXTEEN],
}

/// Memory of streams.
#[derive(Default)]
pub(crate) struct Stream {
    axes: [[f32; 3]; 3],
    /// All starts along the axes.
    along: [Vec<f32>; 3],
    lists: Vec<List>,
    waiting: Vec<Children>,
    pairs: Vec<u32>,
    near: Vec<u32>,
    unsure: Vec<bool>,
}

/// The starts of some rays, those with a bit in `chosen`, sixteen to a word: the spheres that they are on, and where the rays end if not
/// infinitely far.
#[derive(Clone, Copy)]
pub(crate) struct Chosen<'a> {
    pub(crate) chosen: &'a [u32],
    pub(crate) ids: &'a [u32],
    pub(crate) ends: Option<&'a Ends>,
}

/// The answer for a ray of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Hidden {
    Yes,
    No,
    Unsure,
}

/// The spheres of a tree, for streams that start outside of all of them.
#[derive(Clone, Copy)]
pub(crate) struct Blockers<'a> {
    pub(crate) tree: &'a Tree,
    /// [`ERROR`]. Tests take others, to show that it is needed.
    pub(crate) error: f32,
}

/// Three axes of length 1 with the last along a direction, rounded.
fn axes(direction: [f64; 3]) -> [[f32; 3]; 3] {
    let w = DVec3::from_array(direction).normalize();
    let u = w.any_orthonormal_vector();
    [u, w.cross(u), w].map(|axis| axis.as_vec3().to_array())
}

impl Stream {
    /// Begins a direction, and its opposite, for rays from these starts, at most [`MOST_RAYS`] of them.
    #[inline(always)]
    pub(crate) fn begin(&mut self, direction: [f64; 3], starts: &Starts) {
        self.axes = axes(direction);
        let count = starts.ids.len();
        let [x, y, z] = starts.at.each_ref().map(|x| &x[..count]);
        for (axis, out) in self.axes.iter().zip(&mut self.along) {
            out.resize(count.next_multiple_of(SIXTEEN), 0.0);
            let (axis, out) = (axis.map(f64::from), &mut out[..count]);
            for ray in 0..count {
                out[ray] = (x[ray] * axis[0] + y[ray] * axis[1] + z[ray] * axis[2]) as f32;
            }
        }
    }

    /// Whether spheres hide the ends of the rays from some starts in the direction, or with `backward` in its opposite. The starts lie outside of all spheres, on the surface of their own, which is behind
    /// them. The answers do not depend on the order of rays and spheres.
    #[inline(always)]
    pub(crate) fn trace<S: Sixteen>(&mut self, s: S, blockers: Blockers<'_>, backward: bool, rays: Chosen<'_>) {
        let Chosen { chosen, ids, .. } = rays;
        let levels = blockers.tree.bounding().levels.len();
        self.lists.resize_with(self.lists.len().max(levels), List::default);
        self.unsure.clear();
        self.unsure.resize(ids.len(), false);
        let (root, mut axes, mut count) = (&mut self.lists[0], self.axes, 0);
        root.reserve(ids.len());
        let [u, v, w] = &self.along;
        let side = s.splat(if backward { -1.0 } else { 1.0 });
        if backward {
            axes[2] = axes[2].map(|x| -x);
        }
        for (n, &mask) in chosen.iter().enumerate() {
            let first = n * SIXTEEN;
            s.pack(mask, s.load(sixteen(u, first)), sixteen_mut(&mut root.u, count));
            s.pack(mask, s.load(sixteen(v, first)), sixteen_mut(&mut root.v, count));
            s.pack(mask, s.mul(side, s.load(sixteen(w, first))), sixteen_mut(&mut root.w, count));
            s.pack_lanes(mask, first as u32, sixteen_mut(&mut root.above, count));
            count += mask.count_ones() as usize;
        }
        root.open_all(count);
        if count > 0 {
            self.descend(s, blockers, &axes, rays);
        }
    }

    /// The starts of the last rays, by their numbers, and their answers.
    #[inline(always)]
    pub(crate) fn answers(&self) -> impl Iterator<Item = (usize, Hidden)> {
        let root = &self.lists[0];
        root.above[..root.count].iter().enumerate().map(|(ray, start)| {
            let start = *start as usize;
            let answer = match (root.is_open(ray), self.unsure[start]) {
                (false, _) => Hidden::Yes,
                (true, true) => Hidden::Unsure,
                (true, false) => Hidden::No,
            };
            (start, answer)
        })
    }

    #[inline(always)]
    fn descend<S: Sixteen>(&mut self, s: S, blockers: Blockers<'_>, axes: &[[f32; 3]; 3], rays: Chosen<'_>) {
        let Blockers { tree, error } = blockers;
        let bounding = tree.bounding();
        let lowest = bounding.levels.len() - 1;
        self.waiting.clear();
        let mut group = 0;
        loop {
            let level = self.waiting.len();
            if level == lowest {
                self.test_leaves(s, blockers, group, axes, rays);
            } else {
                self.waiting.push(Children::of(s, &bounding.levels[level][group], group, axes, error));
            }
            // The next child that a ray may meet, of the lowest group that has one.
            loop {
                let Some(level) = self.waiting.len().checked_sub(1) else { return };
                let children = &mut self.waiting[level];
                let [list, below] = &mut self.lists[level..level + 2] else { return };
                if below.count > 0 {
                    close_hidden(list, below);
                }
                if children.next == children.count {
                    below.count = 0;
                    self.waiting.pop();
                    continue;
                }
                let child = usize::from(children.order[children.next]);
                children.next += 1;
                below.reserve(list.count);
                let count = entering(s, list, below, children, child);
                below.open_all(count);
                if count > 0 {
                    group = children.group * SIXTEEN + child;
                    break;
                }
            }
        }
    }

    /// Compares the rays of the lowest list with the spheres of a lowest group: first with the spheres around its sixteens, then
    /// each pair of a ray and a sixteen, without branches, then the few pairs in which a sphere may hide the ray.
    #[inline(always)]
    fn test_leaves<S: Sixteen>(
        &mut self,
        s: S,
        Blockers { tree, error }: Blockers<'_>,
        group: usize,
        axes: &[[f32; 3]; 3],
        Chosen { ids, ends, .. }: Chosen<'_>,
    ) {
        let levels = &tree.bounding().levels;
        let level = levels.len() - 1;
        let Self { lists, pairs, near, unsure, .. } = self;
        let (above, list) = lists.split_at_mut(level);
        let list = &mut list[0];
        let discs = Discs::of_balls(s, &levels[level][group], axes);
        let [reach, top] = discs.limits(s, error);
        let room = (list.count + 1) * SIXTEEN;
        if pairs.len() < room {
            pairs.resize(room, 0);
            near.resize(room, 0);
        }
        let (mut count, mut touched) = (0, 0);
        for ray in 0..list.count {
            let (du, dv) = (s.sub(discs.u, s.splat(list.u[ray])), s.sub(discs.v, s.splat(list.v[ray])));
            let distance = s.add(s.mul(du, du), s.mul(dv, dv));
            let mask = s.at_most(distance, reach) & s.at_most(s.splat(list.w[ray]), top);
            // A pair is the ray's number and four bits for the child.
            s.pack_lanes(mask, (ray * SIXTEEN) as u32, sixteen_mut(pairs, count));
            count += mask.count_ones() as usize;
            touched |= mask;
        }
        let mut leaves = [Leaf::zeroed(); SIXTEEN];
        for child in (0..SIXTEEN).filter(|child| touched >> child & 1 == 1) {
            leaves[child] = leaf(s, tree, group * SIXTEEN + child, axes, error);
        }
        let mut nearer = 0;
        for pair in &pairs[..count] {
            let (ray, leaf) = (*pair as usize / SIXTEEN, &leaves[*pair as usize % SIXTEEN]);
            let (distance, height) = (leaf.distance(s, list, ray), s.splat(list.w[ray] - error));
            let mask = s.at_most(distance, s.load(&leaf.outer)) & s.at_most(height, s.load(&leaf.w));
            near[nearer] = *pair;
            nearer += usize::from(mask != 0);
        }
        for pair in &near[..nearer] {
            let (ray, child) = (*pair as usize / SIXTEEN, *pair as usize % SIXTEEN);
            if !list.is_open(ray) {
                continue;
            }
            let leaf = &leaves[child];
            let distance = leaf.distance(s, list, ray);
            let low = s.at_most(s.splat(list.w[ray] - error), s.load(&leaf.w));
            let high = s.at_most(s.splat(list.w[ray] + error), s.load(&leaf.w));
            let mut sure = s.at_most(distance, s.load(&leaf.inner)) & high;
            let mut mask = s.at_most(distance, s.load(&leaf.outer)) & low;
            if let Some(Ends { low, high }) = ends {
                let start = start(above, list, ray);
                // Heights and lengths are off by at most twice the error together.
                let [low, high] = [low[start] - 2.0 * error, high[start] + 2.0 * error].map(|end| list.w[ray] + end);
                let distance = s.store(distance);
                sure &= leaf.begins_below(low, &distance, &leaf.inner);
                mask &= leaf.begins_below(high, &distance, &leaf.outer);
            }
            if sure != 0 {
                list.close(ray);
                continue;
            }
            let start = start(above, list, ray);
            while mask != 0 {
                let place = (group * SIXTEEN + child) * SIXTEEN + mask.trailing_zeros() as usize;
                // A ray leaves its own sphere behind.
                unsure[start] |= tree.ids[place] != ids[start];
                mask &= mask - 1;
            }
        }
    }
}

/// The number of the start of a ray of a list, which is below some.
#[inline(always)]
fn start(above: &[List], list: &List, ray: usize) -> usize {
    above.iter().rev().fold(list.above[ray] as usize, |ray, list| list.above[ray] as usize)
}

/// Closes the rays of a list that are closed in the one below.
#[inline(always)]
fn close_hidden(list: &mut List, below: &List) {
    for n in 0..below.vectors() {
        let full = (1u32 << (below.count - n * SIXTEEN).min(SIXTEEN)) - 1;
        let mut closed = full & !below.open[n];
        while closed != 0 {
            list.close(below.above[n * SIXTEEN + closed.trailing_zeros() as usize] as usize);
            closed &= closed - 1;
        }
    }
}

/// Lists the open rays that may meet a child of a group, and counts them.
#[inline(always)]
fn entering<S: Sixteen>(s: S, list: &List, below: &mut List, children: &Children, child: usize) -> usize {
    let (u, v) = (s.splat(children.u[child]), s.splat(children.v[child]));
    let (reach, top) = (s.splat(children.reach[child]), s.splat(children.top[child]));
    let mut count = 0;
    for n in 0..list.vectors() {
        if list.open[n] == 0 {
            continue;
        }
        let first = n * SIXTEEN;
        let (ray_u, ray_v) = (s.load(sixteen(&list.u, first)), s.load(sixteen(&list.v, first)));
        let ray_w = s.load(sixteen(&list.w, first));
        let (du, dv) = (s.sub(ray_u, u), s.sub(ray_v, v));
        let distance = s.add(s.mul(du, du), s.mul(dv, dv));
        let mask = list.open[n] & s.at_most(distance, reach) & s.at_most(ray_w, top);
        if mask == 0 {
            continue;
        }
        s.pack(mask, ray_u, sixteen_mut(&mut below.u, count));
        s.pack(mask, ray_v, sixteen_mut(&mut below.v, count));
        s.pack(mask, ray_w, sixteen_mut(&mut below.w, count));
        s.pack_lanes(mask, first as u32, sixteen_mut(&mut below.above, count));
        count += mask.count_ones() as usize;
    }
    count
}

/// The sixteen spheres of a tree from a place on.
#[inline(always)]
fn leaf<S: Sixteen>(s: S, tree: &Tree, n: usize, axes: &[[f32; 3]; 3], error: f32) -> Leaf {
    let block = |n: usize| tree.blocks.get(n).unwrap_or(&Block::NONE);
    let discs = Discs::of_blocks(s, [block(2 * n), block(2 * n + 1)], axes);
    let (inner, outer) = (discs.widened(s, -error), discs.widened(s, error));
    Leaf {
        u: s.store(discs.u),
        v: s.store(discs.v),
        w: s.store(discs.w),
        outer: squares(s, outer),
        inner: squares(s, inner),
    }
}

impl Leaf {
    /// The squares of the distances of a ray from the discs.
    #[inline(always)]
    fn distance<S: Sixteen>(&self, s: S, list: &List, ray: usize) -> S::Number {
        let (du, dv) = (s.sub(s.load(&self.u), s.splat(list.u[ray])), s.sub(s.load(&self.v), s.splat(list.v[ray])));
        s.add(s.mul(du, du), s.mul(dv, dv))
    }

    /// The discs whose spheres a ray at these squares of distances enters below a height; `squares` are the squares of their radii.
    #[inline(always)]
    fn begins_below(&self, height: f32, distance: &[f32; SIXTEEN], squares: &[f32; SIXTEEN]) -> u32 {
        let mut mask = 0;
        for l in 0..SIXTEEN {
            let above = self.w[l] - height;
            let is_below = above <= 0.0 || above * above + distance[l] <= squares[l];
            mask |= u32::from(is_below) << l;
        }
        mask
    }
}
