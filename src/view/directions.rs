//! Directions toward the sky and points of a disc, for rays from a hit: evenly spread sets, which are turned at random for
//! each pixel. Each sample of a pixel takes its part of a set.
//!
//! A set is made once per frame. The turn of a disc is a hash of the pixel's row and column in the full frame and the
//! seed, so that crops, tiles and frames agree; the same hash chooses one of the turns of a sky, which are made with
//! the set. All arithmetic is + - * / and square roots of f64 in a fixed order, which IEEE 754 determines to the last
//! bit: the numbers are the same on every machine, and are taken as exact afterwards.

#[cfg(test)]
mod tests;

use super::records::pcg4d;
use halfline_ground::parallel;

/// Cosine and sine of the golden angle, pi (3 - sqrt 5), and its share of a turn.
const GOLDEN: [f64; 2] = [-0.737_368_878_078_319_9, 0.675_490_294_261_523_6];
const GOLDEN_TURN: f64 = 0.381_966_011_250_105_1;

/// The sample of a pixel that random numbers belong to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PixelSample {
    /// Row in the full frame.
    pub(crate) row: u32,
    /// Column in the full frame.
    pub(crate) column: u32,
    /// Sample of the pixel.
    pub(crate) sample: u32,
    /// Seed of the frame.
    pub(crate) seed: u32,
}

impl PixelSample {
    /// Pairs of random numbers between -1 and 1, never 0, two pairs at a time; another sequence for each `purpose`. The
    /// position of the sample within its pixel comes from the unmixed hash.
    fn pairs(self, purpose: u32) -> impl Iterator<Item = [[f64; 2]; 2]> {
        let [x, y, z, w] = pcg4d([self.column, self.row, self.sample, self.seed]);
        // Odd multiples of 2^-32.
        let number = |bits: u32| (2.0 * f64::from(bits) + 1.0) / (1u64 << 32) as f64 - 1.0;
        (0..).map(move |trial: u32| {
            let [a, b, c, d] = pcg4d([x, y, z ^ purpose, w.wrapping_add(trial)]).map(number);
            [[a, b], [c, d]]
        })
    }

    /// A rotation, uniform among all: its rows. From a unit quaternion by two points in the unit disc (Marsaglia,
    /// *Choosing a point from the surface of a sphere*, Ann. Math. Statist. 43, 1972).
    fn rotation(self, purpose: u32) -> [[f64; 3]; 3] {
        // A pair lies in the disc with a chance of pi/4.
        let mut inside = self.pairs(purpose).flatten().filter(|pair| square(*pair) < 1.0);
        let mut next = || inside.next().unwrap_or([0.5, 0.5]);
        let ([w, x], [y, z]) = (next(), next());
        let stretch = ((1.0 - square([w, x])) / square([y, z])).sqrt();
        let [y, z] = [y * stretch, z * stretch];
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }

    /// Cosine and sine of an angle, uniform among all.
    fn turn(self, purpose: u32) -> [f64; 2] {
        let pair = self.pairs(purpose).flatten().find(|pair| square(*pair) < 1.0).unwrap_or([1.0, 0.0]);
        let length = square(pair).sqrt();
        pair.map(|x| x / length)
    }
}

fn square([x, y]: [f64; 2]) -> f64 {
    x * x + y * y
}

/// The product of two complex numbers.
fn times([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}

/// (i + 1/2)/n for each i below n, and the unit vector of i golden angles.
fn spiral(n: u32) -> impl Iterator<Item = (f64, [f64; 2])> {
    let mut turn = [1.0, 0.0];
    (0..n).map(move |i| {
        let now = turn;
        turn = times(turn, GOLDEN);
        ((f64::from(i) + 0.5) / f64::from(n), now)
    })
}

/// The unit vector at this share of a turn, from 0 to 1: exp(i x) by its series for a sixteenth of the angle, whose square
/// is taken four times. What the series leaves out is below 2^-60.
fn at_turn(share: f64) -> [f64; 2] {
    let angle = share * std::f64::consts::TAU / 16.0;
    let (mut sum, mut term) = ([1.0, 0.0], [1.0, 0.0]);
    for k in 1..=14 {
        term = times(term, [0.0, angle / f64::from(k)]);
        sum = [sum[0] + term[0], sum[1] + term[1]];
    }
    (0..4).fold(sum, |z, _| times(z, z))
}

/// Directions for rays toward the sky: N = S R for each pixel, R for each of its S samples.
///
/// R directions are a spherical Fibonacci lattice on a hemisphere, a spiral of heights (k + 1/2)/R at k golden angles. Each is meant up to its sign: the caller turns it to the side
/// of the normal n. The lattice and its mirror image together are evenly spread on the sphere, so that is so for every n.
///
/// S = n x n samples share a lattice that is n times finer both in height and in angle: in these coordinates, which keep
/// areas, it is a lattice of the same shape. Each sample has one of the n x n copies of the coarse lattice in it. The copy of row
/// i and column j has the heights (k + (i + 1/2)/n)/R at k + i/n golden angles and j/n of a turn. So what one sample takes
/// is as evenly spread as R directions alone, for every n. (Every S-th direction of one spiral is not: with S = 144, for
/// example, these lie on one meridian.)
///
/// With w = |n.l| the open share of the sky, weighted by the cosine, is estimated by sum(w over open rays)/sum(w). Its
/// standard error over the rotations was measured where a cap of the sky hides what lies behind it (200 caps of any
/// size in any direction, 4000 rotations):
///
/// | N | 4 | 16 | 64 | 256 |
/// | --- | --- | --- | --- | --- |
/// | largest, times N^3/4 | 0.63 | 0.55 | 0.52 | 0.52 |
/// | root mean square over caps, times N^3/4 | 0.39 | 0.35 | 0.33 | 0.32 |
/// | the same of independent directions, times N^3/4 | 0.57 | 0.76 | 1.1 | 1.5 |
///
/// So it is 0.043 with 16 directions, where independent ones have 0.095. The reason: each direction stands for a cell
/// of the sphere of area 2 pi/N. A cell that is all open or all hidden has almost no error. The edge of a cap crosses a
/// number of cells proportional to sqrt N, each with an error proportional to 1/N and almost independent of the others,
/// so the standard error is proportional to N^(1/4 - 1). Where many small spheres hide the sky, their edges cross more
/// cells, up to all of them; then the error is about the error of independent directions.
///
/// In a picture the pixels of a square share a lattice in the same way ([`Self::interleaved`]; Keller and Heidrich, *Interleaved
/// Sampling*, 2001), so that what is put together from neighbours is as evenly spread as what is put together from samples.
///
/// As a quotient of two sums the estimate also has a bias: 0.2 with N = 1 and 0.08 with N = 2, but 0.006 with N = 4 and
/// 0.003 with N = 16, which is the noise of that measurement.
///
/// A pixel's share is the mean of its samples' shares. What they have in common with the quotient of the sums over all
/// samples is that a wholly open point is exactly 1 and a wholly hidden one 0, and with 4 rays or more it has as little
/// noise (docs/light.md). A sum over the rays of one sample divided by what all rays of the pixel give the sample would let
/// white surfaces vary.
#[derive(Debug, Clone)]
pub(crate) struct SkyDirections {
    /// The directions of every turn, one turn after the other.
    turned: Vec<[f32; 3]>,
    /// Directions of one turn.
    count: usize,
    /// The place of a pixel chooses its turn, instead of a hash.
    is_interleaved: bool,
}

/// Pixels after which interleaved directions repeat, in columns and rows; a power of two. Also in shaders/main/sky.wgsl.
const PERIOD: u32 = 8;

/// The number below [`PERIOD`] with the bits of `place` in reverse: neighbours differ by as much as they can, and the numbers
/// of every square of a power of two are evenly spread.
fn reversed(place: u32) -> u32 {
    place.reverse_bits() >> (32 - PERIOD.trailing_zeros())
}

/// `count` directions: the copy in this row and column of a lattice that is finer by `parts` in height and in angle.
fn copy(count: u32, parts: u32, [row, column]: [u32; 2]) -> Vec<[f64; 3]> {
    let [row, column, parts] = [row, column, parts].map(f64::from);
    let height = (row + 0.5) / parts;
    let mut turn = times(at_turn(row * GOLDEN_TURN / parts), at_turn(column / parts));
    let point = |k: u32| {
        let [x, y] = turn;
        turn = times(turn, GOLDEN);
        let z = (f64::from(k) + height) / f64::from(count);
        let r = (1.0 - z * z).sqrt();
        [r * x, r * y, z]
    };
    (0..count).map(point).collect()
}

/// A direction after a rotation with these rows.
fn rotated(rows: [[f64; 3]; 3], p: &[f64; 3]) -> [f32; 3] {
    rows.map(|row| (row[0] * p[0] + row[1] * p[1] + row[2] * p[2]) as f32)
}

/// The least and the most turns. Between them, the number of turns is [`TURNED`] over the number of directions, rounded
/// up to a power of two.
const TURNS: [u32; 2] = [1 << 8, 1 << 12];
const TURNED: u32 = 1 << 14;
/// The most directions in all turns, before the number of turns is rounded up to a power of two; a set has at least one
/// turn.
const MAX_TURNED: u32 = 1 << 22;

impl SkyDirections {
    /// `count` directions for this sample of a pixel with `strata` x `strata` samples.
    pub(crate) fn new(count: u32, strata: u32, sample: u32) -> Self {
        if count == 0 {
            return Self::none();
        }
        Self::turn_all(copy(count, strata, [sample / strata, sample % strata]))
    }

    /// `count` directions for this sample of the pixels of a picture, whose neighbours complement each other: the pixels of
    /// [`PERIOD`] x [`PERIOD`] have the copies of one lattice that is finer by so much.
    pub(crate) fn interleaved(count: u32, strata: u32, sample: u32, seed: u32) -> Self {
        let rows = PixelSample { row: 0, column: 0, sample: 0, seed }.rotation(0);
        let of_pixel = |place: u32| {
            let [row, column] = [(sample / strata, place / PERIOD), (sample % strata, place % PERIOD)]
                .map(|(stratum, place)| PERIOD * stratum + reversed(place));
            copy(count, PERIOD * strata, [row, column]).into_iter().map(move |p| rotated(rows, &p))
        };
        let turned = if count == 0 { Vec::new() } else { (0..PERIOD * PERIOD).flat_map(of_pixel).collect() };
        Self { turned, count: count as usize, is_interleaved: true }
    }

    /// No directions.
    pub(crate) fn none() -> Self {
        Self { turned: Vec::new(), count: 0, is_interleaved: false }
    }

    /// The directions of a lattice in all turns, which are uniform among the rotations.
    fn turn_all(lattice: Vec<[f64; 3]>) -> Self {
        let that_have = |directions: u32| directions / lattice.len().max(1) as u32;
        let turns = that_have(TURNED).clamp(TURNS[0], TURNS[1]).min(that_have(MAX_TURNED)).max(1).next_power_of_two();
        let rows = |turn: u32| PixelSample { row: turn, column: 0, sample: 0, seed: 0 }.rotation(0);
        let turned = parallel::collect(turns as usize, 1, &|turn, turned| {
            let rows = rows(turn.start as u32);
            turned.extend(lattice.iter().map(|p| rotated(rows, p)));
        });
        Self { turned, count: lattice.len(), is_interleaved: false }
    }

    /// One direction for this sample, such that the directions of all samples are evenly spread on the whole sphere: neighbours
    /// of the lattice lie on opposite sides.
    pub(crate) fn one(strata: u32, sample: u32) -> Self {
        let mut one = Self::new(1, strata, sample);
        if (sample / strata + sample % strata) % 2 == 1 {
            one.turned.iter_mut().for_each(|direction| *direction = direction.map(|x| -x));
        }
        one
    }

    /// Whether the place of a pixel chooses its turn.
    pub(crate) fn is_interleaved(&self) -> bool {
        self.is_interleaved
    }

    /// The number of directions.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// The directions of every turn, one turn after the other; the number of turns is a power of two.
    pub(crate) fn turned(&self) -> &[[f32; 3]] {
        &self.turned
    }

    /// The directions in world space for the rays of this pixel that `depth` others came before: turned in the same way for
    /// all samples. Their length is 1 within 2^-22. shaders/main/sky.wgsl chooses the same turn.
    pub(crate) fn of(&self, at: PixelSample, depth: u32) -> &[[f32; 3]] {
        self.of_turn(self.turn(at, depth))
    }

    /// The number of turns.
    pub(crate) fn turns(&self) -> usize {
        self.turned.len() / self.count.max(1)
    }

    /// The turn of the directions of a pixel.
    pub(crate) fn turn(&self, at: PixelSample, depth: u32) -> usize {
        let turn = match self.is_interleaved {
            true => at.row % PERIOD * PERIOD + at.column % PERIOD,
            false => pcg4d([at.column, at.row, depth << 24, at.seed])[3],
        };
        turn as usize & self.turns().wrapping_sub(1)
    }

    /// The directions of a turn.
    pub(crate) fn of_turn(&self, turn: usize) -> &[[f32; 3]] {
        &self.turned[turn * self.count..][..self.count]
    }
}

/// N points on the unit disc, for rays toward a light with a size: Vogel's spiral, where each point stands for the same
/// area (Vogel, *A better way to construct the sunflower head*, Mathematical Biosciences 44, 1979).
///
/// The share of the disc on one side of a random chord has a standard error of at most 0.5 N^-3/4, for the reason that
/// [`SkyDirections`] gives.
#[derive(Debug, Clone)]
pub(crate) struct DiscPoints {
    points: Vec<[f64; 2]>,
    samples: usize,
    rim: Vec<[f64; 2]>,
}

/// Points on the rim of a disc, evenly spread: the least that keep the umbra of an eclipse as large as it is (docs/light.md).
pub(crate) const RIM: u32 = 16;

impl DiscPoints {
    /// `count` points for each of so many samples of a pixel, which together are one spiral.
    pub(crate) fn new(count: u32, samples: u32) -> Self {
        let point = |(area, turn): (f64, [f64; 2])| turn.map(|x| area.sqrt() * x);
        // A sixteenth of a turn: half of an eighth.
        let half = 0.5f64.sqrt();
        let step = [((1.0 + half) / 2.0).sqrt(), ((1.0 - half) / 2.0).sqrt()];
        let rim = std::iter::successors(Some([1.0, 0.0]), |turn| Some(times(*turn, step)));
        Self {
            points: spiral(count * samples).map(point).collect(),
            samples: samples as usize,
            rim: rim.take(RIM as usize).collect(),
        }
    }

    /// The number of points of a sample.
    pub(crate) fn len(&self) -> usize {
        self.points.len() / self.samples
    }

    /// The points of this sample for the light with this index, as many as `out` has room for; all within the disc.
    pub(crate) fn of(&self, at: PixelSample, light: u32, out: &mut [[f64; 2]]) {
        let turn = turn(at, light);
        let own = self.points.iter().skip(at.sample as usize % self.samples).step_by(self.samples);
        out.iter_mut().zip(own).for_each(|(out, point)| *out = times(turn, *point));
    }

    /// Points on the rim for the light with this index; none where there are several samples.
    pub(crate) fn rim(&self, at: PixelSample, light: u32) -> impl Iterator<Item = [f64; 2]> {
        let turn = turn(at, light);
        self.rim.iter().filter(|_| self.samples == 1).map(move |point| times(turn, *point))
    }
}

/// The point of the unit disc of a lens that this sample of all pixels leaves from. The points of `strata` x `strata`
/// samples are Vogel's spiral, turned by `seed`. Row and column of the sample within the pixel choose a ring of it and a
/// place in the ring, such that the samples of each row, and of each column, have all rings and all places.
pub(crate) fn lens_point(strata: u32, sample: u32, seed: u32) -> [f64; 2] {
    let (row, column) = (sample / strata, sample % strata);
    let place = strata * ((row + column) % strata) + (row + 2 * column) % strata;
    let turned = PixelSample { row: 0, column: 0, sample: 0, seed }.turn(LENS);
    let found = spiral(strata * strata).nth(place as usize);
    found.map_or([0.0; 2], |(area, turn)| times(turned, turn).map(|x| area.sqrt() * x))
}

/// The purpose of a lens's random numbers: more than any light's.
const LENS: u32 = u32::MAX;

/// The turn of the points of a light, as cosine and sine: the same for all samples of a pixel.
fn turn(at: PixelSample, light: u32) -> [f64; 2] {
    // The purpose 0 is the sky.
    PixelSample { sample: 0, ..at }.turn(light.wrapping_add(1))
}
