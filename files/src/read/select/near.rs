//! Particles near others, by a grid of cells whose side is the distance.

use halfline::error::Result;
use halfline::memory::check;
use rayon::prelude::*;
use std::collections::HashMap;

/// The cell of a point, from 0 in each direction.
type Cube = [i64; 3];

/// Bytes per point in a map of cells while it grows.
const POINT: u64 = 96;

/// Whether each of `points` is at most `reach` away from one of those that are `chosen`. Distances between centres, not
/// periodic; a chosen point is near itself.
///
/// # Errors
/// [`Error::Limits`](halfline::error::Error::Limits) where memory is short.
pub(super) fn near(points: &[[f64; 3]], chosen: &[bool], reach: f64) -> Result<Vec<bool>> {
    let count = chosen.par_iter().filter(|chosen| **chosen).count() as u64;
    check(POINT.saturating_mul(count), || format!("the distances to {count} selected particles"))?;
    // The numbers of cells stay below 2^48, so that rounding moves each by less than 2^-5 of a side; points within
    // `reach` are then at most 1/1.1 + 2 * 2^-5 < 1 side apart, in the same cell or in adjacent ones.
    let largest = points.par_iter().flatten().map(|x| x.abs()).reduce(|| 0.0, f64::max);
    let side = (1.1 * reach).max(largest * 2_f64.powi(-48)).max(f64::MIN_POSITIVE);
    let cell = |point: &[f64; 3]| point.map(|x| (x / side).floor() as i64);
    let mut cells: HashMap<Cube, Vec<[f64; 3]>> = HashMap::new();
    for point in points.iter().zip(chosen).filter(|(_, chosen)| **chosen).map(|(point, _)| point) {
        cells.entry(cell(point)).or_default().push(*point);
    }
    let close = |a: &[f64; 3], b: &[f64; 3]| {
        let away = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        away[0].hypot(away[1]).hypot(away[2]) <= reach
    };
    let found = |point: &[f64; 3]| {
        let [x, y, z] = cell(point);
        let beside = |at: i64| [at.saturating_sub(1), at, at.saturating_add(1)];
        let mut around = beside(x)
            .into_iter()
            .flat_map(|x| beside(y).into_iter().flat_map(move |y| beside(z).into_iter().map(move |z| [x, y, z])));
        around.any(|place| cells.get(&place).is_some_and(|members| members.iter().any(|other| close(point, other))))
    };
    Ok(points.par_iter().map(found).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_finds_what_all_pairs_give() {
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
        // With a tiny distance the points, each twice, take a cell each: of 200,000 all pairs would take minutes.
        let many: Vec<[f64; 3]> = (0..200_000).map(|n| [f64::from(n / 2), 1e15, 0.0]).collect();
        let even: Vec<bool> = (0..200_000).map(|n| n % 4 == 0).collect();
        for reach in [0.0, 1e-300] {
            let found = near(&many, &even, reach).expect("room");
            assert!(found.iter().enumerate().all(|(n, flag)| *flag == (n / 2 % 2 == 0)));
        }
        let far = [[1e300, 0.0, 0.0], [-1e300, 0.0, 0.0], [1e300, 1.0, 0.0]];
        assert_eq!(near(&far, &[true, false, false], 2.0).expect("room"), [true, false, true]);
    }
}
