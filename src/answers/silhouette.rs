//! Silhouettes: dark lines along the edges of what is in front, from the ids and depths of a finished frame.
//!
//! A pixel is compared with the pixels around it. A neighbour lies behind it if it misses, or if it shows another sphere
//! that is farther by several times the size of a pixel there; the wider the gap, the more it counts. The line is drawn
//! on the nearer surface, as far as the neighbours behind lie on one side. So it follows the edge of a surface, and a
//! speck in front of something far, with neighbours behind on all sides, stays as it is.
//!
//! Everything is measured in pixels, so that lines do not depend on the scene's unit. A line is about 1.3 pixels wide; for a wider one the
//! neighbours are as much farther away, and a narrower one is paler.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays")]

#[cfg(test)]
mod tests;

use crate::double_double as dd;
use crate::frame::outline::Outline;
use crate::number::larger;
use crate::number::vector::{LANES, vectorized};
use crate::scene::Materials;
use crate::view::View;
use crate::view::ray::NONE;
use halfline_ground::parallel;

/// Columns and rows around a pixel that a line of the least full width depends on, in pixels.
const REACH: isize = 2;

/// A gap in depth below which a neighbour does not count as behind, and from which it counts fully, in pixels. Touching
/// spheres differ by up to a diameter in depth, so those that are smaller than 8 pixels get no lines between them. At a
/// straight edge the line appears from 14.4 to 20.8 pixels.
pub(crate) const GAP: [f64; 2] = [8.0, 24.0];

/// Gap in depth, in pixels, above which the nearer of two touching spheres has the line between them. At a smaller gap
/// the sphere with the lower id has it, since the sign of a small gap may change from one pixel to the next.
pub(crate) const CLOSE: f64 = 4.0;

/// A surface that descends evenly has equal steps before and behind a pixel. A step counts by what it exceeds this many
/// times the step on the opposite side, so that a plain of spheres seen at a grazing angle does not become dark: of a
/// plane in perspective, two steps in line differ by a factor below 2 but for the last six rows before the horizon.
pub(crate) const DESCENT: f64 = 2.0;

/// Length of the sum of the unit vectors toward the neighbours behind: a line begins at the first number and is full at
/// the second. Behind a straight edge the length is 7.5 for the first row of pixels, 4.2 for the second and 0 for the
/// third, and nearly the same in every other direction; if half of the pixels around are behind at random, it is 2.2 in
/// the mean.
pub(crate) const SUM_LENGTH: [f64; 2] = [3.0, 6.0];

/// The length of that sum behind a straight edge.
pub(crate) const STRAIGHT: f64 = 7.5;

/// The neighbours of a pixel.
pub(crate) const NEIGHBOURS: f64 = 24.0;

/// Diameters in pixels between which the line around a single sphere appears. Below, it would cover half of the sphere.
pub(crate) const DIAMETER: [f64; 2] = [8.0, 16.0];

/// If the nearer side of an edge shows this many pixels of other spheres, of 14 at a straight edge, the spheres make up a
/// surface, and its edge has a line however small they are.
pub(crate) const COMPANY: [f64; 2] = [6.0, 12.0];

/// The width and the colour of lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Line {
    /// The width over the width of the neighbourhood of [`REACH`].
    scale: f64,
    pub(crate) color: [f32; 3],
}

impl Line {
    pub(crate) fn new(outline: Outline) -> Self {
        Self { scale: outline.width / Outline::LEAST_FULL, color: outline.color }
    }

    /// The distances of neighbours over the distances for the narrowest line.
    pub(crate) fn stretch(self) -> f64 {
        larger(self.scale, 1.0)
    }

    /// Columns and rows around a pixel that its line depends on, in pixels.
    pub(crate) fn margin(self) -> u32 {
        (REACH as f64 * self.stretch()).round() as u32
    }

    /// The darkness of a line that is narrower than the narrowest, over the darkness of the narrowest.
    pub(crate) fn strength(self) -> f64 {
        if self.scale < 1.0 { self.scale } else { 1.0 }
    }

    /// The distance in pixels of neighbour number `x` on one side.
    pub(crate) fn distance(self, x: isize) -> isize {
        (x as f64 * self.stretch()).round() as isize
    }

    fn neighbourhood(self) -> Neighbourhood {
        let pairs: Vec<_> = pairs().map(|offset| (offset.map(|x| self.distance(x)), unit(offset))).collect();
        let both = pairs.iter().flat_map(|(_, toward)| [toward, toward]);
        let straight = both.fold([0.0; 2], |sum, toward| [0, 1].map(|k| sum[k] + 0.5 * toward[k].abs()));
        Neighbourhood { pairs, straight }
    }
}

/// The neighbours of a pixel.
struct Neighbourhood {
    /// The offsets to half of the neighbours, and the unit vectors toward them; the others are opposite.
    pairs: Vec<([isize; 2], [f64; 2])>,
    /// For each axis the sum of the unit vectors toward those on one side of it.
    straight: [f64; 2],
}

/// The size of a pixel in the scene's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PixelSize {
    /// The size at depth 1; it grows in proportion to the depth.
    Perspective(f64),
    /// The size, the same at all depths.
    Parallel(f64),
}

impl PixelSize {
    /// The size of the view's pixels: their longer side.
    pub(crate) fn of(view: &View) -> Self {
        let [across, down, distance] = view.pitch;
        let side = 2.0 * across.max(down) * f64::from(view.record.fine());
        match view.parallel {
            true => Self::Parallel(dd::ldexp(side, view.unit)),
            false => Self::Perspective(side / distance),
        }
    }

    #[inline(always)]
    fn at(self, depth: f64) -> f64 {
        match self {
            Self::Perspective(slope) => slope * depth,
            Self::Parallel(size) => size,
        }
    }
}

/// Marks the sphere of a pixel that shows its face on a plane.
pub(crate) const FACE: u32 = 1 << 31;

/// The spheres and depths of a rectangle of pixels, row by row: the input of the lines.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shown<'a> {
    /// Pixels in a row.
    pub(crate) width: usize,
    /// The sphere of each pixel, with [`FACE`] on a plane that cuts it; [`NONE`] on a miss.
    pub(crate) ids: &'a [u32],
    /// Its depth along the view axis, in the scene's unit.
    pub(crate) depths: &'a [f64],
    /// The radius of each sphere of the scene.
    pub(crate) radii: &'a [f64],
    /// The materials of the spheres: spheres of ink have no lines.
    pub(crate) materials: Option<&'a Materials>,
    /// The size of a pixel.
    pub(crate) pixel: PixelSize,
    pub(crate) line: Line,
}

impl Shown<'_> {
    /// Draws the lines of all pixels, whose linear RGB is `color`: around faces, and with `between` also where two spheres meet without a
    /// gap. Nothing is assumed of what lies beyond the rectangle, so the edge of a frame has no line.
    pub(crate) fn draw(&self, between: bool, color: &mut [f32]) {
        let around = &self.line.neighbourhood();
        parallel::chunks(color, 3 * self.width, &|y, row| {
            vectorized!(self.draw_row(around, between, y as isize, row));
        });
    }

    /// Draws the lines of row `y`.
    #[inline(always)]
    fn draw_row(&self, around: &Neighbourhood, between: bool, y: isize, row: &mut [f32]) {
        for (n, pixels) in row.chunks_mut(3 * LANES).enumerate() {
            let dark = self.darkness([(n * LANES) as isize, y], around, between);
            for (rgb, dark) in pixels.chunks_exact_mut(3).zip(dark) {
                let dark = (self.line.strength() * dark) as f32;
                if dark > 0.0 {
                    rgb.iter_mut()
                        .zip(self.line.color)
                        .for_each(|(value, ink)| *value = *value * (1.0 - dark) + ink * dark);
                }
            }
        }
    }

    /// The rows of the rectangle.
    fn rows(&self) -> isize {
        (self.ids.len() / self.width.max(1)) as isize
    }

    /// The spots of [`LANES`] pixels of row `y`, which must exist, from column `x` on. A pixel beside the rectangle is
    /// a miss; with `INNER` all are within.
    #[inline(always)]
    fn spots<const INNER: bool>(&self, [x, y]: [isize; 2]) -> Spots {
        let mut spots = Spots { id: [NONE; LANES], depth: [f64::INFINITY; LANES], within: [0; LANES] };
        let row = y as usize * self.width..(y as usize + 1) * self.width;
        let (ids, depths) = (&self.ids[row.clone()], &self.depths[row]);
        let (ids_here, depths_here) = match usize::try_from(x) {
            Ok(x) => (ids.get(x..x + LANES), depths.get(x..x + LANES)),
            Err(_) => (None, None),
        };
        if let (Some(ids), Some(depths)) = (ids_here, depths_here) {
            spots.id.copy_from_slice(ids);
            spots.depth.copy_from_slice(depths);
            spots.within = [u64::MAX; LANES];
        } else if !INNER {
            for l in 0..LANES {
                if let Ok(x) = usize::try_from(x + l as isize)
                    && x < self.width
                {
                    (spots.id[l], spots.depth[l], spots.within[l]) = (ids[x], depths[x], u64::MAX);
                }
            }
        }
        spots
    }

    /// Whether [`LANES`] pixels from column `x` of row `y` on and all their neighbours lie within the rectangle.
    #[inline(always)]
    fn is_inner(&self, [x, y]: [isize; 2]) -> bool {
        let margin = self.line.margin() as isize;
        let across = x >= margin && x + LANES as isize + margin <= self.width as isize;
        across && y >= margin && y + margin < self.rows()
    }

    /// Whether [`LANES`] pixels from column `x` of row `y` on and all their neighbours show sphere `id`.
    #[inline(always)]
    fn is_within(&self, id: u32, [x, y]: [isize; 2], around: &Neighbourhood) -> bool {
        let shows = |x: isize, y: isize| {
            let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return false };
            let pixels = self.ids.get(y * self.width + x..y * self.width + x + LANES);
            x + LANES <= self.width
                && pixels.is_some_and(|ids| ids.iter().fold(true, |all, other| all & (*other == id)))
        };
        let both = |[right, down]: [isize; 2]| shows(x + right, y + down) && shows(x - right, y - down);
        shows(x, y) && around.pairs.iter().all(|(offset, _)| both(*offset))
    }

    /// The sums over the neighbours of [`LANES`] pixels from column `x` of row `y` on; with `INNER` all of them lie within the rectangle.
    #[inline(always)]
    fn sums<const INNER: bool>(
        &self,
        [x, y]: [isize; 2],
        (own, size): (&Spots, &[f64; LANES]),
        around: &Neighbourhood,
        between: bool,
    ) -> Sums {
        let mut sums = Sums::default();
        if INNER {
            sums.count = [NEIGHBOURS; LANES];
            sums.straight = around.straight.map(|straight| [straight; LANES]);
        }
        for &([right, down], toward) in &around.pairs {
            // Where one of two opposite neighbours lies beyond the frame's edge, it is not known how the surface descends.
            if !INNER && (y < down || y + down >= self.rows()) {
                continue;
            }
            let (one, other) = (self.spots::<INNER>([x + right, y + down]), self.spots::<INNER>([x - right, y - down]));
            sums.add::<INNER>(own, size, toward, (&one, &other), between);
            sums.add::<INNER>(own, size, toward.map(|x| -x), (&other, &one), between);
        }
        sums
    }

    /// The darkness of the lines at [`LANES`] pixels from column `x` of row `y` on: 0 for none, 1 for black; 0 on a
    /// miss.
    #[inline(always)]
    fn darkness(&self, [x, y]: [isize; 2], around: &Neighbourhood, between: bool) -> [f64; LANES] {
        let own = self.spots::<false>([x, y]);
        let mut dark = [0.0; LANES];
        if own.id == [NONE; LANES] {
            return dark;
        }
        if self.is_within(own.id[0], [x, y], around) {
            return dark;
        }
        let mut size = [0.0; LANES];
        for l in 0..LANES {
            size[l] = self.pixel.at(own.depth[l]);
        }
        let sums = match self.is_inner([x, y]) {
            true => self.sums::<true>([x, y], (&own, &size), around, between),
            false => self.sums::<false>([x, y], (&own, &size), around, between),
        };
        let mut radii = [f64::INFINITY; LANES];
        for l in 0..LANES {
            radii[l] = self.radii.get((own.id[l] & !FACE) as usize).copied().unwrap_or(f64::INFINITY);
        }
        for l in 0..LANES {
            let large = ramp(2.0 * radii[l] / (size[l] * self.line.stretch()), DIAMETER);
            let company = ramp(sums.company[l] * NEIGHBOURS / sums.count[l], COMPANY);
            let edge = sums.ramp(l, &sums.behind) * larger(large, company);
            let darkness = larger(edge, sums.ramp(l, &sums.behind_or_border) * large);
            dark[l] = if own.id[l] == NONE { 0.0 } else { darkness };
        }
        if let Some(materials) = self.materials {
            for l in 0..LANES {
                dark[l] = if materials.is_ink(own.id[l] & !FACE) { 0.0 } else { dark[l] };
            }
        }
        dark
    }
}

/// The spheres and depths of [`LANES`] neighbouring pixels of a row.
struct Spots {
    /// [`NONE`] on a miss.
    id: [u32; LANES],
    /// +inf on a miss.
    depth: [f64; LANES],
    /// All bits where the pixel lies within the rectangle, else none.
    within: [u64; LANES],
}

/// Sums over the neighbours of some pixels.
#[derive(Default)]
struct Sums {
    /// The number of neighbours that lie, like their opposites, in the rectangle; and for each axis the sum of the unit
    /// vectors toward those on one side of it.
    count: [f64; LANES],
    straight: [[f64; LANES]; 2],
    /// Sums of unit vectors toward the neighbours behind; and toward these and, where lines are drawn between touching
    /// spheres, the neighbours that leave the line to this pixel. A neighbour counts by its share of being behind.
    behind: [[f64; LANES]; 2],
    behind_or_border: [[f64; LANES]; 2],
    /// The number of neighbours of another sphere, each less its share of being behind.
    company: [f64; LANES],
}

impl Sums {
    /// Adds the neighbours `other`, which lie in the direction `toward`, with the neighbours on the `opposite` side; a
    /// neighbour that does not count adds 0.
    #[inline(always)]
    fn add<const INNER: bool>(
        &mut self,
        own: &Spots,
        size: &[f64; LANES],
        toward: [f64; 2],
        (other, opposite): (&Spots, &Spots),
        between: bool,
    ) {
        for l in 0..LANES {
            let within = INNER | (other.within[l] & opposite.within[l] != 0);
            let one = if within { 1.0 } else { 0.0 };
            let counts = within & (other.id[l] != own.id[l]);
            let gap = other.depth[l] - own.depth[l];
            let before = larger(own.depth[l] - opposite.depth[l], 0.0);
            let farther = ramp((gap - DESCENT * before) / size[l], GAP);
            let farther = if counts { farther } else { 0.0 };
            // One of two spheres has the line: the nearer one where there is a gap, else the one with the lower id.
            let apart = gap.abs() > CLOSE * size[l];
            let has_line = (apart & (gap > 0.0)) | (!apart & (own.id[l] < other.id[l]));
            // A miss has this bit too, and lies behind in any case.
            let at_face = (own.id[l] | other.id[l]) & FACE != 0;
            let border = if (between | at_face) & counts & has_line { 1.0 } else { 0.0 };
            if !INNER {
                self.count[l] += one;
            }
            self.company[l] += if counts { 1.0 - farther } else { 0.0 };
            for k in 0..2 {
                if !INNER {
                    self.straight[k][l] += 0.5 * one * toward[k].abs();
                }
                self.behind[k][l] += farther * toward[k];
                self.behind_or_border[k][l] += larger(farther, border) * toward[k];
            }
        }
    }

    /// The darkness, 0 to 1, that a sum of unit vectors gives a pixel. At the edge of the frame the sum is scaled up,
    /// since there are fewer neighbours.
    #[inline(always)]
    fn ramp(&self, l: usize, sum: &[[f64; LANES]; 2]) -> f64 {
        ramp(length([sum[0][l], sum[1][l]]) * STRAIGHT / larger(self.straight[0][l], self.straight[1][l]), SUM_LENGTH)
    }
}

/// The offsets to half of the neighbours of a pixel; the others are opposite.
fn pairs() -> impl Iterator<Item = [isize; 2]> {
    let below = (1..=REACH).flat_map(|down| (-REACH..=REACH).map(move |right| [right, down]));
    (1..=REACH).map(|right| [right, 0]).chain(below)
}

/// 0 up to `low`, 1 from `high` on, and linear between; 0 for NaN.
#[inline(always)]
fn ramp(x: f64, [low, high]: [f64; 2]) -> f64 {
    let y = (x - low) / (high - low);
    if x > low { if y < 1.0 { y } else { 1.0 } } else { 0.0 }
}

#[inline(always)]
fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

fn unit(offset: [isize; 2]) -> [f64; 2] {
    let offset = offset.map(|x| x as f64);
    offset.map(|x| x / length(offset))
}
