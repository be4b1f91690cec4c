//! A sphere wholly in front of the eye plane, by its projected centre: the twin of certify/front.wgsl.

use super::{Answer, LensRecord, Slopes};
use crate::ray::{positive, unit3};
use crate::real::Real;
use bytemuck::{Pod, Zeroable};

/// What every candidate is asked; certify/lens.wgsl declares it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct FrontRecord {
    pub(crate) rest: [f32; 2],
    pub(crate) column: i32,
    pub(crate) row: i32,
    pub(crate) rho2: f32,
    pub(crate) error: f32,
    pub(crate) size: f32,
    pub(crate) low: f32,
}

/// What only a winner is asked; certify/lens.wgsl declares it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct FrontMoreRecord {
    pub(crate) high: f32,
    pub(crate) least: f32,
    pub(crate) id: u32,
    pub(crate) unused: u32,
}

/// Both records in the arithmetic of a twin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Front<R> {
    pub(crate) rest: [R; 2],
    pub(crate) column: i32,
    pub(crate) row: i32,
    pub(crate) rho2: R,
    pub(crate) error: R,
    pub(crate) size: R,
    pub(crate) low: R,
    pub(crate) high: R,
    pub(crate) least: R,
    pub(crate) id: u32,
}

impl<R: Real> Front<R> {
    pub(crate) fn new(f: &FrontRecord, more: &FrontMoreRecord) -> Self {
        Self {
            rest: f.rest.map(R::exact),
            column: f.column,
            row: f.row,
            rho2: R::exact(f.rho2),
            error: R::exact(f.error),
            size: R::exact(f.size),
            low: R::exact(f.low),
            high: R::exact(more.high),
            least: R::exact(more.least),
            id: more.id,
        }
    }
}

/// Offset of the pixel from the projected centre. The difference of integers is exact.
fn front_offset<R: Real>(s: &Slopes<R>, lens: &LensRecord, f: &Front<R>) -> [R; 2] {
    let whole = |n: i32| R::exact(n as f32);
    let dx = (whole(s.column - f.column) - f.rest[0]) * R::exact(lens.step_x);
    let dy = (whole(f.row - s.row) - f.rest[1]) * R::exact(lens.step_y);
    [dx, dy]
}

fn front_discriminant<R: Real>(s: &Slopes<R>, f: &Front<R>, o: [R; 2]) -> R {
    let across = s.x * o[1] - s.y * o[0];
    s.a * f.rho2 - (o[0] * o[0] + o[1] * o[1] + across * across)
}

/// A lower bound of the depth of the near root, or MISS for a certain miss.
pub(crate) fn front_low<R: Real>(s: &Slopes<R>, lens: &LensRecord, f: &Front<R>) -> R {
    let o = front_offset(s, lens, f);
    let disc = front_discriminant(s, f, o);
    if disc < -f.error {
        return R::MISS;
    }
    let along = s.x * o[0] + s.y * o[1];
    f.low - (along + (disc + f.error).sqrt()) * (f.size * s.inverse)
}

pub(crate) fn front_answer<R: Real>(s: &Slopes<R>, lens: &LensRecord, f: &Front<R>) -> Answer<R> {
    let o = front_offset(s, lens, f);
    let disc = front_discriminant(s, f, o);
    let along = s.x * o[0] + s.y * o[1];
    let length = f.size * s.inverse;
    let hits = disc > f.error;
    let root = positive(disc).sqrt();
    let low = f.low - (along + positive(disc + f.error).sqrt()) * length;
    let high = f.high - (along + positive(disc - f.error).sqrt()) * length;
    let k = (along + root) * s.inverse;
    let normal = unit3([o[0] - k * s.x, o[1] - k * s.y, k]);
    let sure = hits && disc > f.least;
    Answer { sure, hits, id: f.id, offset: -(along + root) * length, low, high, normal }
}
