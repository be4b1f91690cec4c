//! The claims of the certified kernel about a pixel, compared with exact arithmetic.

use super::wild::Value;
use crate::certify::binned::{BinnedScene, Binning};
use crate::certify::general::{General, general_low};
use crate::certify::{Certify, Terms};
use crate::double_double::{self as dd, Dd, Dd3};
use crate::exact::{Judge, Truth};
use crate::scene::Scene;
use crate::tile::TILE;
use crate::view::View;
use crate::view::ray::NONE;
use halfline_ground::memory::Pool;

/// The conditions of `certain`; each can be switched off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Checks {
    pub(super) hit: bool,
    pub(super) normal: bool,
    pub(super) order: bool,
    pub(super) sharp: bool,
}

impl Checks {
    pub(super) const ALL: Self = Self { hit: true, normal: true, order: true, sharp: true };
}

/// A binned scene with the exact answers at some pixels.
pub(super) struct Case {
    pub(super) scene: Scene,
    pub(super) view: View,
    pub(super) binned: BinnedScene,
    pub(super) tolerance: f64,
    pub(super) judged: Vec<Judged>,
}

/// The exact answer at a pixel: the nearest hit, and the hit of every single sphere.
pub(super) struct Judged {
    pub(super) at: [u32; 2],
    nearest: Option<Truth>,
    pub(super) each: Vec<Option<Truth>>,
}

impl Case {
    /// `None` if the scene cannot be binned, so that every pixel is settled.
    pub(super) fn new(scene: Scene, tolerance: f64, pixels: &[[u32; 2]], terms: &Terms) -> Option<Self> {
        let view = View::new(&scene).expect("a view");
        let binned = BinnedScene::new(&Binning {
            terms,
            level: coarse(&scene),
            ..Binning::of(&scene, &view, tolerance, &Pool::default())
        })
        .expect("a stage")?;
        let judge = Judge::new(&scene).expect("a judge");
        let judged = |&[i, j]: &[u32; 2]| Judged {
            at: [i, j],
            nearest: judge.pixel(i, j),
            each: (0..scene.spheres.len() as u32).map(|id| judge.among(i, j, &[id])).collect(),
        };
        let judged = pixels.iter().map(judged).collect();
        Some(Self { scene, view, binned, tolerance, judged })
    }

    /// The scene binned with other constants.
    pub(super) fn restaged(&self, terms: &Terms) -> BinnedScene {
        let binned = BinnedScene::new(&Binning {
            terms,
            level: coarse(&self.scene),
            ..Binning::of(&self.scene, &self.view, self.tolerance, &Pool::default())
        });
        binned.expect("a stage").expect("a lens")
    }

    /// Calls `f` with the twin in the arithmetic R.
    pub(super) fn with<R: Value, T>(
        &self,
        binned: &BinnedScene,
        terms: &Terms,
        f: impl FnOnce(&Certify<'_, R>) -> T,
    ) -> T {
        let generals: Vec<_> = binned.generals.iter().map(General::new).collect();
        let BinnedScene { projection, lists, general_lists, planes, .. } = binned;
        let (view, planes) = (&self.view.record, planes.as_ref());
        f(&Certify { view, projection, lists, generals, general_lists, terms, planes })
    }

    /// Depth in the frame's unit, relative to the reference depth.
    pub(super) fn depth(&self, truth: &Truth) -> f64 {
        dd::ldexp(truth.depth, -self.view.unit) - f64::from(self.binned.projection.depth)
    }

    /// The possible error of the judge's rounding, in the frame's unit: one or two ulps of f64, also of subnormal
    /// numbers, and flushed subnormals of f32.
    pub(super) fn spare(&self, truth: &Truth) -> f64 {
        let steps = f64::EPSILON * truth.depth + f64::from_bits(4);
        dd::ldexp(steps, -self.view.unit) + f64::from(f32::MIN_POSITIVE)
    }
}

/// The level of the lists at which the image consists of a few squares: their edges are tested, and many scenes fit
/// into memory.
pub(super) fn coarse(scene: &Scene) -> u32 {
    (scene.image.width.max(scene.image.height) / TILE).max(4).ilog2() - 2
}

/// Returns whether the pixel is certain, or the claim that is false.
pub(super) fn check<R: Value>(
    case: &Case,
    twin: &Certify<'_, R>,
    judged: &Judged,
    checks: Checks,
) -> Result<bool, String> {
    let [i, j] = judged.at;
    let s = twin.slopes(i, j);
    let mut lows = vec![None; case.scene.spheres.len()];
    let listed: Vec<_> = twin.candidates(&s).map(|(low, slot)| (low, twin.id(slot))).collect();
    // The bounds hold for all general spheres, also where a tile does not list them.
    let generals = twin.generals.iter().map(|general| (general_low(&s, general, twin.terms), general.id));
    for (low, id) in generals.filter(|(low, _)| *low < R::MISS).chain(listed.iter().copied()) {
        if let Some(place) = lows.get_mut(id as usize) {
            *place = Some(low.value());
        }
    }
    if let Some(truth) = judged.nearest.filter(|truth| listed.iter().all(|(_, id)| *id != truth.id)) {
        return Err(format!("pixel {i} {j}: sphere {} is the nearest hit and not listed", truth.id));
    }
    // (a) A hit is found, and its lower bound is not above its depth.
    for (id, (truth, low)) in judged.each.iter().zip(&lows).enumerate() {
        let Some(truth) = truth else { continue };
        let depth = case.depth(truth);
        let spare = case.spare(truth);
        match low {
            None => return Err(format!("pixel {i} {j}: sphere {id} is hit at {depth:e} and counted as missed")),
            Some(low) if *low > depth + spare => {
                return Err(format!("pixel {i} {j}: sphere {id} is hit at {depth:e}, not below {low:e}"));
            }
            Some(_) => {}
        }
    }
    let kept = twin.nearest_two(&s);
    if kept.slot == NONE {
        return Ok(true);
    }
    let answer = twin.certify_winner(&s, &kept);
    let truth = judged.each.get(answer.id as usize).copied().flatten();
    let (low, high) = (answer.low.value(), answer.high.value());
    // (c) A certain hit is a hit.
    if checks.hit && answer.hits {
        let Some(truth) = truth else {
            return Err(format!("pixel {i} {j}: sphere {} is missed and counted as hit", answer.id));
        };
        let depth = case.depth(&truth);
        let spare = case.spare(&truth);
        if high < depth - spare {
            return Err(format!("pixel {i} {j}: sphere {} is hit at {depth:e}, not above {high:e}", answer.id));
        }
    }
    let lens = twin.projection;
    let certain = if checks == Checks::ALL {
        twin.certain(&answer, [kept.low, kept.second])
    } else {
        let sharp = answer.depth_interval < R::from_f32(lens.tolerance) * (R::from_f32(lens.depth) + answer.low);
        let hit = if checks.normal { answer.sure } else { answer.hits };
        // Without the condition on hits the one on normals is left out too, so that a wrong hit shows as a wrong
        // answer.
        let hit = hit || !checks.hit;
        hit && (!checks.order || answer.high < kept.second) && (!checks.sharp || sharp)
    };
    if !certain {
        return Ok(false);
    }
    // (b) A certain answer has the exact id, and distance and normal within their bounds.
    let Some(truth) = judged.nearest.filter(|truth| truth.id == answer.id) else {
        return Err(format!("pixel {i} {j}: certain of {}, truth {:?}", answer.id, judged.nearest.map(|t| t.id)));
    };
    let depth = case.depth(&truth);
    let center = dd::ldexp(twin.center_depth(kept.slot), case.view.unit);
    let z = (center - truth.depth) + dd::ldexp(answer.offset.value(), case.view.unit);
    let error = dd::ldexp(z.abs(), -case.view.unit);
    let spare = case.spare(&truth);
    if error > answer.depth_interval.value() + spare || error > case.tolerance * (depth + f64::from(lens.depth)) + spare
    {
        return Err(format!("pixel {i} {j}: depth {depth:e} off by {error:e} of {low:e} .. {high:e}"));
    }
    let basis = case.view.basis;
    let [x, y, z] = answer.normal.map(Value::value);
    let normal = basis.u * x + basis.v * y + basis.w * z;
    // |n - n*| is 2 sin(angle / 2), and n itself is rounded.
    let turn = (normal - glam::DVec3::from_array(truth.normal)).length();
    // The judge's normal is rounded to f64.
    let claimed = answer.turn.value();
    if turn > 1e-3 || claimed > 0.0 && turn > claimed + 4.0 * f64::EPSILON {
        return Err(format!("pixel {i} {j}: normal off by {turn:e} rad, claimed {claimed:e}"));
    }
    Ok(true)
}

/// The ray of a pixel and a sphere, in double-double: x, y, |d|^2; the centre (right, up, ahead) from the ray's origin,
/// and the radius.
pub(super) struct Exact {
    pub(super) x: Dd,
    pub(super) y: Dd,
    pub(super) a: Dd,
    pub(super) p: Dd3,
    pub(super) r: Dd,
}

impl Exact {
    pub(super) fn new(scene: &Scene, [i, j]: [u32; 2], id: usize) -> Self {
        Self::of(scene, [i, j], scene.spheres.centers[id], scene.spheres.radii[id])
    }

    pub(super) fn of(scene: &Scene, [i, j]: [u32; 2], center: [f64; 3], radius: f64) -> Self {
        let (width, height) = (f64::from(scene.image.width), f64::from(scene.image.height));
        let lens = scene.camera.viewport(scene.image.width, scene.image.height).expect("a viewport");
        let parallel = lens.is_parallel();
        let d = if parallel { 1.0 } else { lens.d };
        let slope = |odd: f64, v: f64, n: f64| Dd::product(odd, v) / Dd::product(2.0 * n, d);
        let x = slope(2.0 * f64::from(j) + 1.0 - width, lens.vw, width);
        let y = slope(height - 1.0 - 2.0 * f64::from(i), lens.vh, height);
        let [right, up, back] = super::axes::axes(&scene.camera);
        let away: Dd3 = std::array::from_fn(|k| Dd::diff(center[k], scene.camera.eye[k]));
        let p = [dd::dot(right, away), dd::dot(up, away), -dd::dot(back, away)];
        if parallel {
            let zero = Dd::default();
            return Self { x: zero, y: zero, a: 1.0.into(), p: [p[0] - x, p[1] - y, p[2]], r: radius.into() };
        }
        Self { x, y, a: Dd::from(1.0) + x * x + y * y, p, r: radius.into() }
    }

    /// p.d
    pub(super) fn b(&self) -> Dd {
        self.p[0] * self.x + self.p[1] * self.y + self.p[2]
    }

    /// p x d with d = (x, y, -1), p = (right, up, -ahead).
    pub(super) fn g(&self) -> Dd3 {
        let [px, py, pz] = self.p;
        [pz * self.y - py, px - pz * self.x, px * self.y - py * self.x]
    }

    /// a r^2 - g.g
    pub(super) fn disc(&self) -> Dd {
        let g = self.g();
        self.a * self.r * self.r - dd::dot(g, g)
    }

    /// The distance of the ray's line from the centre.
    pub(super) fn passes(&self) -> f64 {
        let g = self.g();
        (dd::dot(g, g) / self.a).sqrt().value()
    }
}
