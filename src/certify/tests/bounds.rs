//! Compares each bound with the quantity that it bounds. Shots and roundings are evolved together to bring the error as
//! near to its bound as possible; a ratio above 1 is a false bound.

use super::shots::{Regime, Shot, Staged};
use super::wild::{Mode, Value, Wild, climb, under};
use crate::certify::general::{self, General};
use crate::certify::projected::{self, Projected};
use crate::certify::{Certify, TERMS, Terms};
use crate::double_double::Dd;
use crate::testing::{Rng, amount};
use rayon::prelude::*;

/// Mutations without an improvement after which a lineage ends.
const PATIENCE: usize = 400;

/// The quantity of a bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Quantity {
    /// The discriminant of a winner.
    FrontDisc,
    /// The depth of a winner, between low and high.
    FrontDepth,
    /// A candidate's lower bound of depth: the used share of its margin. A hit must not become a miss.
    FrontLow,
    /// p.d of a general sphere.
    NearAlong,
    /// p x d of a general sphere.
    NearCross,
    /// The discriminant of a general sphere in either form.
    NearDisc,
    /// The depth of a general sphere, between low and high.
    NearDepth,
}

impl Staged {
    /// Error over bound; NaN if the quantity does not exist.
    fn ratio<R: Value>(&self, quantity: Quantity, terms: &Terms) -> f64 {
        use Quantity::*;
        let binned = &self.binned;
        let near = matches!(quantity, NearAlong | NearCross | NearDisc | NearDepth);
        let there = binned.lists.details.first().is_some_and(|more| more.id == 0);
        if near != self.is_near() || !near && !there {
            return f64::NAN;
        }
        let twin = Certify::<R> {
            view: &self.view.record,
            projection: &binned.projection,
            lists: &binned.lists,
            generals: Vec::new(),
            general_lists: &binned.general_lists,
            terms,
            planes: None,
        };
        let s = twin.slopes(self.pixel[0], self.pixel[1]);
        let over = |error: f64, bound: R| error.abs() / bound.value();
        let between = |low: R, high: R| {
            let (low, high) = (low.value(), high.value());
            self.depth.map_or(f64::NAN, |z| (z - low + (z - high)).abs() / (high - low))
        };
        let less = |disc: R| (Dd::from(disc.value()) - self.disc).value();
        if near {
            let n = General::new(&binned.generals[0]);
            let w = general::general_weigh(&s, &n, terms);
            return match quantity {
                NearAlong => over(w.b.value() - self.b, w.b_error),
                NearCross => over((0..3).map(|k| (w.g[k].value() - self.g[k]).abs()).sum(), w.g_error),
                NearDisc => over(less(w.disc), w.error),
                _ => {
                    let answer = general::general_answer(&s, &n, terms);
                    if answer.hits { between(answer.low, answer.high) } else { f64::NAN }
                }
            };
        }
        let f = Projected::new(&binned.lists.projected[0], &binned.lists.details[0]);
        match quantity {
            FrontDisc => {
                let w = projected::projected_weigh(&s, &binned.projection, &f, terms);
                over(less(w.disc), w.error)
            }
            FrontDepth => {
                let answer = projected::projected_answer(&s, &binned.projection, &f, terms);
                if answer.hits { between(answer.low, answer.high) } else { f64::NAN }
            }
            _ => {
                let Some(z) = self.depth else { return f64::NAN };
                let low = projected::projected_low(&s, &binned.projection, &f).value();
                let taken = f64::from(binned.lists.details[0].center) - f64::from(binned.lists.projected[0].low);
                if low < f64::from(f32::MAX) { 1.0 + (low - z) / taken } else { f64::INFINITY }
            }
        }
    }
}

/// The largest ratio that evolution finds in this many lineages; it stops at `enough`.
pub(super) fn worst(quantity: Quantity, regime: Regime, terms: &Terms, lineages: usize, enough: f64) -> f64 {
    let mut rng = Rng(0x5eed ^ (quantity as u64) << 8 ^ (regime as u64) << 16);
    let mut found = f64::NEG_INFINITY;
    for _ in 0..lineages {
        found = found.max(evolved(quantity, regime, terms, &mut rng, enough));
        if found > enough {
            break;
        }
    }
    found
}

/// The best ratio of one lineage, which starts from the best of some shots and ends when it no longer improves.
fn evolved(quantity: Quantity, regime: Regime, terms: &Terms, rng: &mut Rng, enough: f64) -> f64 {
    // The roundings are optimised only for a shot that is better with the roundings of its parent.
    let climbed = |shot: &Shot, chosen: &mut Vec<bool>, least: f64| match shot.staged(terms) {
        Some(staged) => {
            let probe = || staged.ratio::<Wild>(quantity, terms);
            let first = climb(chosen, 0, probe);
            if first > least { climb(chosen, 1, probe) } else { first }
        }
        None => f64::NAN,
    };
    let mut best = (f64::NEG_INFINITY, regime.shot(rng), vec![]);
    for _ in 0..10 {
        let (shot, mut chosen) = (regime.shot(rng), vec![]);
        chosen.resize_with(200, || rng.bits() & 1 == 0);
        let ratio = climbed(&shot, &mut chosen, f64::NEG_INFINITY);
        if ratio > best.0 {
            best = (ratio, shot, chosen);
        }
    }
    let mut patience = PATIENCE;
    while patience > 0 && best.0 <= enough && best.0 > f64::NEG_INFINITY {
        let (shot, mut chosen) = (best.1.mutated(rng), best.2.clone());
        let ratio = climbed(&shot, &mut chosen, best.0);
        patience -= 1;
        if ratio > best.0 {
            best = (ratio, shot, chosen);
            patience = PATIENCE;
        }
    }
    best.0
}

/// The largest ratios of random shots in plain f32 and in the modes that choose roundings blindly.
fn ordinary(quantity: Quantity, regime: Regime) -> [f64; 2] {
    let mut rng = Rng(99);
    let mut found = [f64::NEG_INFINITY; 2];
    for n in 0..400 {
        let Some(staged) = regime.shot(&mut rng).staged(&TERMS) else { continue };
        found[0] = found[0].max(staged.ratio::<f32>(quantity, &TERMS));
        for mode in Mode::BLIND {
            found[1] = found[1].max(under(mode, n, || staged.ratio::<Wild>(quantity, &TERMS)));
        }
    }
    found
}

fn table(quantities: &[Quantity], regimes: &[Regime]) {
    let lineages = amount("lineages of shots for a quantity and regime", [1, 1, 4]);
    let pairs: Vec<_> = quantities.iter().flat_map(|quantity| regimes.iter().map(move |r| (*quantity, *r))).collect();
    let found: Vec<_> = pairs
        .par_iter()
        .map(|&(quantity, regime)| {
            let [plain, blind] = ordinary(quantity, regime);
            [plain, blind, worst(quantity, regime, &TERMS, lineages, f64::INFINITY).max(plain).max(blind)]
        })
        .collect();
    for (&(quantity, regime), [plain, blind, worst]) in pairs.iter().zip(&found) {
        println!("{quantity:10?} {regime:10?} f32 {plain:6.3} blind {blind:6.3} evolved {worst:6.3}");
        assert!(*worst <= 1.0, "a false bound: {quantity:?} {regime:?} {worst}");
    }
    for (row, quantity) in found.chunks(regimes.len()).zip(quantities) {
        // A missed sphere has no depth.
        assert!(row.iter().any(|[.., worst]| worst.is_finite()), "{quantity:?} never occurred");
    }
}

#[test]
fn no_front_quantity_leaves_its_bound() {
    use Quantity::{FrontDepth, FrontDisc, FrontLow};
    table(&[FrontDisc, FrontDepth, FrontLow], &Regime::FRONT);
}

#[test]
fn no_near_quantity_leaves_its_bound() {
    use Quantity::{NearAlong, NearCross, NearDepth, NearDisc};
    table(&[NearAlong, NearCross, NearDisc, NearDepth], &Regime::GENERAL);
}
