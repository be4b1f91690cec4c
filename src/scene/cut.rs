//! Planes that cut spheres: what lies beyond a plane is removed, and shows the inside of the spheres that it passes through.

use super::{Ball, DEFAULT_COLOR, List, Spheres};
use crate::double_double as dd;
use crate::dyadic::{self, Dyadic};
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::check;
use halfline_ground::parallel::{self, CHEAP};
use halfline_ground::quote::count;
use halfline_ground::quote::setting::CUT as CUT_SETTING;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// A plane N.p = D. What has N.p > D is removed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CutPlane {
    /// N, of any length but zero, toward what is removed.
    pub normal: [f64; 3],
    /// D, in the unit of the scene times the length of N.
    pub distance: f64,
}

/// The planes that cut spheres, and which spheres they cut.
#[derive(Debug, Clone, PartialEq)]
pub struct Cuts {
    /// The planes. A point is kept that all of them keep.
    pub planes: Vec<CutPlane>,
    /// [`CUT`] for a sphere that some plane cuts, [`REMOVED`] for one that lies wholly beyond a plane, [`SPARED`] for one that no plane may
    /// cut though it is not wholly kept; 0 for one that lies wholly on the kept side.
    pub of: List<u8>,
    /// Linear RGB of the faces of each sphere; `None` for the colours of the spheres.
    pub colors: Option<List<[f32; 3]>>,
}

/// The flag of a sphere that some plane cuts.
pub const CUT: u8 = 1;
/// The flag of a sphere that no plane may cut, and that lies on the removed side at least in part.
pub const SPARED: u8 = 2;
/// The flag of a sphere that lies wholly beyond a plane.
pub const REMOVED: u8 = 3;

/// A sphere as it stands among planes: whole, or what they keep of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Solid {
    pub(crate) ball: Ball,
    pub(crate) is_cut: bool,
}

/// The place of a ball beside planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Kept,
    Cut,
    Removed,
    Spared,
}

impl Side {
    fn flag(self) -> u8 {
        match self {
            Self::Kept => 0,
            Self::Cut => CUT,
            Self::Spared => SPARED,
            Self::Removed => REMOVED,
        }
    }
}

/// Bound of the rounding of N.c - D and of r |N| in f64, relative to the sum of the sizes of their terms: fewer than 8 roundings.
/// Section 9a of docs/certificate.md.
const ROUNDED: f64 = 8.0 * f64::EPSILON;

impl CutPlane {
    /// Checks the numbers of a plane.
    ///
    /// # Errors
    /// [`Error::Scene`] at `place` for a normal of length zero and for numbers that are not finite.
    pub fn check(&self, place: impl FnOnce() -> Place) -> Result<()> {
        let Self { normal, distance } = self;
        let is_finite = normal.iter().chain([distance]).all(|x| x.is_finite());
        if is_finite && *normal != [0.0; 3] {
            return Ok(());
        }
        let problem = format!("found the plane {normal:?}, {distance}");
        Err(Error::scene(place(), problem, "give a direction of any length but zero, and a distance, all finite"))
    }

    /// Whether another plane removes the same, exactly: one is a positive multiple of the other.
    fn is_same(&self, other: &Self) -> bool {
        let numbers =
            |plane: &Self| [plane.normal[0], plane.normal[1], plane.normal[2], plane.distance].map(Dyadic::of);
        let (a, b) = (numbers(self), numbers(other));
        let is_parallel = |i: usize, j: usize| (&(&a[i] * &b[j]) - &(&a[j] * &b[i])).is_zero();
        let along = dyadic::dot(&dyadic::vector(self.normal), &dyadic::vector(other.normal));
        along.sign() == Ordering::Greater && (0..4).all(|i| (0..i).all(|j| is_parallel(i, j)))
    }

    /// The exponent of the largest component of N.
    pub(crate) fn exponent(&self) -> i32 {
        dd::exponent(self.normal.iter().fold(0.0, |most, x| x.abs().max(most)))
    }

    /// The same plane with a normal whose largest component is in [1, 2), so that squares of it are in range: N has any length. D is
    /// rounded where f64 does not hold it.
    #[must_use]
    pub fn in_range(&self) -> Self {
        let k = self.exponent();
        Self { normal: self.normal.map(|x| dd::ldexp(x, -k)), distance: dd::ldexp(self.distance, -k) }
    }

    /// The exact place of a ball: removed where N.c - r |N| >= D, kept where N.c + r |N| <= D.
    fn side(&self, ball: Ball) -> Side {
        let Self { normal, distance } = self.in_range();
        let terms: [f64; 3] = std::array::from_fn(|n| normal[n] * ball.center[n]);
        let beyond = terms[0] + terms[1] + terms[2] - distance;
        let reach = ball.radius * normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        let doubt = ROUNDED * (terms.iter().map(|x| x.abs()).sum::<f64>() + distance.abs() + reach);
        // Sums beyond f64 and below its normal numbers are decided exactly.
        let is_sure = doubt < f64::MAX && doubt > f64::MIN_POSITIVE / f64::EPSILON;
        match beyond {
            _ if is_sure && beyond - reach > doubt => Side::Removed,
            _ if is_sure && beyond + reach < -doubt => Side::Kept,
            _ if is_sure && reach - beyond.abs() > doubt => Side::Cut,
            _ => self.exact_side(ball),
        }
    }

    fn exact_side(&self, ball: Ball) -> Side {
        let normal = dyadic::vector(self.normal);
        let beyond = &dyadic::dot(&normal, &dyadic::vector(ball.center)) - &Dyadic::of(self.distance);
        let reach2 = &Dyadic::of(ball.radius).square() * &dyadic::dot(&normal, &normal);
        match ((&beyond.square() - &reach2).sign(), beyond.sign()) {
            (Ordering::Less, _) => Side::Cut,
            (_, Ordering::Greater) => Side::Removed,
            _ => Side::Kept,
        }
    }
}

impl Cuts {
    /// Planes for spheres that are still to come; `None` without a plane.
    ///
    /// # Errors
    /// As [`CutPlane::check`].
    pub fn later(planes: Vec<CutPlane>) -> Result<Option<Self>> {
        check_planes(&planes)?;
        Ok((!planes.is_empty()).then_some(Self { planes, of: List::default(), colors: None }))
    }

    /// The cuts of the spheres with these indices.
    pub(crate) fn chosen(&self, indices: &[u32]) -> Self {
        let flag = |id: &u32| self.of[*id as usize];
        let color = |colors: &List<[f32; 3]>| indices.iter().map(|id| colors[*id as usize]).collect::<Vec<_>>().into();
        Self {
            planes: self.planes.clone(),
            of: indices.iter().map(flag).collect::<Vec<_>>().into(),
            colors: self.colors.as_ref().map(color),
        }
    }

    /// The planes, without spheres.
    pub(crate) fn bare(&self) -> Self {
        Self { planes: self.planes.clone(), of: List::default(), colors: None }
    }

    /// Whether some plane cuts a sphere.
    #[inline(always)]
    pub(crate) fn is_cut(&self, id: u32) -> bool {
        self.of.get(id as usize) == Some(&CUT)
    }

    /// Whether a sphere lies wholly beyond a plane.
    #[inline(always)]
    pub(crate) fn is_removed(&self, id: u32) -> bool {
        self.of.get(id as usize) == Some(&REMOVED)
    }

    /// The number of spheres with a flag.
    #[must_use]
    pub fn count(&self, flag: u8) -> u64 {
        parallel::count(self.of.len(), |n| self.of[n] == flag) as u64
    }

    /// A warning where planes remove all spheres.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        removes_all(self.count(REMOVED), self.of.len() as u64)
    }

    /// Whether a sphere is whole beyond planes.
    #[inline(always)]
    pub(crate) fn is_spared(&self, id: u32) -> bool {
        self.of.get(id as usize) == Some(&SPARED)
    }
}

fn check_planes(planes: &[CutPlane]) -> Result<()> {
    planes.iter().enumerate().try_for_each(|(n, plane)| plane.check(|| Place::field(format!("cut {n}"))))
}

/// A warning where so many removed spheres are all.
pub(crate) fn removes_all(removed: u64, all: u64) -> Option<String> {
    (removed == all).then(|| format!("{CUT_SETTING} removes all {}", count(all, "sphere")))
}

impl Spheres {
    /// Cuts spheres by planes: those wholly beyond a plane are removed, those that a plane passes through are cut. All keep their ids. `may`
    /// has a flag for each sphere that may be cut or removed; `None` for all. Planes of before are replaced. Places and radii are final
    /// before: where they change later, spheres have to be cut again.
    ///
    /// # Errors
    /// As [`CutPlane::check`]; [`Error::Limits`] where memory is short.
    pub fn cut(&mut self, planes: &[CutPlane], may: Option<&[bool]>) -> Result<()> {
        let cuts = self.cuts_by(planes, may)?;
        self.cuts = Some(cuts).filter(|cuts| cuts.of.iter().any(|flag| [CUT, REMOVED].contains(flag)));
        Ok(())
    }

    /// The cuts of [`Self::cut`], also where no sphere is cut.
    pub(crate) fn cuts_by(&self, planes: &[CutPlane], may: Option<&[bool]>) -> Result<Cuts> {
        check_planes(planes)?;
        check(2 * self.len() as u64, || format!("the cuts of {} spheres", self.len()))?;
        // Equal planes meet each ray at one place, where nothing but exact arithmetic would tell them apart.
        let mut different: Vec<CutPlane> = Vec::with_capacity(planes.len());
        for plane in planes {
            if !different.iter().any(|other| other.is_same(plane)) {
                different.push(*plane);
            }
        }
        let planes = different;
        let side = |n: usize| {
            let sides = planes.iter().map(|plane| plane.side(self.ball(n as u32)));
            let side = sides.fold(Side::Kept, |all, side| match (all, side) {
                (Side::Removed, _) | (_, Side::Removed) => Side::Removed,
                (Side::Kept, side) => side,
                (all, _) => all,
            });
            let is_spared = side != Side::Kept && may.is_some_and(|may| !may[n]);
            if is_spared { Side::Spared } else { side }
        };
        let of: Vec<u8> =
            parallel::collect(self.len(), CHEAP, &|range, flags| flags.extend(range.map(|n| side(n).flag())));
        Ok(Cuts { planes, of: of.into(), colors: None })
    }

    /// Whether some plane cuts a sphere.
    #[must_use]
    pub fn is_cut(&self, id: u32) -> bool {
        self.cuts.as_ref().is_some_and(|cuts| cuts.is_cut(id))
    }

    /// Linear RGB of a sphere, or of its face on a plane.
    #[inline(always)]
    pub(crate) fn color(&self, id: u32, is_face: bool) -> [f32; 3] {
        let of_faces = || self.cuts.as_ref().and_then(|cuts| cuts.colors.as_deref());
        let colors = if is_face { of_faces().or(self.colors.as_deref()) } else { self.colors.as_deref() };
        colors.map_or(DEFAULT_COLOR, |colors| colors[id as usize])
    }

    /// The colours of all spheres, each followed by the colour of the sphere's face.
    pub(crate) fn colors_and_faces(&self) -> Vec<[f32; 3]> {
        let mut both = vec![[0.0; 3]; 2 * self.len()];
        parallel::each(&mut both, |n, to| *to = self.color(n as u32 / 2, n % 2 == 1));
        both
    }

    /// A sphere as planes leave it.
    pub(crate) fn solid(&self, id: u32) -> Solid {
        Solid { ball: self.ball(id), is_cut: self.is_cut(id) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spheres(balls: &[([f64; 3], f64)]) -> Spheres {
        let mut spheres = Spheres::default();
        balls.iter().for_each(|(center, radius)| spheres.push(*center, *radius, None));
        spheres
    }

    #[test]
    fn spheres_are_kept_cut_or_removed_exactly() {
        let unit = 1.0_f64;
        let up = |distance: f64| CutPlane { normal: [0.0, 0.0, 2.0], distance: 2.0 * distance };
        let ball = |z: f64, radius: f64| Ball { center: [3.0, -4.0, z], radius };
        // A ball that touches the plane is not cut.
        assert_eq!(up(1.0).side(ball(0.0, 1.0)), Side::Kept);
        assert_eq!(up(-1.0).side(ball(0.0, 1.0)), Side::Removed);
        assert_eq!(up(unit.next_down()).side(ball(0.0, 1.0)), Side::Cut);
        assert_eq!(up((-unit).next_up()).side(ball(0.0, 1.0)), Side::Cut);
        assert_eq!(up(unit.next_up()).side(ball(0.0, 1.0)), Side::Kept);
        // A normal whose length is irrational: (1, 1, 0), so the ball of radius sqrt 2 is not exactly tangent.
        let slant = CutPlane { normal: [1.0, 1.0, 0.0], distance: 2.0 };
        let radius = std::f64::consts::SQRT_2;
        assert!(radius * radius > 2.0, "the f64 is above the root");
        assert_eq!(slant.side(Ball { center: [0.0; 3], radius }), Side::Cut);
        assert_eq!(slant.side(Ball { center: [0.0; 3], radius: radius.next_down() }), Side::Kept);
        // 1e8 away, and beyond the range of f64.
        let far = CutPlane { normal: [3.0, 4.0, 0.0], distance: 7e8 };
        assert_eq!(far.side(Ball { center: [1e8, 1e8, 0.0], radius: 1e-9 }), Side::Cut);
        assert_eq!(far.side(Ball { center: [1e8 - 1.0, 1e8, 0.0], radius: 0.6 }), Side::Kept);
        let huge = CutPlane { normal: [1e300, 0.0, 0.0], distance: 0.0 };
        assert_eq!(huge.side(Ball { center: [1e300, 0.0, 0.0], radius: 1e300 }), Side::Removed);
        assert_eq!(huge.side(Ball { center: [-1e300, 0.0, 0.0], radius: 1e300 }), Side::Kept);
        let tiny = CutPlane { normal: [1e-300, 0.0, 0.0], distance: 0.0 };
        assert_eq!(tiny.side(Ball { center: [1e-20, 0.0, 0.0], radius: 2e-20 }), Side::Cut);
        for length in [1e-170, 5e-324, 1e308] {
            let short = CutPlane { normal: [length, 0.0, 0.0], distance: 0.0 };
            assert_eq!([1.0, -1.0].map(|x| short.side(Ball { center: [x, 0.0, 0.0], radius: 2.0 })), [Side::Cut; 2]);
            assert_eq!(short.side(Ball { center: [-3.0, 0.0, 0.0], radius: 2.0 }), Side::Kept);
        }
    }

    #[test]
    fn planes_remove_what_one_of_them_removes() {
        let mut all =
            spheres(&[([0.0; 3], 1.0), ([5.0, 0.0, 0.0], 1.0), ([0.0, 5.0, 0.0], 1.0), ([-5.0, 0.0, 0.0], 1.0)]);
        let planes =
            [CutPlane { normal: [1.0, 0.0, 0.0], distance: 0.5 }, CutPlane { normal: [0.0, 1.0, 0.0], distance: 4.5 }];
        let before = all.clone();
        all.cut(&planes, None).expect("planes");
        assert_eq!(all.cuts.as_ref().expect("cuts").of[..], [CUT, REMOVED, CUT, 0]);
        assert_eq!([CUT, REMOVED, SPARED].map(|flag| all.cuts.as_ref().expect("cuts").count(flag)), [2, 1, 0]);
        assert_eq!(all.cuts.as_ref().expect("cuts").planes, planes);
        // Spared ones are whole, wherever they are.
        let mut some = before.clone();
        some.cut(&planes, Some(&[false, false, true, true])).expect("planes");
        assert_eq!(some.cuts.as_ref().expect("cuts").of[..], [SPARED, SPARED, CUT, 0]);
        // Planes that remove the same count once; the opposite side is another.
        let twice = planes.map(|CutPlane { normal, distance }| CutPlane {
            normal: normal.map(|x| 3.0 * x),
            distance: 3.0 * distance,
        });
        let back = CutPlane { normal: [-1.0, 0.0, 0.0], distance: -0.5 };
        let mut same = before.clone();
        same.cut(&[planes, twice].concat(), None).expect("planes");
        assert_eq!(same, all);
        same.cut(&[&planes[..], &[back]].concat(), None).expect("planes");
        assert_eq!(same.cuts.as_ref().expect("cuts").planes.len(), 3);
        let mut none = before.clone();
        none.cut(&[CutPlane { normal: [0.0, 0.0, 1.0], distance: 7.0 }], None).expect("a plane");
        assert_eq!(none, before);
        for plane in [
            CutPlane { normal: [0.0; 3], distance: 1.0 },
            CutPlane { normal: [f64::NAN, 0.0, 1.0], distance: 1.0 },
            CutPlane { normal: [0.0, 0.0, 1.0], distance: f64::INFINITY },
        ] {
            let error = none.cut(&[planes[0], plane], None).expect_err("no plane").to_string();
            assert!(error.contains("cut 1") && error.contains("direction"), "{error}");
        }
    }
}
