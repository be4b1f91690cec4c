//! A tree of boxes over the spheres, for given rays: which spheres a ray may meet without asking them all.
//!
//! [`Shape`] is the tree without its boxes, made once for a call; [`Tree`] is that with the boxes of one view, padded so
//! that no sphere which a form of the quadratic reports is ever left out: the search does not change an answer, by
//! whatever form (docs/tree.md derives it). Walked by `shaders/search/tree.wgsl` and its twin in `nearest.rs`.

mod coherent;
mod shape;
#[cfg(test)]
mod tests;

use crate::intersect::{Form, Method};
use crate::view::ray::RayRecord;
use crate::view::{SphereRecord, View};
use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

pub(crate) use coherent::coherent;
pub(crate) use shape::Shape;

/// Nodes that may wait to be visited; a tree needs no more than one for each of its levels.
pub(crate) const STACK: u32 = 32;

/// The most spheres in a leaf.
const LEAF: usize = 4;

/// The bit that tells a link to a leaf from one to a node. Under it: how many spheres, 4 bits, and where the first
/// stands in the order, 27 bits.
pub(crate) const IS_LEAF: u32 = 1 << 31;

/// The bits of a leaf's first place.
pub(crate) const FIRST: u32 = (1 << 27) - 1;

/// A link that leads nowhere.
pub(crate) const NOWHERE: u32 = u32::MAX;

/// Smallest component of a direction that the boxes see, 2^-32: a smaller one is taken for this, so that nothing is divided
/// by zero. It moves a point of the ray by less than 2^-32 of its way.
pub(crate) const LEAST: f32 = 1.0 / (1u64 << 32) as f32;

/// Two boxes and where they lead; search/tree.wgsl declares it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct NodeRecord {
    /// Bits of the least x, y, z of the first box, and the first link. Bits, because a link that passes as an f32 may be
    /// flushed.
    pub(crate) low_a: [u32; 4],
    /// Bits of its greatest x, y, z; the fourth number is unused.
    pub(crate) high_a: [u32; 4],
    /// The same of the second.
    pub(crate) low_b: [u32; 4],
    /// The same of the second.
    pub(crate) high_b: [u32; 4],
}

/// The tree as the kernels read it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tree {
    /// The root comes first, children after their parents.
    pub(crate) nodes: Vec<NodeRecord>,
    /// Ids of the spheres, leaf by leaf.
    pub(crate) order: Vec<u32>,
}

/// How far beyond its sphere a box reaches; docs/tree.md. S is |p| + r plus the farthest origin from the eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slack {
    /// Of S, in u = 2^-23: rounding of rays, records and slabs, and of the form's t and outline.
    pub(crate) linear: f64,
    /// Of S^2, in u: what the form's discriminant may be off by.
    pub(crate) square: f64,
}

impl Slack {
    /// For what `method` may report.
    pub(crate) fn of(method: Method) -> Self {
        match method.form() {
            _ if method.is_wide() => Self { linear: 8.0, square: 0.0 },
            Form::Perpendicular => Self { linear: 64.0, square: 0.0 },
            Form::General | Form::Normalised => Self { linear: 64.0, square: 32.0 },
        }
    }

    /// The padding of a sphere of radius `r` with S = `s`.
    fn pad(self, r: f64, s: f64) -> f64 {
        const U: f64 = 1.0 / (1u64 << 23) as f64;
        // sqrt(r^2 + e) - r without its cancellation.
        let e = self.square * U * s * s;
        self.linear * U * s + e / (r + (r * r + e).sqrt()) + VANISH
    }
}

/// What flushed numbers may lose of a coordinate in the frame's unit, many times over.
const VANISH: f64 = 1.0 / (1u128 << 120) as f64;

/// The largest S for which t, up to 2^32 S, stays well inside f32.
const FARTHEST: f64 = (1u128 << 90) as f64;

/// A box in the frame's unit.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    low: [f32; 3],
    high: [f32; 3],
}

impl Bounds {
    const EMPTY: Self = Self { low: [f32::MAX; 3], high: [-f32::MAX; 3] };

    /// Around a sphere, padded; `None` where f32 cannot hold it.
    fn of(s: &SphereRecord, reach: f64, cull_margin: Slack) -> Option<Self> {
        let center_radius = s.center_radius.map(|x| f64::from(x) * f64::from(s.scale));
        let (p, r) = (&center_radius[..3], center_radius[3]);
        let far = p.iter().map(|x| x * x).sum::<f64>().sqrt() + r + reach;
        if far.is_nan() || far > FARTHEST {
            return None;
        }
        let pad = r + cull_margin.pad(r, far);
        let low = std::array::from_fn(|k| ((p[k] - pad) as f32).next_down());
        let high = std::array::from_fn(|k| ((p[k] + pad) as f32).next_up());
        Some(Self { low, high })
    }

    fn and(self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|k| self.low[k].min(other.low[k])),
            high: std::array::from_fn(|k| self.high[k].max(other.high[k])),
        }
    }
}

impl Tree {
    /// The boxes of `view` for rays whose origins are at most `reach` from its eye, in the frame's unit; `None` where
    /// numbers are so large that slabs could overflow: then every ray tests every sphere.
    pub(crate) fn new(shape: &Shape, view: &View, reach: f64, cull_margin: Slack) -> Option<Self> {
        let around = |&id: &u32| Bounds::of(&view.spheres[id as usize], reach, cull_margin);
        let bounds: Vec<Bounds> = shape.order.par_iter().map(around).collect::<Option<_>>()?;
        let mut nodes = vec![NodeRecord::zeroed(); shape.links.len()];
        let mut whole = vec![Bounds::EMPTY; shape.links.len()];
        for (n, links) in shape.links.iter().enumerate().rev() {
            let [a, b] = links.map(|link| match leaf(link) {
                Some(leaf) => bounds[leaf].iter().fold(Bounds::EMPTY, Bounds::and),
                None => whole[link as usize],
            });
            whole[n] = a.and(&b);
            let bits = |x: [f32; 3], link: u32| [x[0].to_bits(), x[1].to_bits(), x[2].to_bits(), link];
            nodes[n] = NodeRecord {
                low_a: bits(a.low, links[0]),
                high_a: bits(a.high, 0),
                low_b: bits(b.low, links[1]),
                high_b: bits(b.high, 0),
            };
        }
        Some(Self { nodes, order: shape.order.clone() })
    }
}

/// Where the spheres of a leaf stand in the order; `None` for a link to a node.
pub(crate) fn leaf(link: u32) -> Option<std::ops::Range<usize>> {
    let first = (link & FIRST) as usize;
    (link & IS_LEAF != 0).then(|| first..first + (link >> 27 & 15) as usize)
}

/// A ray as the boxes see it, always in f32.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slabs {
    origin: [f32; 3],
    inverse: [f32; 3],
}

impl Slabs {
    /// Twin of `slabs_of`.
    pub(crate) fn of(ray: &RayRecord) -> Self {
        let inverse = std::array::from_fn(|k| {
            let d = ray.direction[k];
            let least = if d < 0.0 { -LEAST } else { LEAST };
            1.0 / if d.abs() < LEAST { least } else { d }
        });
        Self { origin: std::array::from_fn(|k| ray.origin[k]), inverse }
    }

    /// Where the ray comes into the box, at least 0; [`f32::MAX`] where it does not. Twin of `entry`.
    pub(crate) fn entry(&self, low: [u32; 4], high: [u32; 4]) -> f32 {
        let t = |bits: [u32; 4], k: usize| (f32::from_bits(bits[k]) - self.origin[k]) * self.inverse[k];
        let (mut near, mut far) = (0f32, f32::MAX);
        for k in 0..3 {
            let (a, b) = (t(low, k), t(high, k));
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        if near <= far { near } else { f32::MAX }
    }
}
