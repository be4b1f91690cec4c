//! Shots: one sphere in front of one pixel, the same with the exact numbers of its record, and the distributions of shots
//! whose roundings are large.

use super::claims::Exact;
use super::worlds::Site;
use crate::certify::Terms;
use crate::certify::binned::{BinnedScene, Binning};
use crate::double_double::{self as dd, Dd};
use crate::scene::Scene;
use crate::scene::camera::{Camera, Lens, Look};
use crate::testing::Rng;
use crate::view::View;
use glam::DVec3;

/// One sphere in front of one pixel of a square image.
#[derive(Debug, Clone)]
pub(super) struct Shot {
    half: f64,
    width: u32,
    pixel: [u32; 2],
    /// Depth of the ray's point nearest to the centre.
    z: f64,
    r: f64,
    /// The distance of the ray from the centre, in radii.
    impact: f64,
    turn: f64,
    /// The camera's roll and tilt; 0 for the canonical camera, whose rotation is exact.
    oblique: f64,
    /// Whether rays are parallel; then `half` is in the scene's unit.
    parallel: bool,
    /// Depth of a second, small sphere relative to this one's, which decides the reference depth; 0 for none.
    second: f64,
}

/// A binned shot, with the exact numbers in the units of its record.
pub(super) struct Staged {
    pub(super) scene: Scene,
    pub(super) view: View,
    pub(super) binned: BinnedScene,
    pub(super) pixel: [u32; 2],
    pub(super) b: f64,
    pub(super) g: [f64; 3],
    pub(super) disc: Dd,
    /// Relative to the reference depth; `None` for a miss.
    pub(super) depth: Option<f64>,
}

impl Shot {
    pub(super) fn staged(&self, terms: &Terms) -> Option<Staged> {
        let tilt = DVec3::new(0.3 * self.oblique, self.oblique, -1.0);
        let lens = match self.parallel {
            true => Lens::Orthographic { height: 2.0 * self.half },
            false => Lens::Viewport { vw: 2.0 * self.half, vh: 2.0 * self.half, distance: 1.0 },
        };
        let camera = Camera { look: Look::View(tilt), lens, ..Camera::CANONICAL };
        let mut site = Site::new(camera, [self.width; 2]);
        let on_ray = |depth: f64| DVec3::from_array(site.on_ray(self.pixel, depth));
        let d = on_ray(1.0) - on_ray(0.0);
        let side = d.cross(DVec3::new(self.turn.cos(), self.turn.sin(), 0.0)).normalize();
        let at = on_ray(self.z) + side * (self.r * self.impact);
        let second = site.place(on_ray(self.z * self.second).to_array());
        let center = site.place(at.to_array());
        site.scene.spheres.push(center, self.r, None);
        if self.second > 0.0 {
            site.scene.spheres.push(second, self.r * 1e-3, None);
        }
        let view = View::new(&site.scene).ok()?;
        let binned = BinnedScene::new(&Binning {
            terms,
            level: super::claims::coarse(&site.scene),
            ..Binning::of(&site.scene, &view, 1e-5, &halfline_ground::memory::Pool::default())
        })
        .ok()??;
        let e = Exact::new(&site.scene, self.pixel, 0);
        let (b, disc) = (e.b(), e.disc());
        let unit = match binned.generals.first() {
            _ if self.parallel => dd::ldexp(binned.projection.size.into(), view.unit),
            Some(n) => dd::ldexp(1.0, dd::exponent(n.scale.into()) + view.unit),
            // The unit of a projected sphere's offsets is z times the unit of slopes.
            None => f64::from(binned.projection.unit),
        };
        let length = if binned.generals.is_empty() && !self.parallel { e.p[2] * unit.into() } else { unit.into() };
        let power = dd::dot(e.p, e.p) - e.r * e.r;
        let root = disc.sqrt();
        let depth = match (disc.hi >= 0.0, power.hi > 0.0, b.hi > 0.0) {
            (false, ..) => None,
            (_, true, true) => Some(power / (b + root)),
            (_, true, false) => None,
            (_, _, true) => Some((b + root) / e.a),
            (_, _, false) => Some(-power / (root - b)),
        };
        let relative = |t: Dd| (t.ldexp(-view.unit) - f64::from(binned.projection.depth).into()).value();
        Some(Staged {
            b: (b / length).value(),
            g: e.g().map(|g| (g / length).value()),
            disc: disc / (length * length),
            depth: depth.map(relative),
            pixel: self.pixel,
            scene: site.scene,
            view,
            binned,
        })
    }

    /// The shot as one word, whose numbers are bits.
    pub(super) fn to_word(&self) -> String {
        let Self { half, width, pixel: [i, j], z, r, impact, turn, oblique, parallel, second } = self;
        let numbers = [half, z, r, impact, turn, oblique, second].map(|x| format!("{:x}", x.to_bits())).join(",");
        format!("{width},{i},{j},{},{numbers}", u8::from(*parallel))
    }

    /// The shot of such a word.
    pub(super) fn of_word(word: &str) -> Option<Self> {
        let parts: Vec<_> = word.split(',').collect();
        let [width, i, j, parallel] = [0, 1, 2, 3].map(|k| parts.get(k)?.parse().ok());
        let [half, z, r, impact, turn, oblique, second] =
            [4, 5, 6, 7, 8, 9, 10].map(|k| u64::from_str_radix(parts.get(k)?, 16).map(f64::from_bits).ok());
        Some(Self {
            half: half?,
            width: width?,
            pixel: [i?, j?],
            z: z?,
            r: r?,
            impact: impact?,
            turn: turn?,
            oblique: oblique?,
            parallel: parallel? == 1,
            second: second?,
        })
    }

    /// Moves numbers to just above powers of two, where rounding loses most.
    fn snap(&mut self, rng: &mut Rng) {
        let width = f64::from(self.width);
        self.half = just_above_power(rng, self.half / width) * width;
        self.r = just_above_power(rng, self.r);
        self.pixel = self.pixel.map(|k| {
            let odd = 2.0 * f64::from(k) + 1.0 - width;
            let snapped = odd.signum() * just_above_power(rng, odd.abs());
            ((snapped + width - 1.0) / 2.0).round().clamp(0.0, width - 1.0) as u32
        });
    }

    /// A small change, most often of the last digits only.
    pub(super) fn mutated(&self, rng: &mut Rng) -> Self {
        let mut next = self.clone();
        let mut nudge = |x: f64| match rng.below(3) {
            0 => x,
            _ => x * (1.0 + rng.between(-1.0, 1.0) * rng.decade(-6.0, -0.5)),
        };
        (next.half, next.z, next.r, next.turn) = (nudge(self.half), nudge(self.z), nudge(self.r), nudge(self.turn));
        // A grazing ray stays a grazing ray.
        next.impact = 1.0 + nudge(self.impact - 1.0);
        let mut step = |k: u32| (k + rng.below(7)).saturating_sub(3).min(self.width - 1);
        next.pixel = self.pixel.map(&mut step);
        next
    }
}

impl Staged {
    pub(super) fn is_near(&self) -> bool {
        !self.binned.generals.is_empty()
    }

    /// The error of f64 in the depth of a projected sphere's centre, in the frame's unit.
    pub(super) fn depth_error(&self) -> f64 {
        let away = glam::DVec3::from_array(self.scene.spheres.centers[0]) - self.view.basis.e;
        let [x, y, z] = away.abs().to_array();
        let depth = -away.dot(self.view.basis.w);
        dd::ldexp((5.0 * (x + y + z) + depth.abs()) / (1u64 << 53) as f64, -self.view.unit)
    }
}

/// The distributions of shots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Regime {
    /// The middle of a narrow lens: |d|^2 is nearly 1.
    Middle,
    /// The same with the sphere only a few radii away.
    Close,
    /// Hit at the centre, at its own reference depth: roundings of the centre's depth have no effect.
    Pierced,
    /// Missed by as much as is possible for a candidate.
    Passed,
    /// The corners of a lens of up to 175 degrees.
    Wide,
    /// The middle of the edges of such a lens; hit at the centre or missed by a large distance.
    Edge,
    /// So far and small that the host's rounding of the projected centre matters.
    Tiny,
    /// Across the eye plane or beside the eye.
    EyePlane,
    /// The same through a wide lens.
    EyePlaneWide,
    /// Outside, close to a large surface.
    Ground,
    /// Inside the sphere.
    Inside,
    /// Ahead, less than two radii away, and hit near the centre.
    Ahead,
    /// Small, in an image too wide for projected centres, and missed by a large distance.
    Missed,
    /// The eye near the centre of the sphere.
    Center,
    /// The eye close to a surface, looking to or from the centre through a long lens: p.d hardly changes.
    Axis,
    /// Parallel rays: spheres of any size in front of the plane.
    Parallel,
    /// Parallel rays: spheres so small and far that the host's rounding of their positions matters.
    ParallelTiny,
}

impl Regime {
    pub(super) const FRONT: [Self; 9] = [
        Self::Middle,
        Self::Close,
        Self::Pierced,
        Self::Passed,
        Self::Wide,
        Self::Edge,
        Self::Tiny,
        Self::Parallel,
        Self::ParallelTiny,
    ];
    pub(super) const GENERAL: [Self; 8] = [
        Self::EyePlane,
        Self::EyePlaneWide,
        Self::Ground,
        Self::Inside,
        Self::Ahead,
        Self::Missed,
        Self::Center,
        Self::Axis,
    ];

    pub(super) fn shot(self, rng: &mut Rng) -> Shot {
        use Regime::*;
        // With wide lenses, only in large images are the offsets known more exactly than they are rounded.
        let width = if matches!(self, Wide | Edge) { 500_000 + rng.below(500_000) } else { 2 + rng.below(2000) };
        let any = |rng: &mut Rng| [rng.below(width), rng.below(width)];
        let graze = |rng: &mut Rng| 1.0 + rng.sign() * rng.decade(-9.0, -5.5);
        // On the axis, halfway, or grazing.
        let impact = match rng.below(4) {
            0 => rng.decade(-6.0, -1.0),
            1 => rng.between(0.0, 0.999),
            // Missed, but in the zone where a candidate's bound is needed.
            2 => rng.between(1.0, 1.4),
            _ => graze(rng),
        };
        let turn = rng.between(0.0, std::f64::consts::TAU);
        let second = [0.0, 0.85, 1.2, 10.0][rng.below(4) as usize];
        let shot = |half, pixel, z, r| {
            let oblique = if matches!(self, Tiny | ParallelTiny) { 0.7 } else { 0.0 };
            let parallel = matches!(self, Parallel | ParallelTiny);
            Shot { half, width, pixel, z, r, impact, turn, oblique, parallel, second }
        };
        let mut shot = match self {
            Middle => shot(rng.decade(-4.0, -1.5), any(rng), rng.decade(0.5, 3.0), 1.0),
            Close => shot(rng.decade(-2.0, -0.2), any(rng), rng.between(1.8, 4.0), 1.0),
            Pierced => {
                let shot = shot(rng.decade(-3.0, -0.3), any(rng), rng.decade(0.35, 2.0), 1.0);
                Shot { impact: rng.decade(-6.0, -2.0), second: 0.0, ..shot }
            }
            Passed => {
                let shot = shot(rng.decade(-4.0, -1.5), any(rng), rng.decade(0.5, 3.0), 1.0);
                Shot { impact: rng.between(1.35, 1.41), ..shot }
            }
            Edge => {
                let pixel = [width / 2, rng.below(2) * (width - 1)];
                // As large as a projected sphere can be with such a wide lens: offsets of many pixels.
                let half = rng.decade(0.5, 1.34);
                let shot = shot(half, pixel, 1.0, rng.between(0.05, 0.25) / (half * half));
                if rng.below(2) == 0 {
                    Shot { impact: rng.decade(-6.0, -0.5), second: 0.0, ..shot }
                } else {
                    // Perpendicular to the slope, where the ray's obliqueness matters most.
                    Shot { impact: rng.between(1.3, 1.41), turn: rng.decade(-6.0, -1.0), second: 0.0, ..shot }
                }
            }
            Wide => {
                let pixel = any(rng).map(|k| if k % 2 == 0 { k / 8 } else { width - 1 - k / 8 });
                shot(rng.decade(-0.3, 1.3), pixel, 1.0, rng.decade(-4.0, -2.0))
            }
            Tiny => {
                let half = rng.decade(-8.0, -2.0);
                shot(half, any(rng), 1.0, half / f64::from(width) * rng.decade(-5.0, -1.0))
            }
            Parallel => {
                let half = rng.decade(-2.0, 2.0);
                let r = half * rng.decade(-2.0, 0.3);
                shot(half, any(rng), r * rng.decade(0.1, 4.0), r)
            }
            ParallelTiny => {
                let half = rng.decade(-3.0, 3.0);
                shot(half, any(rng), half * rng.decade(0.0, 6.0), half / f64::from(width) * rng.decade(-5.0, -1.0))
            }
            EyePlane => shot(rng.decade(-1.0, 0.0), any(rng), rng.between(-0.2, 1.0), rng.decade(-1.0, 1.0)),
            EyePlaneWide => shot(rng.decade(0.5, 2.0), any(rng), rng.between(-0.2, 1.0), rng.decade(-1.0, 2.0)),
            Ground => {
                let z = rng.between(0.01, 1.0);
                let mut shot = shot(rng.decade(-2.0, 0.5), any(rng), z, 1.0);
                // Places the eye just outside: |centre|^2 = z^2 a + impact^2.
                shot.impact = (1.0 - z * z).abs().sqrt() * (1.0 + rng.decade(-6.0, -0.5));
                shot
            }
            Inside => {
                let mut shot = shot(rng.decade(-2.0, 0.5), any(rng), rng.between(-0.7, 0.7), 1.0);
                shot.impact = rng.between(0.0, 0.7);
                shot
            }
            Ahead => {
                let mut shot = shot(rng.decade(-3.0, -0.5), any(rng), rng.between(1.45, 1.95), 1.0);
                shot.impact = rng.decade(-6.0, -1.0);
                shot
            }
            Missed => {
                let r = rng.decade(-6.0, -2.0);
                let half =
                    just_above_power(rng, rng.clone().between(35.0, 100.0) / f64::from(width)) * f64::from(width);
                let steps = rng.decade(-0.7, 0.7) / half * f64::from(width);
                let row = (f64::from(width) - just_above_power(rng, steps)) / 2.0;
                let row = row as u32;
                let z = 1.0 + rng.decade(-6.0, -1.0);
                let mut shot = shot(half, [row, width / 2], z, r);
                // Sideways and back to the axis, so that p x d is determined by the slopes.
                let y = (1.0 - (2.0 * f64::from(row) + 1.0) / f64::from(width)) * half;
                (shot.impact, shot.turn) = (-y * z * y.hypot(1.0) / r, 0.0);
                shot
            }
            Center => {
                // |d|^2 just below a power of two, where the ulp of its reciprocal is largest.
                let edge = [rng.below(width), rng.below(2) * (width - 1)];
                let half = if rng.below(2) == 0 { rng.between(0.3, 1.1) } else { rng.decade(-3.0, -0.5) };
                let mut shot = shot(half, edge, rng.decade(-4.0, -1.0), 1.0);
                shot.impact = rng.decade(-6.0, -1.0);
                shot
            }
            Axis => {
                let z = 1.0 + rng.sign() * rng.decade(-9.0, -1.0);
                let mut shot = shot(rng.decade(-11.0, -6.0), any(rng), z, 1.0);
                shot.impact = rng.decade(-7.0, -1.0);
                shot
            }
        };
        if self != Missed && rng.below(2) == 0 {
            shot.snap(rng);
        }
        if Self::GENERAL.contains(&self) {
            shot.second = 0.0;
        }
        shot
    }
}

fn just_above_power(rng: &mut Rng, x: f64) -> f64 {
    dd::ldexp(1.0 + rng.decade(-6.0, -2.0), dd::exponent(x * 1.4))
}
