//! Compares the host's records with the numbers that it rounds, at every scale of f64 including the subnormal numbers.
//! The exact values are double-double, scaled by a power of two before any product, along axes that are computed
//! independently.

use super::axes::axes;
use crate::certify::TERMS;
use crate::certify::constants::HOST;
use crate::certify::general::GeneralRecord;
use crate::certify::projection::ProjectionBounds;
use crate::certify::projection::stage::Staged;
use crate::double_double::{self as dd, Dd, Dd3};
use crate::exact;
use crate::scene::camera::{Camera, Lens as Lenses, Look};
use crate::scene::{ImagePlane, Scene, Spheres};
use crate::testing::Rng;
use crate::view::View;
use glam::DVec3;

/// Half an ulp of f32, as the host rounds.
const HALF: f64 = 1.0 / (1u64 << 24) as f64;

/// One sphere in front of a camera, at any scale of f64.
struct Sight {
    scene: Scene,
    /// The exponent of the larger of |c - e| and r.
    k: i32,
    /// Right, up and back from the eye, times 2^-k; and the radius.
    p: Dd3,
    r: f64,
}

fn vector(rng: &mut Rng) -> DVec3 {
    DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0))
}

impl Sight {
    /// In a unit of 2^`scale`; `None` if rounding to it leaves no sphere.
    fn new(rng: &mut Rng, scale: i32, parallel: bool) -> Option<Self> {
        let size = |x: DVec3| DVec3::from_array(x.to_array().map(|x| dd::ldexp(x, scale)));
        // The eye from far outside to near the centre.
        let eye = size(vector(rng) * rng.decade(-20.0, 6.0));
        let view = vector(rng);
        let up = view + vector(rng) * rng.decade(-13.0, 0.0);
        let look = if rng.below(2) == 0 { Look::View(view) } else { Look::At(eye + size(view)) };
        let half = rng.decade(-9.0, 0.3);
        let lens = match parallel {
            true => Lenses::Orthographic { height: dd::ldexp(rng.decade(-3.0, 1.0), scale) },
            false => Lenses::Viewport { vw: 2.0 * half, vh: 2.0 * half, distance: 1.0 },
        };
        let camera = Camera { eye, look, up, lens };
        let basis = camera.basis().ok()?;
        let extent = if parallel { 1.0 } else { half };
        let ahead = basis.u * rng.between(-extent, extent) + basis.v * rng.between(-extent, extent) - basis.w;
        // In front of the eye, or in any direction from it.
        let way = if rng.below(3) > 0 { ahead } else { vector(rng) };
        let center = (eye + size(way)).to_array();
        let radius = dd::ldexp(rng.decade(-4.0, 0.4), scale);
        if !(radius > 0.0 && radius.is_finite() && center.iter().all(|x| x.is_finite())) {
            return None;
        }
        let mut spheres = Spheres::default();
        spheres.push(center, radius, None);
        let image = ImagePlane { width: 1 + rng.below(3000), height: 1 + rng.below(3000), background: [0.0; 3] };
        let scene = Scene { camera, image, spheres, lighting: Default::default() };
        scene.check().ok()?;
        let away: Dd3 = std::array::from_fn(|n| Dd::diff(center[n], eye[n]));
        let k = dd::exponent(away.iter().fold(radius, |most, x| most.max(x.hi.abs())));
        let away = away.map(|x| x.ldexp(-k));
        let p = axes(&camera).map(|axis| dd::dot(axis, away));
        Some(Self { scene, k, p, r: dd::ldexp(radius, -k) })
    }

    fn lens(&self) -> Option<(View, ProjectionBounds)> {
        let view = View::new(&self.scene).ok()?;
        let ImagePlane { width, height, .. } = self.scene.image;
        let lens = ProjectionBounds::new(&self.scene.camera, &view, [width, height], &TERMS).expect("axes");
        lens.is_bounded().then_some((view, lens))
    }

    /// Slopes of a column and a row, in double-double.
    fn slopes(&self, column: f64, row: f64) -> [Dd; 2] {
        let ImagePlane { width, height, .. } = self.scene.image;
        let viewport = self.scene.camera.viewport(width, height).expect("a viewport");
        let part = |odd: f64, side: f64, n: u32| Dd::product(odd, side) / Dd::product(2.0 * f64::from(n), viewport.d);
        let (w, h) = (f64::from(width), f64::from(height));
        [part(2.0 * column + 1.0 - w, viewport.vw, width), part(h - 1.0 - 2.0 * row, viewport.vh, height)]
    }

    /// The largest ratio of error to bound in the record of a general sphere.
    fn near(&self, record: &GeneralRecord, rng: &mut Rng) -> f64 {
        let host = f64::from(HOST);
        let off = |stored: f32, real: Dd| (Dd::from(f64::from(stored)) - real).value().abs();
        let parts =
            self.p.iter().zip(record.center_radius).map(|(p, stored)| off(stored, *p) / (HALF * p.hi.abs() + host));
        let mut worst = parts.fold(0.0, f64::max);
        // Unknown powers are 0.
        let center = self.scene.spheres.centers[0];
        let power = exact::power(center, self.scene.camera.eye.to_array(), self.scene.spheres.radii[0], -self.k);
        if record.power != 0.0 {
            assert_eq!(record.power.is_sign_positive(), power.hi > 0.0, "the sign of the power");
            worst = worst.max(off(record.power, power) / (power.hi.abs() * (HALF + 2f64.powi(-40))));
        } else {
            assert!(power.hi == 0.0 || record.blur > 1e9, "a power of {:e} is lost", power.hi);
        }
        let ImagePlane { width, height, .. } = self.scene.image;
        let [column, row] = [rng.below(width), rng.below(height)].map(f64::from);
        let [x, y] = self.slopes(column, row);
        let [pixel, by] = [record.pixel.map(f64::from), record.by.map(f64::from)];
        let steps = [f64::from(record.start), (column - pixel[0]) * by[0], (row - pixel[1]) * by[1]];
        let b = Dd::sum(steps[0], steps[1]) + steps[2].into();
        let real = self.p[0] * x + self.p[1] * y - self.p[2];
        let length = x.hi.abs() + y.hi.abs() + 1.0;
        let bound = HALF * steps.iter().map(|x| x.abs()).sum::<f64>() + f64::from(record.blur) + 2.0 * host * length;
        worst.max((b - real).value().abs() / bound)
    }

    /// The same for a projected sphere: its position, radius and depth.
    fn front(&self, view: &View, lens: &ProjectionBounds, reference: f64, staged: &Staged) -> f64 {
        let Staged::Projected(landed) = staged else { return 0.0 };
        let (front, more) = (&landed.placed.record, &landed.placed.detail);
        let record = lens.record(reference as f32, 1e-5, 0);
        let [px, py, pz] = self.p;
        let ahead = -pz;
        let parallel = self.scene.camera.lens.is_orthographic();
        let ImagePlane { width, height, .. } = self.scene.image;
        let viewport = self.scene.camera.viewport(width, height).expect("a viewport");
        let sides = [(viewport.vw, width, px), (viewport.vh, height, -py)];
        let fixed = dd::ldexp(1.0, record.shift as i32);
        let mut worst = 0.0f64;
        let ends = [(front.x, more.subpixel_offset[0], 1.0), (front.y, more.subpixel_offset[1], -1.0)];
        for ((side, n, p), (place, rest, sign)) in sides.into_iter().zip(ends) {
            let n = f64::from(n);
            // Pixels from the left or the top: the projected centre over a pixel, and half of the others.
            let of_pixel = if parallel {
                p / (Dd::from(dd::ldexp(side, -self.k)) / n.into())
            } else {
                p / ahead / (Dd::from(side) / viewport.d.into() / n.into())
            };
            let real = of_pixel + Dd::from(0.5 * (n - 1.0));
            let coarse = (Dd::from(f64::from(place) / fixed) - real).value().abs();
            worst = worst.max(coarse * fixed);
            let pixel = (place + (1 << (record.shift - 1))) >> record.shift;
            let fine = (Dd::from(f64::from(pixel)) + Dd::from(sign * f64::from(rest)) - real).value().abs();
            worst = worst.max(fine / (2.75 * 2f64.powi(-26)));
        }
        let unit = f64::from(if parallel { record.size } else { record.unit });
        let length = if parallel { Dd::from(dd::ldexp(unit, view.unit - self.k)) } else { ahead * unit.into() };
        let rho = Dd::from(self.r) / length;
        worst = worst.max((Dd::from(f64::from(front.rho)) - rho).value().abs() / (rho.hi * (HALF + 2f64.powi(-42))));
        // Parallel rays: a sphere that may cross the plane of the eye has no depth.
        if more.center > -1e37 {
            let depth = ahead.ldexp(self.k - view.unit);
            let shown = Dd::sum(f64::from(more.center), reference);
            let bound = HALF * f64::from(more.center).abs() + f64::from(crate::certify::constants::DEPTH) * depth.hi;
            worst = worst.max((shown - depth).value().abs() / bound);
        }
        worst
    }
}

#[test]
fn records_are_within_what_the_host_may_leave() {
    let mut rng = Rng(0x5eed_0051);
    let mut worst = [0.0f64; 2];
    let mut staged_as = [0u32; 2];
    for n in 0..40_000 {
        // From the smallest subnormal numbers up to where squares overflow.
        let scale = [-1072, -1068, -1060, -1040, -1000, -500, -3, 0, 5, 511, 700, 950][n % 12];
        let parallel = rng.below(3) == 0;
        let Some(sight) = Sight::new(&mut rng, scale, parallel) else { continue };
        let Some((view, lens)) = sight.lens() else { continue };
        let (center, radius) = (sight.scene.spheres.centers[0], sight.scene.spheres.radii[0]);
        if !parallel {
            let record = lens.general(0, center, radius);
            let share = sight.near(&record, &mut rng);
            assert!(share <= 1.0, "near, {share}: {:?}", sight.scene);
            worst[0] = worst[0].max(share);
            staged_as[0] += 1;
        }
        let depth = -sight.p[2].ldexp(sight.k - view.unit).hi;
        let reference = if rng.below(2) == 0 { 0.0 } else { f64::from((depth * 0.99) as f32).max(0.0) };
        let staged = lens.stage(0, center, radius, reference);
        let share = sight.front(&view, &lens, reference, &staged);
        assert!(share <= 1.0, "front, {share}: {:?}", sight.scene);
        worst[1] = worst[1].max(share);
        staged_as[1] += u32::from(matches!(staged, Staged::Projected(_)));
    }
    println!("of its bound a near record is off by {:.3}, a front one by {:.3}; {staged_as:?}", worst[0], worst[1]);
    assert!(staged_as.iter().all(|n| *n > 5000), "{staged_as:?}");
    assert!(worst.iter().all(|share| *share > 0.5), "the bounds are not trivial: {worst:?}");
}
