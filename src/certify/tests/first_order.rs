//! Compares each bound with the largest error of all roundings together, exactly to first order: the sum of
//! |d out / d e_i| over every operation and every rounded number of a record (`tape`). Orders of sums are random, shots
//! are random or mutated towards larger errors. A share above 1 is a false bound.
//!
//! Sampled roundings come near such a sum only by chance. That 11 units for c/q do not suffice in one of the orders
//! that WGSL allows was found here in seconds, and by no sampling.
//!
//! The checks are divided like the bounds. *Discriminant*: the roundings of D, and of D plus and minus its error, stay
//! within that error. *Depth* and *normal*: D is taken as exact anywhere within its error, p.d likewise, and all
//! further roundings stay within the subtracted margin. INFLATE covers second orders and the bounds' own roundings, and
//! `host` tests the host's errors: both are removed from every bound here.

use super::shots::{Regime, Shot, Staged};
use super::tape::{Given, Program, Traced, rewind};
use crate::certify::constants::{DEPTH, FAR, INFLATE, UNIT, VANISH};
use crate::certify::general::{self, General};
use crate::certify::projected::{self, Projected};
use crate::certify::{Certify, ProjectionRecord, Slopes, TERMS, Terms};
use crate::number::{Arithmetic, Number};
use crate::testing::Rng;
use crate::view::ray::{cross3, minus, negated, times};
use rayon::prelude::*;

/// The quantity that is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Check {
    /// The discriminant of a winner; with its error added; with its error subtracted.
    Disc,
    DiscMost,
    DiscLeast,
    /// A lower bound of depth, an upper one, and the reported depth with its interval.
    Low,
    High,
    Shown,
    /// The normal, as a vector.
    Normal,
    /// The discriminant of a candidate; with its error added; its lower bound of depth.
    CandidateDisc,
    CandidateMost,
    CandidateLow,
    /// p.d; with its error added; with its error subtracted; the components of p x d.
    Along,
    AlongMost,
    AlongLeast,
    Cross,
}

use Check::{
    Along, AlongLeast, AlongMost, CandidateDisc, CandidateLow, CandidateMost, Cross, Disc, DiscLeast, DiscMost, High,
    Low, Normal, Shown,
};

const OF_FRONT: [Check; 10] =
    [Disc, DiscMost, DiscLeast, Low, High, Shown, Normal, CandidateDisc, CandidateMost, CandidateLow];
const OF_NEAR: [Check; 11] = [Along, AlongMost, AlongLeast, Cross, Disc, DiscMost, DiscLeast, Low, High, Shown, Normal];

/// The largest share that counts as within a bound. The roundings of the bound itself, which INFLATE covers, are
/// included in a share.
pub(super) const WHOLE: f64 = 1.0 + 1.0 / 4096.0;
/// The error of one rounding of the host: half an ulp.
const ONCE: f64 = 0.5;
/// The factor of the host's own bounds.
const HOST_INFLATE: f64 = 1.0 + 1.0 / 512.0;
/// The relative error of evaluating a bound: fewer than 100 units, which `INFLATE` covers.
const OWN: f64 = 1.0 / (1u64 << 16) as f64;
/// A third of the 3e-5 radians between the normal's bound and its promise, for the errors that the bound omits. The
/// other thirds are for the length of the vector and for its rotation into the world.
const ROTATED: f64 = 1e-5;
/// The share of DEPTH that the host's error can reach: 5 2^-53 |c - e|_1, with |c - e| at most 64 depths, of 2^-43.
const HOST_DEPTH: f64 = 556.0 / 1024.0;

/// One shot, in one order of its sums.
struct OrderedShot<'a> {
    staged: &'a Staged,
    terms: &'a Terms,
    /// `None`: the order of the source.
    order: Option<u64>,
}

impl OrderedShot<'_> {
    /// The largest error of this combination of numbers by all roundings.
    fn worst(&self, given: &Given, of: &[(Traced, f64)]) -> f64 {
        self.worst_of(given, [of])
    }

    /// The same for a vector.
    fn worst_of<const N: usize>(&self, given: &Given, of: [&[(Traced, f64)]; N]) -> f64 {
        let mut program = Program::new(given, self.order.map(Rng));
        let of = of.map(|of| of.iter().map(|(number, by)| (program.compute(*number), *by)).collect::<Vec<_>>());
        f64::from(UNIT) * program.worst(of.each_ref().map(Vec::as_slice))
    }

    /// The share of a bound that a check finds; NaN if the check does not apply.
    fn share(&self, check: Check) -> f64 {
        rewind();
        let Staged { view, binned, pixel: [i, j], .. } = self.staged;
        let twin = Certify {
            view: &view.record,
            projection: &binned.projection,
            lists: &binned.lists,
            generals: vec![],
            general_lists: &binned.general_lists,
            terms: self.terms,
            planes: None,
        };
        let s = twin.slopes(*i, *j);
        let mut given = Given::default();
        binned.projection.slope.into_iter().for_each(|slope| given.set_known(slope, ONCE));
        if self.staged.is_near() {
            return if OF_NEAR.contains(&check) { self.near(check, given, &s) } else { f64::NAN };
        }
        let there = binned.lists.details.first().is_some_and(|more| more.id == 0);
        if !there || !OF_FRONT.contains(&check) {
            return f64::NAN;
        }
        let (record, more) = (&binned.lists.projected[0], &binned.lists.details[0]);
        let f = Projected {
            x: record.x,
            y: record.y,
            rho: Traced::input(record.rho),
            low: Traced::from_f32(record.low),
            subpixel_offset: more.subpixel_offset.map(Traced::from_f32),
            center: Traced::input(more.center),
            id: more.id,
        };
        given.set(f.rho, ONCE);
        given.set(f.center, ONCE);
        match check {
            CandidateDisc | CandidateMost | CandidateLow => self.candidate(check, given, &s, &binned.projection, &f),
            _ => self.winner(check, given, &s, &binned.projection, &f),
        }
    }

    /// A winner of section 2 of docs/certificate.md.
    fn winner(
        &self,
        check: Check,
        mut given: Given,
        s: &Slopes<Traced>,
        lens: &ProjectionRecord,
        f: &Projected<Traced>,
    ) -> f64 {
        lens.step.into_iter().for_each(|step| given.set_known(step, ONCE));
        let w = projected::projected_weigh(s, lens, f, self.terms);
        let (a, inflate, e) = (s.a.real(), f64::from(INFLATE), f64::from(lens.edge));
        let [dx, dy] = w.o.map(Traced::real);
        let (disc, o, slant) = (w.disc.real(), dx.hypot(dy), w.slant2.real().sqrt());
        // The offset's own error is not a rounding, so its part of the bound is subtracted.
        let room = OWN * w.error.real() + (w.error.real() - a * f64::from(VANISH)) / inflate - a * e * (2.0 * o + e);
        let (most, least) = (w.disc + w.error, w.disc - w.error);
        match check {
            Disc => return self.worst(&given, &[(w.disc, 1.0)]) / room,
            DiscMost => return self.error_without_last(&given, most) / room,
            DiscLeast => return self.error_without_last(&given, least) / room,
            _ => {}
        }
        let answer = projected::projected_answer(s, lens, f, self.terms);
        if !answer.hits {
            return f64::NAN;
        }
        given.fix(&[w.disc, w.error], &[most, least]);
        let along = s.x.real() * dx + s.y.real() * dy;
        let center = f.center.real();
        let length = (center * f64::from(lens.unit) + f64::from(lens.size)) / a;
        let at = |disc: f64| center - (along + disc.max(0.0).sqrt()) * length;
        let host = HOST_DEPTH * f64::from(DEPTH) * (f64::from(lens.depth) + center);
        let spare = |taken: f64| (taken - host) / inflate - slant * e * length;
        let (nearest, farthest) = (at(most.real()), at(least.real()));
        match check {
            Low => self.worst(&given, &[(answer.low, 1.0)]) / spare(nearest - answer.low.real()),
            High => self.worst(&given, &[(answer.high, 1.0)]) / spare(answer.high.real() - farthest),
            Shown => {
                let shown = at(disc);
                let widest = (farthest - shown).max(shown - nearest);
                // The kernel writes the offset; the centre is added in f64.
                let off = |sign: f64| self.worst(&given, &[(answer.offset, sign), (answer.depth_interval, -1.0)]);
                (widest + off(1.0).max(off(-1.0))) / spare(answer.depth_interval.real() / inflate)
            }
            _ => {
                let k = (s.x * w.o[0] + s.y * w.o[1] + w.disc.sqrt()) * s.inverse;
                let [x, y, z] = [w.o[0] - k * s.x, w.o[1] - k * s.y, k].map(|n| [(n, 1.0)]);
                let [whole, each, of_along, of_root, _] = self.terms.depth.map(f64::from);
                let steep = (s.x.real() * dx).abs() + (s.y.real() * dy).abs();
                let root = most.real().max(0.0).sqrt();
                let total = along.abs() + root;
                let mixed = (whole + each * slant * slant) * total + of_along * steep + of_root * root;
                let bound = f64::from(UNIT) * (mixed / a.sqrt() + 4.0 * (total + o));
                self.worst_of(&given, [&x, &y, &z]) / (bound + ROTATED * f.rho.real())
            }
        }
    }

    /// The error of a sum of a number and its error bound, less the unit of the sum that the root's constant covers.
    fn error_without_last(&self, given: &Given, sum: Traced) -> f64 {
        self.worst(given, &[(sum, 1.0)]) - f64::from(UNIT) * sum.real().abs()
    }

    /// A candidate of section 2.
    fn candidate(
        &self,
        check: Check,
        mut given: Given,
        s: &Slopes<Traced>,
        lens: &ProjectionRecord,
        f: &Projected<Traced>,
    ) -> f64 {
        let c = Traced::from_f32;
        lens.fixed.into_iter().for_each(|step| given.set_known(step, ONCE));
        let right = Traced::from_i32((s.column << lens.shift) - f.x) * c(lens.fixed[0]);
        let up = Traced::from_i32(f.y - (s.row << lens.shift)) * c(lens.fixed[1]);
        let disc = projected::projected_discriminant(s, f.rho, [right, up]);
        let error = c(lens.errors[0]) + f.rho * (c(lens.errors[1]) + f.rho * c(lens.errors[2]));
        let most = disc + error;
        let (a, rho) = (s.a.real(), f.rho.real());
        let (o, e) = (right.real().hypot(up.real()), f64::from(lens.fixed[0]).hypot(f64::from(lens.fixed[1])));
        let record = &self.staged.view.record;
        let edge = |slope: f32, n: u32| f64::from(slope) * f64::from(n);
        let widest = 1.0 + edge(lens.slope[0], record.width).powi(2) + edge(lens.slope[1], record.height).powi(2);
        // Farther out, the margin of a miss is much larger than its rounding.
        if o > (2.0 * widest).sqrt() * rho + 16.0 * widest * e {
            return f64::NAN;
        }
        let room = OWN * error.real() + error.real() / HOST_INFLATE - a * e * (2.0 * o + e);
        match check {
            CandidateDisc => return self.worst(&given, &[(disc, 1.0)]) / room,
            CandidateMost => return self.error_without_last(&given, most) / room,
            _ if disc.real() < -error.real() => return f64::NAN,
            _ => {}
        }
        let low = projected::projected_low(s, lens, f);
        given.fix(&[disc, error], &[most]);
        let center = f.center.real();
        let along = s.x.real() * right.real() + s.y.real() * up.real();
        let length = (center * f64::from(lens.unit) + f64::from(lens.size)) / a;
        let real = center - (along + most.real().max(0.0).sqrt()) * length;
        // The record's lower bound is computed from the centre in f64.
        let host = self.staged.depth_error() + ONCE * f64::from(UNIT) * center.abs();
        let spare = (real - low.real() - host) / HOST_INFLATE - (a - 1.0).sqrt() * e * length;
        self.worst(&given, &[(low, 1.0)]) / spare
    }

    /// A general sphere of section 3.
    fn near(&self, check: Check, mut given: Given, s: &Slopes<Traced>) -> f64 {
        let record = &self.staged.binned.generals[0];
        let n = General {
            center_radius: record.center_radius.map(Traced::input),
            power: Traced::input(record.power),
            scale: Traced::from_f32(record.scale),
            form: record.form,
            id: record.id,
            pixel: record.pixel,
            start: Traced::input(record.start),
            by: record.by.map(Traced::input),
            blur: Traced::from_f32(record.blur),
            rank: 0,
        };
        let rounded = n.center_radius.into_iter().chain(n.by).chain([n.start, n.power]);
        rounded.for_each(|number| given.set(number, ONCE));
        let w = general::general_weigh(s, &n, self.terms);
        let (a, power, inflate) = (s.a.real(), n.power.real(), f64::from(INFLATE));
        let room = (w.error.real() - a * f64::from(VANISH)) / inflate;
        let (most, least) = (w.disc + w.error, w.disc - w.error);
        match check {
            Along => return self.worst(&given, &[(w.b, 1.0)]) / (w.b_error.real() / inflate),
            AlongMost => return self.error_without_last(&given, w.b + w.b_error) / (w.b_error.real() / inflate),
            AlongLeast => return self.error_without_last(&given, w.b - w.b_error) / (w.b_error.real() / inflate),
            Cross => {
                let parts = w.g.map(|g| self.worst(&given, &[(g, 1.0)]));
                return parts.iter().sum::<f64>() / w.g_error.real();
            }
            Disc => return self.worst(&given, &[(w.disc, 1.0)]) / room,
            DiscMost => return self.error_without_last(&given, most) / room,
            DiscLeast => return self.error_without_last(&given, least) / room,
            _ => {}
        }
        let below = general::general_below(s, &n, &w, self.terms);
        if power == 0.0 || below.real() >= f64::from(FAR) {
            return f64::NAN;
        }
        let (b, b_error) = (w.b.real(), w.b_error.real());
        given.fix(&[w.disc, w.error], &[most, least]);
        let taken_apart = self.near_depth(check, &given, &n, s, &w, [b, b]);
        given.fix(&[w.b, w.b_error], &[]);
        taken_apart.max(self.near_depth(check, &given, &n, s, &w, [b - b_error, b + b_error]))
    }

    /// Depth and normal of section 3. p.d lies anywhere within `ends` and D within its error.
    fn near_depth(
        &self,
        check: Check,
        given: &Given,
        n: &General<Traced>,
        s: &Slopes<Traced>,
        w: &general::Weighed<Traced>,
        ends: [f64; 2],
    ) -> f64 {
        let below = general::general_below(s, n, w, self.terms);
        let answer = general::general_answer(s, n, self.terms);
        let (a, power, inflate, scale) = (s.a.real(), n.power.real(), f64::from(INFLATE), n.scale.real());
        let (most, least) = (w.disc + w.error, w.disc - w.error);
        // The depth is a function of the true p.d and of the power: D = (p.d)^2 - a c.
        let depth = |b: f64| {
            let root = (b * b - a * power).max(0.0).sqrt();
            match power > 0.0 || b < 0.0 {
                true => power.abs() / (b.abs() + root),
                false => (b + root) / a,
            }
        };
        let (nearest, farthest) = match power > 0.0 {
            true => {
                let of = |disc: Traced| (disc.real().max(0.0) + a * power).sqrt();
                let (large, small) = (ends[1].min(of(most)), ends[0].max(of(least)));
                // No sphere has such numbers: the ray certainly misses, although the kernel does not prove it.
                if large < (a * power).sqrt() || large < small {
                    return f64::NAN;
                }
                (depth(large), depth(small))
            }
            false => (depth(ends[0]), depth(ends[1])),
        };
        match check {
            Low => self.worst(given, &[(below, 1.0)]) / (nearest - below.real()),
            _ if !answer.hits => f64::NAN,
            High => self.worst(given, &[(answer.high, 1.0)]) / (answer.high.real() - farthest * scale),
            Shown => {
                let shown = answer.offset.real();
                let widest = (shown - nearest * scale).max(farthest * scale - shown);
                let off = |sign: f64| self.worst(given, &[(answer.offset, sign), (answer.depth_interval, -1.0)]);
                (widest + off(1.0).max(off(-1.0))) / (answer.depth_interval.real() / inflate)
            }
            _ => {
                // The bound contains the error of g, so only the roundings after g are counted.
                let mut given = given.clone();
                given.fix(&w.g, &[]);
                let across = cross3([s.x, s.y, -Traced::ONE], w.g);
                let side = if power > 0.0 { negated(across) } else { across };
                let [x, y, z] = minus(side, times(w.disc.sqrt(), [s.x, s.y, -Traced::ONE])).map(|n| [(n, 1.0)]);
                self.worst_of(&given, [&x, &y, &z]) / (ROTATED * a * n.center_radius[3].real())
            }
        }
    }
}

/// A shot in one order of its sums, and the check that it is for.
#[derive(Debug, Clone)]
pub(super) struct Aim {
    check: Check,
    shot: Shot,
    /// `None`: the order of the source.
    order: Option<u64>,
}

impl Aim {
    /// The share of its bound that all roundings together reach.
    pub(super) fn share(&self, terms: &Terms) -> f64 {
        let Some(staged) = self.shot.staged(terms) else { return f64::NAN };
        OrderedShot { staged: &staged, terms, order: self.order }.share(self.check)
    }

    /// Words of a line of a file.
    pub(super) fn to_words(&self) -> String {
        let order = self.order.map_or("source".to_owned(), |order| format!("{order:x}"));
        format!("{:?} {order} {}", self.check, self.shot.to_word())
    }

    /// The aim of such words.
    pub(super) fn of_words(words: &str) -> Option<Self> {
        let [check, order, shot] = words.split(' ').collect::<Vec<_>>()[..] else { return None };
        let check = OF_FRONT.into_iter().chain(OF_NEAR).find(|known| format!("{known:?}") == check)?;
        let order = if order == "source" { None } else { Some(u64::from_str_radix(order, 16).ok()?) };
        Some(Self { check, shot: Shot::of_word(shot)?, order })
    }
}

/// The largest share of a bound in a regime: over orders of random shots, then of mutations of the worst one.
fn worst(check: Check, regime: Regime, terms: &Terms, shots: u32) -> (f64, Option<Aim>) {
    let mut rng = Rng(0x5eed_0061 ^ (check as u64) << 8 ^ (regime as u64) << 16);
    let mut best: (f64, Option<Aim>) = (f64::NEG_INFINITY, None);
    let look = |shot: Shot, rng: &mut Rng, best: &mut (f64, Option<Aim>)| {
        let Some(staged) = shot.staged(terms) else { return };
        let orders = [None; 1].into_iter().chain((0..6).map(|_| Some(rng.bits())));
        for order in orders {
            let share = OrderedShot { staged: &staged, terms, order }.share(check);
            if share > best.0 {
                *best = (share, Some(Aim { check, shot: shot.clone(), order }));
            }
        }
    };
    for _ in 0..shots {
        look(regime.shot(&mut rng), &mut rng, &mut best);
    }
    for _ in 0..shots {
        let Some(aim) = &best.1 else { return (f64::NAN, None) };
        look(aim.shot.mutated(&mut rng), &mut rng, &mut best);
    }
    best
}

/// The number of shots of each check in each regime; HALFLINE_SHOTS is a factor.
fn shots() -> u32 {
    let times = std::env::var("HALFLINE_SHOTS").map_or(1, |times| times.parse().expect("a number"));
    120 * times
}

fn table(checks: &[Check], regimes: &[Regime]) {
    let pairs: Vec<_> = checks.iter().flat_map(|check| regimes.iter().map(move |regime| (*check, *regime))).collect();
    let shares: Vec<(f64, Option<Aim>)> =
        pairs.par_iter().map(|(check, regime)| worst(*check, *regime, &TERMS, shots())).collect();
    let mut faulty = Vec::new();
    for (row, check) in shares.chunks(regimes.len()).zip(checks) {
        let cells = row.iter().zip(regimes).filter(|((share, _), _)| share.is_finite());
        let cells: Vec<String> = cells.map(|((share, _), regime)| format!("{regime:?} {share:.3}")).collect();
        println!("{:13} {}", format!("{check:?}"), cells.join(", "));
        assert!(!cells.is_empty(), "{check:?} never applied");
        let above = row.iter().zip(regimes).filter(|((share, _), _)| *share > WHOLE);
        faulty.extend(above.map(|((share, shot), regime)| format!("{check:?} {regime:?} {share:.3}: {shot:?}")));
    }
    assert!(faulty.is_empty(), "false bounds:\n{}", faulty.join("\n"));
}

#[test]
fn no_roundings_together_leave_a_front_bound() {
    table(&OF_FRONT, &Regime::FRONT);
}

#[test]
fn no_roundings_together_leave_a_near_bound() {
    table(&OF_NEAR, &Regime::GENERAL);
}

/// The largest share of some checks in some regimes, with `times` as many shots as usual, and where it is.
pub(super) fn largest(aims: &[(Check, Regime)], terms: &Terms, times: u32) -> (f64, Option<Aim>) {
    let of = |(check, regime): &(Check, Regime)| worst(*check, *regime, terms, times * shots());
    aims.par_iter().map(of).reduce(|| (0.0, None), |a, b| if b.0 > a.0 { b } else { a })
}

/// Negative control, and a former error of the derivation: from inside, the error of the quotient c/q exceeds 11 units
/// if p.d is nearly zero and its terms are added one by one to the root.
#[test]
fn eleven_units_are_too_few_for_a_quotient() {
    let mut terms = TERMS;
    terms.root[0] = 11.0;
    let (share, _) =
        largest(&[Regime::EyePlane, Regime::Ahead, Regime::Inside, Regime::Center].map(|r| (Low, r)), &terms, 8);
    println!("eleven units for c/q: {share:.3}");
    assert!(share > WHOLE, "{share}");
}
