//! Particles near others and their number, by a tree of boxes.

use halfline_ground::error::Result;
use halfline_ground::memory::check;
use halfline_ground::parallel;

/// Bytes per point in the tree.
const POINT: u64 = 64;

/// Points that one job looks around.
const POINTS_PER_JOB: usize = 1 << 8;

/// Points that are not divided.
const FEW: usize = 16;

/// The factor by which a distance to a box may be rounded up, so that a point at exactly the reach is found.
const SPARE: f64 = 1.0 + 1e-12;

/// Points in a box, which is the smallest around them.
struct Boxed {
    low: [f64; 3],
    high: [f64; 3],
    /// The number of points.
    count: u64,
    inside: Inside,
}

enum Inside {
    Points(Vec<[f64; 3]>),
    Halves(Box<[Boxed; 2]>),
}

/// A distance, with the squares below which a distance is surely at most it, and above which it is surely more: the sum of three squares
/// has an error of some 2^-52 of itself. Between them, and where squares are beyond f64, [`length`] says it.
#[derive(Clone, Copy)]
struct Reach {
    length: f64,
    inside: f64,
    outside: f64,
}

impl Reach {
    fn new(length: f64) -> Self {
        let square = length * length;
        let [inside, outside] = match (1e-280..1e280).contains(&square) {
            true => [square * (1.0 - 1e-14), square * (1.0 + 1e-14)],
            false => [f64::NEG_INFINITY, f64::INFINITY],
        };
        Self { length, inside, outside }
    }

    /// Whether a lower bound of a distance is surely more.
    fn is_below(&self, away: [f64; 3]) -> bool {
        if self.outside < f64::INFINITY {
            square(away) > self.outside * SPARE
        } else {
            length(away) > self.length * SPARE
        }
    }

    /// Whether an upper bound of a distance is surely at most this one.
    fn is_above(&self, across: [f64; 3]) -> bool {
        if self.outside < f64::INFINITY {
            square(across) * SPARE <= self.inside
        } else {
            length(across) * SPARE <= self.length
        }
    }

    /// The number of the others that are at most this far away.
    fn count(&self, point: &[f64; 3], others: &[[f64; 3]]) -> u64 {
        let apart = |other: &[f64; 3]| [0, 1, 2].map(|k| point[k] - other[k]);
        let (mut sure, mut perhaps) = (0, 0);
        for other in others {
            let square = square(apart(other));
            sure += u64::from(square <= self.inside);
            perhaps += u64::from(square <= self.outside);
        }
        let is_near = |other: &&[f64; 3]| length(apart(other)) <= self.length;
        if sure == perhaps { sure } else { others.iter().filter(is_near).count() as u64 }
    }
}

/// Whether each of `points` is at most `reach` away from one of those that are `chosen`. Distances between centres, not
/// periodic; a chosen point is near itself.
///
/// # Errors
/// [`Error::Limits`](halfline_ground::error::Error::Limits) where memory is short.
pub(super) fn near(points: &[[f64; 3]], chosen: &[bool], reach: f64) -> Result<Vec<bool>> {
    let count = parallel::count(chosen.len(), |n| chosen[n]) as u64;
    check(POINT.saturating_mul(count), || format!("the distances to {count} selected particles"))?;
    let mut others: Vec<[f64; 3]> =
        points.iter().zip(chosen).filter(|(_, chosen)| **chosen).map(|(point, _)| *point).collect();
    let all = Boxed::around(&mut others);
    let found = |n: usize| chosen[n] || all.has(&points[n], reach);
    Ok(parallel::values(points.len(), POINTS_PER_JOB, found))
}

/// The number of other points at most `reach` away from each, in their images at `shifts` too; one shift is 0. A point counts each of
/// its own images.
///
/// # Errors
/// [`Error::Limits`](halfline_ground::error::Error::Limits) where memory is short.
pub(super) fn counts(points: &[[f64; 3]], shifts: &[[f64; 3]], reach: f64) -> Result<Vec<u64>> {
    check(POINT.saturating_mul(points.len() as u64), || format!("the neighbours of {} particles", points.len()))?;
    let (all, reach) = (Boxed::around(&mut points.to_vec()), Reach::new(reach));
    let moved = |point: &[f64; 3], shift: &[f64; 3]| [0, 1, 2].map(|k| point[k] + shift[k]);
    // The point itself is among those around it.
    let of = |n: usize| shifts.iter().map(|shift| all.count(&moved(&points[n], shift), &reach)).sum::<u64>() - 1;
    Ok(parallel::values(points.len(), POINTS_PER_JOB, of))
}

fn square([x, y, z]: [f64; 3]) -> f64 {
    x * x + y * y + z * z
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

impl Boxed {
    fn around(points: &mut [[f64; 3]]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in &*points {
            for k in 0..3 {
                (low[k], high[k]) = (low[k].min(point[k]), high[k].max(point[k]));
            }
        }
        let count = points.len() as u64;
        if points.len() <= FEW {
            return Self { low, high, count, inside: Inside::Points(points.to_vec()) };
        }
        let side = |k: &usize| high[*k] - low[*k];
        let longest = (0..3).max_by(|a, b| side(a).total_cmp(&side(b))).unwrap_or(0);
        let middle = points.len() / 2;
        points.select_nth_unstable_by(middle, |a, b| a[longest].total_cmp(&b[longest]));
        let (lower, upper) = points.split_at_mut(middle);
        let (lower, upper) = parallel::join(|| Self::around(lower), || Self::around(upper));
        Self { low, high, count, inside: Inside::Halves(Box::new([lower, upper])) }
    }

    /// A vector whose length is a lower bound of the distance from a point.
    fn away(&self, point: &[f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| (self.low[k] - point[k]).max(point[k] - self.high[k]).max(0.0))
    }

    /// A vector whose length is an upper bound of the distance from a point to those inside.
    fn across(&self, point: &[f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| (self.high[k] - point[k]).abs().max((point[k] - self.low[k]).abs()))
    }

    /// The number of points at most `reach` away. Boxes that are wholly inside count without their points.
    fn count(&self, point: &[f64; 3], reach: &Reach) -> u64 {
        if reach.is_below(self.away(point)) {
            return 0;
        }
        if reach.is_above(self.across(point)) {
            return self.count;
        }
        match &self.inside {
            Inside::Points(others) => reach.count(point, others),
            Inside::Halves(halves) => halves.iter().map(|half| half.count(point, reach)).sum(),
        }
    }

    /// Whether one of the points is at most `reach` away.
    fn has(&self, point: &[f64; 3], reach: f64) -> bool {
        match &self.inside {
            Inside::Points(others) => {
                others.iter().any(|other| length([0, 1, 2].map(|k| point[k] - other[k])) <= reach)
            }
            Inside::Halves(halves) => {
                let [a, b] = halves.each_ref().map(|half| length(half.away(point)));
                let order = if b < a { [1, 0] } else { [0, 1] };
                order.into_iter().any(|k| [a, b][k] <= reach * SPARE && halves[k].has(point, reach))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_what_all_pairs_give() {
        // A fixed sequence of points with coordinates in eighths, so that many distances are exact.
        let mut state = 7_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) % 160) as f64 / 8.0 - 10.0
        };
        let points: Vec<[f64; 3]> = (0..600).map(|_| [next(), next(), next()]).collect();
        let chosen: Vec<bool> = (0..600).map(|n| n % 7 == 0).collect();
        for reach in [0.0, 0.125, 1.0, 2.5, 100.0] {
            let expected: Vec<bool> = points
                .iter()
                .map(|a| {
                    points.iter().zip(&chosen).any(|(b, chosen)| {
                        let square: f64 = (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum();
                        *chosen && square <= reach * reach
                    })
                })
                .collect();
            assert_eq!(near(&points, &chosen, reach).expect("room"), expected, "{reach}");
        }
        // Of 200,000 points all pairs would take minutes.
        let many: Vec<[f64; 3]> = (0..200_000).map(|n| [f64::from(n / 2), 1e15, 0.0]).collect();
        let even: Vec<bool> = (0..200_000).map(|n| n % 4 == 0).collect();
        for reach in [0.0, 1e-300] {
            let found = near(&many, &even, reach).expect("room");
            assert!(found.iter().enumerate().all(|(n, flag)| *flag == (n / 2 % 2 == 0)));
        }
        // So would all pairs of many points at one place, which are all just too far away.
        let one: Vec<[f64; 3]> = (0..200_000).map(|n| if n % 2 == 0 { [0.0; 3] } else { [2.0, 2.0, 1.0] }).collect();
        let at_0: Vec<bool> = (0..200_000).map(|n| n % 2 == 0).collect();
        assert_eq!(near(&one, &at_0, 2.999).expect("room"), at_0);
        assert!(near(&one, &at_0, 3.0).expect("room").iter().all(|near| *near));
        let far = [[1e300, 0.0, 0.0], [-1e300, 0.0, 0.0], [1e300, 1.0, 0.0]];
        assert_eq!(near(&far, &[true, false, false], 2.0).expect("room"), [true, false, true]);
    }

    /// Boxes that are opened for a point.
    fn opened(all: &Boxed, point: &[f64; 3], reach: &Reach) -> u64 {
        if reach.is_below(all.away(point)) || reach.is_above(all.across(point)) {
            return 0;
        }
        let Inside::Halves(halves) = &all.inside else { return 1 };
        1 + halves.iter().map(|half| opened(half, point, reach)).sum::<u64>()
    }

    /// The numbers equal a count of all pairs for reaches below, near and above the extent, and the largest and the smallest. Whole boxes
    /// inside count without their points.
    #[test]
    fn the_tree_counts_what_all_pairs_give() {
        let mut state = 5_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) % 160) as f64 / 8.0 - 10.0
        };
        let points: Vec<[f64; 3]> = (0..500).map(|_| [next(), next(), next()]).collect();
        for scale in [1.0, 2f64.powi(-500), 2f64.powi(400)] {
            let points: Vec<_> = points.iter().map(|point| point.map(|x| x * scale)).collect();
            for reach in [0.125, 1.0, 2.5, 12.5, 25.0, 30.0, 100.0].map(|reach| reach * scale) {
                let near = |a: &[f64; 3], b: &[f64; 3]| length([0, 1, 2].map(|k| a[k] - b[k])) <= reach;
                let expected: Vec<u64> =
                    points.iter().map(|a| points.iter().filter(|b| near(a, b)).count() as u64 - 1).collect();
                assert_eq!(counts(&points, &[[0.0; 3]], reach).expect("room"), expected, "{reach}");
            }
        }
        let all: Vec<[f64; 3]> = (0..1 << 15).map(|_| [next(), next(), next()]).collect();
        let tree = Boxed::around(&mut all.clone());
        // All pairs would be twice the number of leaves. A ball cuts as many boxes as its surface.
        for reach in [5.0, 15.0, 25.0] {
            let most = all.iter().step_by(997).map(|point| opened(&tree, point, &Reach::new(reach))).max();
            assert!(most < Some(1500), "{reach}: {most:?} of {} boxes", 2 << 11);
        }
        // Nothing of 4,000 points at two places is opened, wherever the reach is.
        let two: Vec<[f64; 3]> = (0..4_000).map(|n| [f64::from(n % 2), 0.0, 0.0]).collect();
        for (reach, expected) in [(1e-200, 1_999), (0.5, 1_999), (1.5, 3_999), (1e200, 3_999)] {
            let found = counts(&two, &[[0.0; 3]], reach).expect("room");
            assert!(found.iter().all(|count| *count == expected), "{reach}: {}", found[0]);
        }
    }
}
