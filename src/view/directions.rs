//! Directions toward the sky and points of a disc, for rays from a hit: evenly spread sets that each sample of each
//! pixel turns at random.
//!
//! A set is made once per frame. The turn is a hash of the pixel's row and column in the full frame, the sample and the
//! seed, so that crops, tiles and frames agree. All arithmetic is + - * / and square roots of f64 in a fixed order, which
//! IEEE 754 determines to the last bit: the numbers are the same on every machine, and are taken as exact afterwards.

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
/// standard error over the rotations was measured for a cap of the sky in any direction and of any size that hides what
/// lies behind it (`tests`; 60 caps, 2000 rotations, N = 4, 16, 64, 256):
///
/// ```text
/// standard error <= 0.6 N^-3/4 for every cap      0.38 to 0.32 N^-3/4 in the mean square      N = 16: 0.043
/// ```
///
/// The reason: each direction stands for a cell of the sphere of area 2 pi/N. A cell that is all open or all hidden has
/// almost no error. The edge of a cap crosses a number of cells proportional to sqrt N, each with an error proportional
/// to 1/N and almost independent of the others, so the variance is proportional to N^(1/2 - 2). Independent directions
/// have 0.76 N^-3/4 at N = 16 and 1.5 N^-3/4 at N = 256, since they follow N^-1/2. Where many small spheres hide the sky, their edges cross more
/// cells, up to all of them; then the error is that of independent directions.
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
/// The share of the disc on one side of a random chord has a standard error of at most 0.4 N^-3/4, for the reason that
/// [`SkyDirections`] gives.
#[derive(Debug, Clone)]
pub(crate) struct DiscPoints {
    points: Vec<[f64; 2]>,
}

impl DiscPoints {
    /// `count` points.
    pub(crate) fn new(count: u32) -> Self {
        let point = |(area, turn): (f64, [f64; 2])| turn.map(|x| area.sqrt() * x);
        Self { points: spiral(count).map(point).collect() }
    }

    /// The number of points.
    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    /// The points of this sample for the light with this index, as many as `out` has room for; all within the disc.
    pub(crate) fn of(&self, at: PixelSample, light: u32, out: &mut [[f64; 2]]) {
        // The purpose 0 is the sky.
        let turn = at.turn(light.wrapping_add(1));
        for (out, point) in out.iter_mut().zip(&self.points) {
            *out = times(turn, *point);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Rng;
    use std::f64::consts::{PI, SQRT_2};

    type Direction = [f64; 3];

    /// The sample with this number in a frame of 64 columns and 4 samples a pixel.
    fn sample(number: u32) -> PixelSample {
        PixelSample { row: number / 256, column: number / 4 % 64, sample: number % 4, seed: 0 }
    }

    fn sky(set: &SkyDirections, at: PixelSample) -> Vec<Direction> {
        let mut out = vec![[0.0; 3]; set.len()];
        set.of(at, &mut out);
        out.into_iter().map(|l| l.map(f64::from)).collect()
    }

    fn disc(set: &DiscPoints, at: PixelSample, light: u32) -> Vec<[f64; 2]> {
        let mut out = vec![[0.0; 2]; set.len()];
        set.of(at, light, &mut out);
        out
    }

    fn dot(a: Direction, b: Direction) -> f64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    /// A direction, uniform on the sphere.
    fn random_direction(rng: &mut Rng) -> Direction {
        let (z, angle) = (rng.between(-1.0, 1.0), rng.between(0.0, 2.0 * PI));
        let r = (1.0 - z * z).sqrt();
        [r * angle.cos(), r * angle.sin(), z]
    }

    /// sum(w open)/sum(w) with each direction turned to the side of `n`.
    fn open_share(directions: &[Direction], n: Direction, open: impl Fn(Direction) -> bool) -> f64 {
        let (mut sum, mut all) = (0.0, 0.0);
        for &l in directions {
            let cosine = dot(n, l);
            let l = if cosine < 0.0 { l.map(|x| -x) } else { l };
            all += cosine.abs();
            sum += if open(l) { cosine.abs() } else { 0.0 };
        }
        sum / all
    }

    /// Mean and standard deviation.
    fn moments(values: &[f64]) -> [f64; 2] {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / values.len() as f64;
        [mean, variance.sqrt()]
    }

    #[test]
    fn the_bits_are_those_of_another_implementation() {
        let at = PixelSample { row: 7, column: 11, sample: 3, seed: 5 };
        let mut out = [[0.0; 3]; 16];
        SkyDirections::new(16).of(at, &mut out);
        assert_eq!(out[15].map(f32::to_bits), [0xbde5_b415, 0x3f78_2770, 0x3e5f_d384]);
        let point = disc(&DiscPoints::new(9), at, 2)[8];
        assert_eq!(point.map(f64::to_bits), [0x3fdf_277d_eceb_709e, 0x3fea_ea76_729b_1af8]);
    }

    #[test]
    fn sets_repeat_and_differ_between_samples_pixels_seeds_and_lights() {
        let at = PixelSample { row: 7, column: 11, sample: 3, seed: 5 };
        let others = [
            PixelSample { row: 8, ..at },
            PixelSample { column: 12, ..at },
            PixelSample { sample: 2, ..at },
            PixelSample { seed: 6, ..at },
            PixelSample { row: 11, column: 7, ..at },
        ];
        let (set, points) = (SkyDirections::new(16), DiscPoints::new(16));
        assert_eq!(sky(&set, at), sky(&SkyDirections::new(16), at));
        assert_eq!(disc(&points, at, 1), disc(&DiscPoints::new(16), at, 1));
        assert_ne!(disc(&points, at, 0), disc(&points, at, 1));
        for other in others {
            assert_ne!(sky(&set, at), sky(&set, other), "{other:?}");
            assert_ne!(disc(&points, at, 0), disc(&points, other, 0), "{other:?}");
        }
        // A shorter list has the same beginning.
        let mut few = [[0.0; 3]; 4];
        set.of(at, &mut few);
        assert_eq!(few.map(|l| l.map(f64::from)), sky(&set, at)[..4]);
    }

    #[test]
    fn directions_have_length_one_and_points_lie_in_the_disc() {
        for count in [1, 2, 3, 16, 1000, 1 << 20] {
            let (set, points) = (SkyDirections::new(count), DiscPoints::new(count));
            for number in 0..if count > 1000 { 1 } else { 100 } {
                for l in sky(&set, sample(number)) {
                    let length = dot(l, l).sqrt();
                    assert!((length - 1.0).abs() < 1.0 / f64::from(1 << 22), "{l:?}: {length}");
                }
                assert!(disc(&points, sample(number), 0).into_iter().all(|p| square(p) < 1.0));
            }
        }
    }

    /// Every direction of the set is uniform on the sphere, whatever its place in it, and so are rotations about it.
    #[test]
    fn rotations_are_uniform() {
        const MANY: u32 = 1 << 16;
        let mut sums = [[0.0; 4]; 9];
        let (mut traces, mut cross) = ([0.0; 2], [0.0; 36]);
        for number in 0..MANY {
            let rows = sample(number).rotation(0);
            let entries = rows.as_flattened();
            for (sums, x) in sums.iter_mut().zip(entries) {
                let square = x * x;
                [*x, square, square * x, square * square].iter().zip(sums).for_each(|(power, sum)| *sum += power);
            }
            let trace = rows[0][0] + rows[1][1] + rows[2][2];
            traces = [traces[0] + trace, traces[1] + trace * trace];
            let pairs = (0..9).flat_map(|i| (0..i).map(move |j| (i, j)));
            cross.iter_mut().zip(pairs).for_each(|(sum, (i, j))| *sum += entries[i] * entries[j]);
        }
        // Over all rotations an entry is uniform between -1 and 1, the entries are uncorrelated, and the square of the
        // trace has the mean 1. No summand has a larger deviation than 1.5, so five deviations of the mean are below
        // 7.5/sqrt(MANY), 0.03; those of an entry's powers are below 0.6 each, so 0.012.
        let off = |sum: f64, expected: f64| (sum / f64::from(MANY) - expected).abs();
        for sums in sums {
            let expected = [0.0, 1.0 / 3.0, 0.0, 1.0 / 5.0];
            assert!(sums.iter().zip(expected).all(|(sum, x)| off(*sum, x) < 0.012), "{sums:?}");
        }
        assert!(cross.iter().all(|sum| off(*sum, 0.0) < 0.012), "{cross:?}");
        assert!(off(traces[0], 0.0) < 0.03 && off(traces[1], 1.0) < 0.03, "{traces:?}");
    }

    #[test]
    fn caps_of_the_sphere_hold_their_share_of_directions() {
        const MANY: u32 = 2000;
        let (set, mut rng) = (SkyDirections::new(16), Rng(1));
        let all: Vec<Direction> = (0..MANY).flat_map(|number| sky(&set, sample(number))).collect();
        for _ in 0..50 {
            let (axis, cosine) = (random_direction(&mut rng), rng.unit());
            // With its mirror image a direction lies in the cap or in the opposite one.
            let inside = all.iter().filter(|l| dot(**l, axis).abs() > cosine).count() as f64;
            let (expected, count) = (1.0 - cosine, all.len() as f64);
            // Five deviations of independent directions; those of evenly spread ones are smaller.
            let limit = 5.0 * (expected * cosine / count).sqrt();
            assert!((inside / count - expected).abs() < limit, "{inside} of {count} beyond {cosine}");
        }
    }

    /// The doc comment of [`SkyDirections`] states these bounds.
    #[test]
    fn the_open_share_has_the_standard_error_that_is_stated() {
        const MANY: u32 = 300;
        let mut rng = Rng(2);
        let cases: Vec<_> =
            (0..40).map(|_| (random_direction(&mut rng), random_direction(&mut rng), rng.between(-1.0, 1.0))).collect();
        for count in [4, 16, 64, 256] {
            let set = SkyDirections::new(count);
            let law = f64::from(count).powf(-0.75);
            let sets: Vec<_> = (0..MANY).map(|number| sky(&set, sample(number))).collect();
            // Sets of one are independent.
            let lone = SkyDirections::new(1);
            let loose: Vec<_> = (0..MANY * count).map(|number| sky(&lone, sample(number))[0]).collect();
            let loose: Vec<_> = loose.chunks_exact(count as usize).map(<[_]>::to_vec).collect();
            let error = |sets: &[Vec<Direction>], (n, axis, cosine): (Direction, Direction, f64)| {
                let shares: Vec<f64> = sets.iter().map(|set| open_share(set, n, |l| dot(l, axis) <= cosine)).collect();
                let [mean, deviation] = moments(&shares);
                // Where the mean is known: half-spaces, and caps above the horizon.
                let facing = dot(n, axis);
                let hidden = match cosine {
                    0.0 => Some((1.0 + facing) / 2.0),
                    _ if cosine > 0.0 && facing * facing > 1.0 - cosine * cosine => {
                        Some(facing.max(0.0) * (1.0 - cosine * cosine))
                    }
                    _ => None,
                };
                if let Some(hidden) = hidden {
                    // Five deviations of the mean over the rotations. A quotient of sums has a bias, of second order in
                    // the deviations of both: below 1/10 of 1/N, as measured, with the smallest N.
                    let limit = 5.0 * deviation / f64::from(MANY).sqrt() + 0.1 / f64::from(count);
                    assert!((mean - 1.0 + hidden).abs() < limit, "{count}: {mean} of {}", 1.0 - hidden);
                }
                deviation / law
            };
            let summary = |sets: &[Vec<Direction>], flat: bool| {
                let of = |&(n, axis, cosine): &(_, _, f64)| error(sets, (n, axis, if flat { 0.0 } else { cosine }));
                let errors: Vec<f64> = cases.iter().map(of).collect();
                let mean = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
                [mean.sqrt(), errors.into_iter().fold(0.0, f64::max)]
            };
            let [caps, halves, independent] = [summary(&sets, false), summary(&sets, true), summary(&loose, false)];
            println!("N = {count}: caps {caps:.3?}, half-spaces {halves:.3?}, independent {independent:.3?} N^-3/4");
            assert!(caps[0] < 0.42 && caps[1] < 0.6 && halves[0] < 0.46 && halves[1] < 0.6, "{caps:?} {halves:?}");
            assert!(count < 16 || independent[0] > 0.65, "independent directions exceed the bound: {independent:?}");
        }
    }

    #[test]
    fn the_share_of_a_disc_beyond_a_chord_has_the_standard_error_that_is_stated() {
        const MANY: u32 = 1000;
        for count in [4, 16, 64, 256] {
            let set = DiscPoints::new(count);
            let law = f64::from(count).powf(-0.75);
            for distance in [0.0, 0.3, 0.5, 1.0 / SQRT_2, 0.9] {
                let beyond = |number: u32| {
                    let points = disc(&set, sample(number), 0);
                    points.iter().filter(|p| p[0] > distance).count() as f64 / points.len() as f64
                };
                let [mean, deviation] = moments(&(0..MANY).map(beyond).collect::<Vec<_>>());
                let expected = (distance.acos() - distance * (1.0 - distance * distance).sqrt()) / PI;
                println!("N = {count}, chord at {distance:.2}: {:.3} N^-3/4", deviation / law);
                assert!(deviation < 0.4 * law, "{count} {distance}");
                // The mean differs from the area by the set itself: at most what one point stands for, in part.
                let limit = 5.0 * deviation / f64::from(MANY).sqrt() + 0.1 / f64::from(count);
                assert!((mean - expected).abs() < limit, "{count} {distance}: {mean} {expected}");
            }
        }
    }
}
