//! Particles near others and their number, by a tree of boxes.

use halfline::error::Result;
use halfline::memory::check;
use rayon::prelude::*;

/// Bytes per point in the tree.
const POINT: u64 = 64;

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

/// Whether each of `points` is at most `reach` away from one of those that are `chosen`. Distances between centres, not
/// periodic; a chosen point is near itself.
///
/// # Errors
/// [`Error::Limits`](halfline::error::Error::Limits) where memory is short.
pub(super) fn near(points: &[[f64; 3]], chosen: &[bool], reach: f64) -> Result<Vec<bool>> {
    let count = chosen.par_iter().filter(|chosen| **chosen).count() as u64;
    check(POINT.saturating_mul(count), || format!("the distances to {count} selected particles"))?;
    let mut others: Vec<[f64; 3]> =
        points.iter().zip(chosen).filter(|(_, chosen)| **chosen).map(|(point, _)| *point).collect();
    let all = Boxed::around(&mut others);
    let found = |(point, is_chosen): (&[f64; 3], &bool)| *is_chosen || all.has(point, reach);
    Ok(points.par_iter().zip(chosen).map(found).collect())
}

/// The number of other points at most `reach` away from each, in their images at `shifts` too, of which 0 is one. A point counts each of
/// its own images.
///
/// # Errors
/// [`Error::Limits`](halfline::error::Error::Limits) where memory is short.
pub(super) fn counts(points: &[[f64; 3]], shifts: &[[f64; 3]], reach: f64) -> Result<Vec<u64>> {
    check(POINT.saturating_mul(points.len() as u64), || format!("the neighbours of {} particles", points.len()))?;
    let all = Boxed::around(&mut points.to_vec());
    let moved = |point: &[f64; 3], shift: &[f64; 3]| [0, 1, 2].map(|k| point[k] + shift[k]);
    // The point itself is among those around it.
    let of = |point: &[f64; 3]| shifts.iter().map(|shift| all.count(&moved(point, shift), reach)).sum::<u64>() - 1;
    Ok(points.par_iter().map(of).collect())
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
        let (lower, upper) = rayon::join(|| Self::around(lower), || Self::around(upper));
        Self { low, high, count, inside: Inside::Halves(Box::new([lower, upper])) }
    }

    /// A lower bound of the distance from a point.
    fn away(&self, point: &[f64; 3]) -> f64 {
        length([0, 1, 2].map(|k| (self.low[k] - point[k]).max(point[k] - self.high[k]).max(0.0)))
    }

    /// An upper bound of the distance from a point to those inside.
    fn across(&self, point: &[f64; 3]) -> f64 {
        length([0, 1, 2].map(|k| (self.high[k] - point[k]).abs().max((point[k] - self.low[k]).abs())))
    }

    /// The number of points at most `reach` away.
    fn count(&self, point: &[f64; 3], reach: f64) -> u64 {
        if self.away(point) > reach * SPARE {
            return 0;
        }
        match &self.inside {
            Inside::Points(others) => {
                others.iter().filter(|other| length([0, 1, 2].map(|k| point[k] - other[k])) <= reach).count() as u64
            }
            Inside::Halves(_) if self.across(point) * SPARE <= reach => self.count,
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
                let [a, b] = halves.each_ref().map(|half| half.away(point));
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
        // So would those of many points at one place, which are all just too far away.
        let one: Vec<[f64; 3]> = (0..200_000).map(|n| if n % 2 == 0 { [0.0; 3] } else { [2.0, 2.0, 1.0] }).collect();
        let at_0: Vec<bool> = (0..200_000).map(|n| n % 2 == 0).collect();
        assert_eq!(near(&one, &at_0, 2.999).expect("room"), at_0);
        assert!(near(&one, &at_0, 3.0).expect("room").iter().all(|near| *near));
        let far = [[1e300, 0.0, 0.0], [-1e300, 0.0, 0.0], [1e300, 1.0, 0.0]];
        assert_eq!(near(&far, &[true, false, false], 2.0).expect("room"), [true, false, true]);
    }
}
