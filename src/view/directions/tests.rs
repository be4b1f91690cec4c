use super::*;
use crate::testing::Rng;
use std::f64::consts::{PI, SQRT_2};

type Direction = [f64; 3];

/// The pixel with this number in a frame of 64 columns.
fn pixel(number: u32) -> PixelSample {
    PixelSample { row: number / 64, column: number % 64, sample: 0, seed: 0 }
}

/// Directions for the only sample of a pixel.
fn alone(count: u32) -> SkyDirections {
    SkyDirections::new(count, 1, 0)
}

fn sky(set: &SkyDirections, at: PixelSample) -> Vec<Direction> {
    set.of(at, 0).iter().map(|l| l.map(f64::from)).collect()
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

/// Caps that hide the sky from surfaces: the normal, the axis of the cap, and the cosine of its angle, at random.
struct Caps(Vec<(Direction, Direction, f64)>);

impl Caps {
    fn new(seed: u64) -> Self {
        let rng = &mut Rng(seed);
        Self((0..40).map(|_| (random_direction(rng), random_direction(rng), rng.between(-1.0, 1.0))).collect())
    }

    /// Root mean square over the caps of the standard error of the open share, over trials. The share of a trial is the mean
    /// over its sets of directions.
    fn error(&self, trials: &[Vec<Vec<Direction>>]) -> f64 {
        let variance = |&(n, axis, cosine): &(Direction, Direction, f64)| {
            let share = |set: &Vec<Direction>| open_share(set, n, |l| dot(l, axis) <= cosine);
            let mean = |sets: &Vec<Vec<_>>| sets.iter().map(share).sum::<f64>() / sets.len() as f64;
            moments(&trials.iter().map(mean).collect::<Vec<_>>())[1].powi(2)
        };
        (self.0.iter().map(variance).sum::<f64>() / self.0.len() as f64).sqrt()
    }
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
    let last = |set: SkyDirections, depth: u32| set.of(at, depth).last().map(|l| l.map(f32::to_bits));
    assert_eq!(last(alone(16), 0), Some([0x3f77_be5b, 0x3e65_0909, 0xbded_6483]));
    assert_eq!(last(SkyDirections::new(16, 2, 3), 0), Some([0x3f7d_b1f0, 0xbdfb_5ae9, 0xbd5b_2a8d]));
    assert_eq!(last(SkyDirections::one(3, 5), 2), Some([0xbe93_1f8f, 0x3f70_e90f, 0xbe36_bab1]));
    let point = disc(&DiscPoints::new(9, 1), at, 2)[8];
    assert_eq!(point.map(f64::to_bits), [0x3fe7_e9b0_030c_5ee2, 0xbfe3_e1bf_8128_9d06]);
}

#[test]
fn samples_leave_from_all_over_the_lens_whatever_their_place_in_the_pixel() {
    for strata in [1, 2, 3, 8] {
        let points: Vec<_> = (0..strata * strata).map(|sample| lens_point(strata, sample, 7)).collect();
        // Each ring of the spiral, and so each radius, occurs once in each row and column of samples.
        let ring = |sample: u32| (square(points[sample as usize]) * f64::from(strata)) as u32;
        for line in 0..strata {
            let mut rings: Vec<_> = (0..strata).map(|n| [ring(line * strata + n), ring(n * strata + line)]).collect();
            rings.sort_unstable_by_key(|[row, _]| *row);
            assert!(rings.iter().map(|[row, _]| *row).eq(0..strata), "{strata}: {rings:?}");
            rings.sort_unstable_by_key(|[_, column]| *column);
            assert!(rings.iter().map(|[_, column]| *column).eq(0..strata), "{strata}: {rings:?}");
        }
        let expected: Vec<f64> = spiral(strata * strata).map(|(area, _)| area).collect();
        let mut areas: Vec<f64> = points.iter().map(|point| square(*point)).collect();
        areas.sort_by(f64::total_cmp);
        assert!(areas.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{strata}: all points, once");
        assert_ne!(lens_point(strata, 0, 7), lens_point(strata, 0, 8), "another seed turns the lens");
    }
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
    let (set, points) = (alone(16), DiscPoints::new(16, 1));
    assert_eq!(sky(&set, at), sky(&alone(16), at));
    assert_eq!(disc(&points, at, 1), disc(&DiscPoints::new(16, 1), at, 1));
    assert_ne!(disc(&points, at, 0), disc(&points, at, 1));
    for other in others {
        // The samples of a pixel share one lattice, and one spiral.
        let same = [sky(&set, at) == sky(&set, other), disc(&points, at, 0) == disc(&points, other, 0)];
        assert_eq!(same, [other.sample != at.sample; 2], "{other:?}");
    }
    let parts = DiscPoints::new(4, 4);
    let all = disc(&points, at, 0);
    for sample in 0..4 {
        let own: Vec<_> = all.iter().copied().skip(sample).step_by(4).collect();
        assert_eq!(disc(&parts, PixelSample { sample: sample as u32, ..at }, 0), own);
    }
    let rim: Vec<_> = points.rim(at, 0).collect();
    assert!(rim.len() == 16 && rim.iter().all(|[x, y]| (x * x + y * y - 1.0).abs() < 1e-14), "{rim:?}");
    assert_eq!(parts.rim(at, 0).count(), 0);
}

#[test]
fn directions_have_length_one_and_points_lie_in_the_disc() {
    for count in [1, 2, 3, 16, 1000, 1 << 12] {
        let (set, points) = (alone(count), DiscPoints::new(count, 1));
        for number in 0..if count > 1000 { 1 } else { 100 } {
            for l in sky(&set, pixel(number)) {
                let length = dot(l, l).sqrt();
                assert!((length - 1.0).abs() < 1.0 / f64::from(1 << 22), "{l:?}: {length}");
            }
            assert!(disc(&points, pixel(number), 0).into_iter().all(|p| square(p) < 1.0));
        }
    }
}

/// Every direction of the set is uniform on the sphere, whatever its place in it, and so are rotations about it.
#[test]
fn rotations_are_uniform() {
    const PIXELS: u32 = 1 << 16;
    let mut sums = [[0.0; 4]; 9];
    let (mut traces, mut cross) = ([0.0; 2], [0.0; 36]);
    for number in 0..PIXELS {
        let rows = pixel(number).rotation(0);
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
    // 7.5/sqrt(MANY), 0.03; the deviations of an entry's powers are below 0.6 each, so 0.012.
    let off = |sum: f64, expected: f64| (sum / f64::from(PIXELS) - expected).abs();
    for sums in sums {
        let expected = [0.0, 1.0 / 3.0, 0.0, 1.0 / 5.0];
        assert!(sums.iter().zip(expected).all(|(sum, x)| off(*sum, x) < 0.012), "{sums:?}");
    }
    assert!(cross.iter().all(|sum| off(*sum, 0.0) < 0.012), "{cross:?}");
    assert!(off(traces[0], 0.0) < 0.03 && off(traces[1], 1.0) < 0.03, "{traces:?}");
}

#[test]
fn caps_of_the_sphere_hold_their_share_of_directions() {
    const PIXELS: u32 = 2000;
    let (set, mut rng) = (alone(16), Rng(1));
    let all: Vec<Direction> = (0..PIXELS).flat_map(|number| sky(&set, pixel(number))).collect();
    for _ in 0..50 {
        let (axis, cosine) = (random_direction(&mut rng), rng.unit());
        // With its mirror image a direction lies in the cap or in the opposite one.
        let inside = all.iter().filter(|l| dot(**l, axis).abs() > cosine).count() as f64;
        let (expected, count) = (1.0 - cosine, all.len() as f64);
        // Five deviations of independent directions; the deviations of evenly spread ones are smaller.
        let limit = 5.0 * (expected * cosine / count).sqrt();
        assert!((inside / count - expected).abs() < limit, "{inside} of {count} beyond {cosine}");
    }
}

/// The doc comment of [`SkyDirections`] states these bounds.
#[test]
fn the_open_share_has_the_standard_error_that_is_stated() {
    const PIXELS: u32 = 300;
    let mut rng = Rng(2);
    let cases: Vec<_> =
        (0..40).map(|_| (random_direction(&mut rng), random_direction(&mut rng), rng.between(-1.0, 1.0))).collect();
    let flat: Vec<_> = cases.iter().map(|&(n, axis, _)| (n, axis, 0.0)).collect();
    for count in [4, 16, 64, 256] {
        let set = alone(count);
        let law = f64::from(count).powf(-0.75);
        let sets: Vec<_> = (0..PIXELS).map(|number| sky(&set, pixel(number))).collect();
        // Sets of one are independent.
        let lone = alone(1);
        let loose: Vec<_> = (0..PIXELS * count).map(|number| sky(&lone, pixel(number))[0]).collect();
        let loose: Vec<_> = loose.chunks_exact(count as usize).map(<[_]>::to_vec).collect();
        let error = |sets: &[Vec<Direction>], (n, axis, cosine): (Direction, Direction, f64)| {
            let shares: Vec<f64> = sets.iter().map(|set| open_share(set, n, |l| dot(l, axis) <= cosine)).collect();
            moments(&shares)
        };
        let summary = |sets: &[Vec<Direction>], cases: &[(Direction, Direction, f64)]| {
            let errors = || cases.iter().map(|case| error(sets, *case)[1] / law);
            [(errors().map(|e| e * e).sum::<f64>() / cases.len() as f64).sqrt(), errors().fold(0.0, f64::max)]
        };
        for &(n, axis, cosine) in cases.iter().chain(&flat) {
            // Where the mean is known: half-spaces, and caps above the horizon.
            let (facing, sine2) = (dot(n, axis), 1.0 - cosine * cosine);
            let hidden = match cosine {
                0.0 => (1.0 + facing) / 2.0,
                _ if cosine > 0.0 && facing * facing > sine2 => facing.max(0.0) * sine2,
                _ => continue,
            };
            let [mean, deviation] = error(&sets, (n, axis, cosine));
            // Five deviations of the mean over the rotations.
            let limit = 5.0 * deviation / f64::from(PIXELS).sqrt() + 0.03 / f64::from(count);
            assert!((mean - 1.0 + hidden).abs() < limit, "{count}: {mean} of {}", 1.0 - hidden);
        }
        let [caps, halves, independent] =
            [(&sets, &cases), (&sets, &flat), (&loose, &cases)].map(|(s, c)| summary(s, c));
        println!("N = {count}: caps {caps:.3?}, half-spaces {halves:.3?}, independent {independent:.3?} N^-3/4");
        // The measured values, and a tenth for the noise of fewer caps and rotations.
        assert!(caps[0] < 0.43 && caps[1] < 0.7 && halves[0] < 0.48 && halves[1] < 0.6, "{caps:?} {halves:?}");
        assert!(independent[0] > 0.52 && independent[0] > 1.3 * caps[0], "{independent:?} {caps:?}");
    }
}

/// The part of one sample is as good as a lattice of its own, and the parts of all samples as one lattice.
/// [`SkyDirections`] states it.
#[test]
fn samples_share_a_lattice_of_which_each_has_an_even_part() {
    const PIXELS: u32 = 300;
    let caps = Caps::new(3);
    // Over the rotations, of the shares' mean over some samples.
    let error = |sets: &[SkyDirections]| {
        let turned: Vec<Vec<_>> =
            (0..PIXELS).map(|number| sets.iter().map(|set| sky(set, pixel(number))).collect()).collect();
        caps.error(&turned)
    };
    for (rays, strata) in [(4, 2), (4, 3), (4, 4), (4, 8), (4, 12), (16, 3)] {
        let samples = strata * strata;
        let sets: Vec<_> = (0..samples).map(|sample| SkyDirections::new(rays, strata, sample)).collect();
        let own = (0..samples).step_by(strata as usize + 1).map(|s| error(&sets[s as usize..=s as usize]));
        let (own, alone, all) = (own.fold(0.0, f64::max), error(&[alone(rays)]), error(&sets));
        let apart = alone / f64::from(strata);
        println!(
            "{samples} x {rays}: one {:.3} of a lattice of its own, all {:.3} of as many",
            own / alone,
            all / apart
        );
        // The lowest and the highest of the shifted lattices are a little worse. Measured for all of them: 0.8 with 4
        // samples, 0.5 to 0.6 with more; and a tenth for the noise of caps and rotations.
        let limit = if strata == 2 { 0.88 } else { 0.66 };
        assert!(own < 1.2 * alone && all < limit * apart, "{samples} x {rays}");
    }
}

/// The pixels of a picture's square share one lattice, and the pixels of every part of it a coarser one. [`SkyDirections`] states it.
#[test]
fn neighbors_of_a_picture_share_a_lattice_of_which_each_has_an_even_part() {
    const SEEDS: u32 = 100;
    let caps = Caps::new(5);
    // The directions of the pixels of a square of this side, at a place that is a multiple of it.
    let square_of = |set: &SkyDirections, side: u32| -> Vec<Direction> {
        let places = (0..side * side).map(|n| [24 + n / side, 40 + n % side]);
        places.flat_map(|[row, column]| sky(set, PixelSample { row, column, sample: 0, seed: 0 })).collect()
    };
    for rays in [1, 3, 4, 8] {
        let sets: Vec<_> = (0..SEEDS).map(|seed| SkyDirections::interleaved(rays, 1, 0, seed)).collect();
        for side in [1, 2, 4, 8] {
            let found = caps.error(&sets.iter().map(|set| vec![square_of(set, side)]).collect::<Vec<_>>());
            let count = rays * side * side;
            // As many directions as one lattice of them all, turned at random.
            let one = SkyDirections::new(count, 1, 0);
            let alone = caps.error(&(0..SEEDS).map(|number| vec![sky(&one, pixel(number))]).collect::<Vec<_>>());
            println!("{side} x {side} pixels of {rays}: {:.3} of one lattice", found / alone);
            // Measured: up to 1.25, of single pixels at the top and the bottom of the lattice; and a tenth for the noise of caps and
            // rotations.
            assert!(found < 1.4 * alone, "{side} x {side} x {rays}: {found} {alone}");
        }
    }
    let set = |seed: u32| SkyDirections::interleaved(3, 2, 1, seed);
    let at = |row: u32, column: u32| PixelSample { row, column, sample: 1, seed: 7 };
    assert_eq!(sky(&set(7), at(3, 5)), sky(&set(7), at(3 + 8, 5 + 16)), "they repeat");
    assert_ne!(sky(&set(7), at(3, 5)), sky(&set(7), at(3, 6)));
    assert_ne!(sky(&set(7), at(3, 5)), sky(&set(8), at(3, 5)), "another seed turns the lattice");
}

/// The directions in which the samples of a pixel scatter a ray: on all sides alike, and evenly.
#[test]
fn the_single_directions_of_samples_are_even_on_the_sphere() {
    const PIXELS: u32 = 300;
    let (mut rng, strata) = (Rng(4), 4);
    let sets: Vec<_> = (0..strata * strata).map(|sample| SkyDirections::one(strata, sample)).collect();
    for _ in 0..20 {
        let (axis, cosine) = (random_direction(&mut rng), rng.between(-0.9, 0.9));
        let share = |number: u32| {
            let inside = sets.iter().filter(|set| dot(sky(set, pixel(number))[0], axis) > cosine).count();
            inside as f64 / sets.len() as f64
        };
        let [mean, deviation] = moments(&(0..PIXELS).map(share).collect::<Vec<_>>());
        let expected = (1.0 - cosine) / 2.0;
        let independent = (expected * (1.0 - expected) / f64::from(strata * strata)).sqrt();
        println!("cap beyond {cosine:.2}: {:.2} of independent directions", deviation / independent);
        // Five deviations of the mean over the rotations.
        assert!((mean - expected).abs() < 5.0 * deviation / f64::from(PIXELS).sqrt() + 1e-9, "{mean} {expected}");
        assert!(deviation < 0.9 * independent, "{cosine}: {deviation} {independent}");
    }
}

#[test]
fn the_share_of_a_disc_beyond_a_chord_has_the_standard_error_that_is_stated() {
    const PIXELS: u32 = 1000;
    for count in [4, 16, 64, 256] {
        let set = DiscPoints::new(count, 1);
        let law = f64::from(count).powf(-0.75);
        for distance in [0.0, 0.3, 0.5, 1.0 / SQRT_2, 0.9] {
            let beyond = |number: u32| {
                let points = disc(&set, pixel(number), 0);
                points.iter().filter(|p| p[0] > distance).count() as f64 / points.len() as f64
            };
            let [mean, deviation] = moments(&(0..PIXELS).map(beyond).collect::<Vec<_>>());
            let expected = (distance.acos() - distance * (1.0 - distance * distance).sqrt()) / PI;
            println!("N = {count}, chord at {distance:.2}: {:.3} N^-3/4", deviation / law);
            assert!(deviation < 0.5 * law, "{count} {distance}");
            // The mean differs from the area by the set itself: at most what one point stands for, in part.
            let limit = 5.0 * deviation / f64::from(PIXELS).sqrt() + 0.1 / f64::from(count);
            assert!((mean - expected).abs() < limit, "{count} {distance}: {mean} {expected}");
        }
    }
}
