//! Waves of a circle's angle, of degree 2 at most, and where they change their sign.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// The corners of a polygon in the circle of radius 1.
const SIDES: usize = 16;
static UNIT: LazyLock<[[f64; 2]; SIDES]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let (sin, cos) = (k as f64 * TAU / SIDES as f64).sin_cos();
        [cos, sin]
    })
});

/// mean + first (cos, sin) a + second (cos, sin) 2 a.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wave {
    pub(super) mean: f64,
    pub(super) first: [f64; 2],
    pub(super) second: [f64; 2],
}

impl Wave {
    /// The product of two waves of degree 1: mean, cosine and sine of each.
    pub(super) fn product(a: [f64; 3], b: [f64; 3]) -> Self {
        Self {
            mean: a[0] * b[0] + 0.5 * (a[1] * b[1] + a[2] * b[2]),
            first: [a[0] * b[1] + a[1] * b[0], a[0] * b[2] + a[2] * b[0]],
            second: [0.5 * (a[1] * b[1] - a[2] * b[2]), 0.5 * (a[1] * b[2] + a[2] * b[1])],
        }
    }

    /// Itself and a multiple of another.
    pub(super) fn plus(&self, factor: f64, other: &Self) -> Self {
        let two = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|k| a[k] + factor * b[k]);
        Self {
            mean: self.mean + factor * other.mean,
            first: two(self.first, other.first),
            second: two(self.second, other.second),
        }
    }

    fn at(&self, angle: f64) -> f64 {
        let ((s, c), (s2, c2)) = (angle.sin_cos(), (2.0 * angle).sin_cos());
        self.mean + self.first[0] * c + self.first[1] * s + self.second[0] * c2 + self.second[1] * s2
    }

    fn slope(&self, angle: f64) -> f64 {
        let ((s, c), (s2, c2)) = (angle.sin_cos(), (2.0 * angle).sin_cos());
        self.first[1] * c - self.first[0] * s + 2.0 * (self.second[1] * c2 - self.second[0] * s2)
    }

    /// The same, counted from another angle.
    fn turned(&self, by: f64) -> Self {
        let turn = |[a, b]: [f64; 2], by: f64| {
            let (s, c) = by.sin_cos();
            [a * c + b * s, b * c - a * s]
        };
        Self { mean: self.mean, first: turn(self.first, by), second: turn(self.second, 2.0 * by) }
    }

    /// The angles at which it changes its sign, from 0 to a turn. The half angle's tangent is a root of a quartic, counted from the angle
    /// opposite of the one where the wave is farthest from 0 of sixteen.
    pub(super) fn zeros(&self) -> Vec<f64> {
        let [first, second] = [self.first, self.second].map(|[a, b]| a.hypot(b));
        if self.mean.abs() > first + second {
            return Vec::new();
        }
        let value = |k: usize| {
            let ([c, s], [c2, s2]) = (UNIT[k], UNIT[2 * k % SIDES]);
            self.mean + self.first[0] * c + self.first[1] * s + self.second[0] * c2 + self.second[1] * s2
        };
        let mut far = (0.0, 0);
        for k in 0..SIDES {
            let value = value(k).abs();
            if value > far.0 {
                far = (value, k);
            }
        }
        let start = far.1 as f64 * TAU / SIDES as f64 - PI;
        let Self { mean, first: [a1, b1], second: [a2, b2] } = self.turned(start);
        let quartic = [mean + a1 + a2, 2.0 * b1 + 4.0 * b2, 2.0 * mean - 6.0 * a2, 2.0 * b1 - 4.0 * b2, mean - a1 + a2];
        let polished = |t: f64| {
            let mut angle = start + 2.0 * t.atan();
            for _ in 0..2 {
                let step = self.at(angle) / self.slope(angle);
                if step.abs() < 1e-3 {
                    angle -= step;
                }
            }
            angle.rem_euclid(TAU)
        };
        sign_changes(&quartic).into_iter().map(polished).collect()
    }
}

/// The real roots of a polynomial at which its sign changes, lowest coefficient first: between the roots of its derivative.
fn sign_changes(of: &[f64]) -> Vec<f64> {
    let Some((last, lower)) = of.split_last() else { return Vec::new() };
    let largest = lower.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if of.len() < 2 || *last == 0.0 && largest == 0.0 {
        return Vec::new();
    }
    if *last == 0.0 {
        return sign_changes(lower);
    }
    let slope: Vec<f64> = (1..).zip(&of[1..]).map(|(n, x)| f64::from(n) * x).collect();
    let reach = 1.0 + largest / last.abs();
    let ends = [-reach].into_iter().chain(sign_changes(&slope)).chain([reach]).collect::<Vec<_>>();
    let value = |t: f64| of.iter().rev().fold(0.0, |sum, x| sum * t + x);
    let mut roots = Vec::new();
    for two in ends.windows(2) {
        let [mut low, mut high] = [two[0], two[1]];
        let sign = value(low) < 0.0;
        if sign == (value(high) < 0.0) {
            continue;
        }
        // Newton's steps, or halves of the bracket where they lead out of it.
        let mut t = 0.5 * (low + high);
        for _ in 0..128 {
            let (mut at, mut rise) = (0.0, 0.0);
            for x in of.iter().rev() {
                (at, rise) = (at * t + x, rise * t + at);
            }
            if (at < 0.0) == sign {
                low = t
            } else {
                high = t
            }
            let newton = t - at / rise;
            let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
            if next == t || !(next >= low && next <= high) {
                break;
            }
            t = next;
        }
        roots.push(t);
    }
    roots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sign_changes_are_found() {
        // (t - 1)(t + 2)(t - 3)(t - 3.5)
        let of = [-21.0, 23.5, 2.0, -5.5, 1.0];
        let value = |t: f64| of.iter().rev().fold(0.0, |sum, x| sum * t + x);
        for root in [1.0, -2.0, 3.0, 3.5] {
            assert!(value(root).abs() < 1e-12, "{root}");
        }
        let found = sign_changes(&of);
        assert_eq!(found.len(), 4);
        assert!(found.iter().zip([-2.0, 1.0, 3.0, 3.5]).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        assert!(sign_changes(&[1.0, 0.0, 1.0]).is_empty() && sign_changes(&[2.0, 4.0, 0.0]) == [-0.5]);
    }
}
