//! Directions toward the sky and points of a disc, for rays from a hit: evenly spread sets that each sample of each
//! pixel turns at random.
//!
//! A set is made once per frame. The turn is a hash of the pixel's row and column in the full frame, the sample and the
//! seed, so that crops, tiles and frames agree. All arithmetic is + - * / and square roots of f64 in a fixed order, which
//! IEEE 754 determines to the last bit: the numbers are the same on every machine, and are taken as exact afterwards.

#[cfg(test)]
mod tests;

use super::records::pcg4d;

/// Cosine and sine of the golden angle, pi (3 - sqrt 5).
const GOLDEN: [f64; 2] = [-0.737_368_878_078_319_9, 0.675_490_294_261_523_6];

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

/// N directions for rays toward the sky.
///
/// They are a spherical Fibonacci lattice on a hemisphere. Each is meant up to its sign: the caller turns it to the side
/// of the normal n. The lattice and its mirror image together are evenly spread on the sphere, so that is so for every n.
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
/// cells, up to all of them; then the error is about that of independent directions.
///
/// As a quotient of two sums the estimate also has a bias: 0.2 with N = 1 and 0.08 with N = 2, but 0.006 with N = 4 and
/// 0.003 with N = 16, which is the noise of that measurement. So the shares of several sets of fewer than 4 should not
/// be averaged; the quotient of the sums over all sets can be taken instead.
#[derive(Debug, Clone)]
pub(crate) struct SkyDirections {
    lattice: Vec<[f64; 3]>,
}

impl SkyDirections {
    /// `count` directions.
    pub(crate) fn new(count: u32) -> Self {
        let point = |(z, [x, y]): (f64, [f64; 2])| {
            let r = (1.0 - z * z).sqrt();
            [r * x, r * y, z]
        };
        Self { lattice: spiral(count).map(point).collect() }
    }

    /// The number of directions.
    pub(crate) fn len(&self) -> usize {
        self.lattice.len()
    }

    /// The directions of this sample, in world space, as many as `out` has room for. Their length is 1 within 2^-22.
    pub(crate) fn of(&self, at: PixelSample, out: &mut [[f32; 3]]) {
        let rows = at.rotation(0);
        for (out, p) in out.iter_mut().zip(&self.lattice) {
            *out = rows.map(|row| (row[0] * p[0] + row[1] * p[1] + row[2] * p[2]) as f32);
        }
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

/// How the points of a light are turned: the same for all samples of a pixel.
fn turn(at: PixelSample, light: u32) -> [f64; 2] {
    // The purpose 0 is the sky.
    PixelSample { sample: 0, ..at }.turn(light.wrapping_add(1))
}
