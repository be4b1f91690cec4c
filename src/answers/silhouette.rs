//! Silhouettes: dark lines along the edges of what is in front, from the ids and depths of a finished frame.
//!
//! A pixel is compared with the pixels around it. A neighbour lies behind it if it misses, or if it shows another sphere
//! that is farther by several times the size of a pixel there; the wider the gap, the more it counts. The line is drawn
//! on the nearer surface, as far as the neighbours behind lie on one side. So it follows the edge of a surface, and a
//! speck in front of something far, with neighbours behind on all sides, stays as it is.
//!
//! Everything is measured in pixels, so that lines do not depend on the scene's unit. A line is about 1.3 pixels wide.

#[cfg(test)]
mod tests;

use crate::double_double as dd;
use crate::view::View;
use crate::view::ray::NONE;
use crate::window::Window;
use rayon::prelude::*;

/// How far the neighbours of a pixel reach. A pixel's line depends on no others.
pub(crate) const MARGIN: u32 = 2;

const REACH: isize = MARGIN as isize;

/// A gap in depth below which a neighbour does not count as behind, and from which it counts fully, in pixels. Touching
/// spheres differ by up to a diameter in depth, so those that are smaller than 8 pixels get no lines between them. At a
/// straight edge the line appears from 14.4 to 20.8 pixels.
const GAP: [f64; 2] = [8.0, 24.0];

/// Where two spheres meet with a smaller gap, in pixels, it may change its sign from one pixel to the next.
const CLOSE: f64 = 4.0;

/// A surface that descends evenly has equal steps before and behind a pixel. A step counts by what it exceeds this many
/// times the step on the opposite side, so that a plain of spheres seen at a grazing angle does not become dark: of a
/// plane in perspective, two steps in line differ by a factor below 2 but for the last six rows before the horizon.
const DESCENT: f64 = 2.0;

/// Of the neighbours behind, the length of the sum of unit vectors toward them: where lines begin and are full. Behind a
/// straight edge it is 7.5 for the first row of pixels, 4.2 for the second and 0 for the third, and nearly the same in
/// every other direction; if half of the pixels around are behind at random, it is 2.2 in the mean.
const ASIDE: [f64; 2] = [3.0, 6.0];

/// The length of that sum behind a straight edge.
const STRAIGHT: f64 = 7.5;

/// The neighbours of a pixel.
const NEIGHBOURS: f64 = 24.0;

/// Diameters in pixels between which the line around a single sphere appears. Below, it would cover half of the sphere.
const DIAMETER: [f64; 2] = [8.0, 16.0];

/// If the nearer side of an edge shows this many pixels of other spheres, of 14 at a straight edge, the spheres make up a
/// surface, and its edge has a line however small they are.
const COMPANY: [f64; 2] = [6.0, 12.0];

/// The size of a pixel in the scene's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PixelSize {
    /// Times the depth.
    Perspective(f64),
    /// The same at all depths.
    Parallel(f64),
}

impl PixelSize {
    /// That of the view's pixels: the longer side.
    pub(crate) fn of(view: &View) -> Self {
        let [across, down, distance] = view.pitch;
        let side = 2.0 * across.max(down) * f64::from(view.record.fine());
        match view.parallel {
            true => Self::Parallel(dd::ldexp(side, view.unit)),
            false => Self::Perspective(side / distance),
        }
    }

    fn at(self, depth: f64) -> f64 {
        match self {
            Self::Perspective(slope) => slope * depth,
            Self::Parallel(size) => size,
        }
    }
}

/// What the pixels of a rectangle show, row by row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shown<'a> {
    /// Pixels in a row.
    pub(crate) width: usize,
    /// The sphere of each pixel; [`NONE`] on a miss.
    pub(crate) ids: &'a [u32],
    /// Its depth along the view axis, in the scene's unit.
    pub(crate) depths: &'a [f64],
    /// The radius of each sphere of the scene.
    pub(crate) radii: &'a [f64],
    /// The size of a pixel.
    pub(crate) pixel: PixelSize,
}

/// What a pixel shows.
#[derive(Clone, Copy)]
struct Spot {
    id: u32,
    /// Finite on a hit, +inf on a miss.
    depth: f64,
}

impl Shown<'_> {
    /// Draws the lines of the pixels of `part`, whose linear RGB is `color`; with `between`, also where two spheres meet
    /// without a gap. Nothing is assumed of what lies beyond the rectangle, so the edge of a frame has no line.
    pub(crate) fn draw(&self, part: Window, between: bool, color: &mut [f32]) {
        let [width, rows] = [part.width() as usize, self.ids.len() / self.width.max(1)];
        let pairs: Vec<_> = pairs().map(|offset| (offset, unit(offset))).collect();
        color.par_chunks_mut((3 * width).max(1)).zip(part.y0..part.y1).for_each(|(row, y)| {
            for (rgb, x) in row.chunks_exact_mut(3).zip(part.x0..part.x1) {
                let light = 1.0 - self.darkness([x as isize, y as isize], rows, &pairs, between) as f32;
                if light < 1.0 {
                    rgb.iter_mut().for_each(|value| *value *= light);
                }
            }
        });
    }

    /// The spot at this column and row, if it lies within the rectangle.
    fn spot(&self, [x, y]: [isize; 2], rows: usize) -> Option<Spot> {
        let within = (0..self.width as isize).contains(&x) && (0..rows as isize).contains(&y);
        within.then(|| {
            let at = y as usize * self.width + x as usize;
            match (self.ids[at], self.depths[at]) {
                (id, depth) if id != NONE && depth.is_finite() => Spot { id, depth },
                _ => Spot { id: NONE, depth: f64::INFINITY },
            }
        })
    }

    /// How dark the line is at a pixel: 0 for none, 1 for black. `pairs` are [`pairs`] with their unit vectors.
    fn darkness(&self, [x, y]: [isize; 2], rows: usize, pairs: &[([isize; 2], [f64; 2])], between: bool) -> f64 {
        let Some(own) = self.spot([x, y], rows).filter(|spot| spot.id != NONE) else { return 0.0 };
        let size = self.pixel.at(own.depth);
        let mut sums = Sums::default();
        let mut add = |toward: [f64; 2], other: Spot, opposite: Spot| {
            sums.count += 1.0;
            add_to(&mut sums.straight, toward.map(f64::abs), 0.5);
            if other.id == own.id {
                return;
            }
            let gap = other.depth - own.depth;
            let farther = ramp((gap - DESCENT * (own.depth - opposite.depth).max(0.0)) / size, GAP);
            // One of two spheres has the line: the nearer one where there is a gap, else the one with the lower id.
            let has_line = match gap.abs() > CLOSE * size {
                true => gap > 0.0,
                false => own.id < other.id,
            };
            let border = f64::from(u8::from(between && has_line));
            sums.company += 1.0 - farther;
            add_to(&mut sums.behind, toward, farther);
            add_to(&mut sums.beside, toward, farther.max(border));
        };
        for &([right, down], toward) in pairs {
            let neighbours = [self.spot([x + right, y + down], rows), self.spot([x - right, y - down], rows)];
            // Where one of them lies beyond the frame's edge, it is not known how the surface descends.
            if let [Some(one), Some(other)] = neighbours {
                add(toward, one, other);
                add(toward.map(|x| -x), other, one);
            }
        }
        let radius = self.radii.get(own.id as usize).copied().unwrap_or(f64::INFINITY);
        let large = ramp(2.0 * radius / size, DIAMETER);
        let edge = sums.ramp(sums.behind) * large.max(ramp(sums.company * NEIGHBOURS / sums.count, COMPANY));
        edge.max(sums.ramp(sums.beside) * large)
    }
}

/// Sums over the neighbours of a pixel.
#[derive(Debug, Default)]
struct Sums {
    /// Their number, and of the unit vectors toward them the sum over half of them, on one side of each axis.
    count: f64,
    straight: [f64; 2],
    /// Unit vectors toward those behind, and toward those behind or of another sphere.
    behind: [f64; 2],
    beside: [f64; 2],
    /// Those that are not behind and show another sphere.
    company: f64,
}

impl Sums {
    /// How dark a sum of unit vectors makes the pixel. At the edge of the frame it is scaled up, as there are fewer.
    fn ramp(&self, sum: [f64; 2]) -> f64 {
        ramp(length(sum) * STRAIGHT / self.straight[0].max(self.straight[1]), ASIDE)
    }
}

/// The offsets to half of the neighbours of a pixel; the others are opposite.
fn pairs() -> impl Iterator<Item = [isize; 2]> {
    let below = (1..=REACH).flat_map(|down| (-REACH..=REACH).map(move |right| [right, down]));
    (1..=REACH).map(|right| [right, 0]).chain(below)
}

/// 0 up to `low`, 1 from `high` on, and linear between; 0 for NaN.
fn ramp(x: f64, [low, high]: [f64; 2]) -> f64 {
    if x > low { ((x - low) / (high - low)).min(1.0) } else { 0.0 }
}

/// Adds `weight` times a vector.
fn add_to(sum: &mut [f64; 2], vector: [f64; 2], weight: f64) {
    sum.iter_mut().zip(vector).for_each(|(sum, x)| *sum += weight * x);
}

fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

fn unit(offset: [isize; 2]) -> [f64; 2] {
    let offset = offset.map(|x| x as f64);
    offset.map(|x| x / length(offset))
}
