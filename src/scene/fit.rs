//! Framing: the nearest camera from which all spheres are completely visible.

use super::camera::{Camera, Lens, Look, Viewport};
use super::orient::{Facing, Spread};
use super::source::{SphereSource, middle};
use super::{ImagePlane, Scene, Spheres, extent};
use crate::error::{Error, Place, Result};
use crate::parallel::{self, CHEAP};
use crate::quote::setting;
use glam::DVec3;

/// The rules of framing: the free margins, the framed shape and the aim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Framing {
    /// Share of the image's height and width that stays free around the spheres, in total.
    pub margin: f64,
    /// Whether to frame the ball around all spheres, which has the same size from every side, instead of the spheres.
    pub ball: bool,
    /// Whether an orthographic camera keeps the height of its view and only the eye moves; otherwise the height is
    /// fitted.
    pub keep_height: bool,
    /// Shares of the image's width that stay free at its left and right side, besides the margin, for a legend.
    pub legend_shares: [f64; 2],
    /// The point that is in the middle of the rest of the image; `None` centres the spheres.
    pub aim: Option<DVec3>,
}

impl Default for Framing {
    /// 4 % margin around the spheres, which are in the middle of the image.
    fn default() -> Self {
        Self { margin: 0.04, ball: false, keep_height: false, legend_shares: [0.0; 2], aim: None }
    }
}

/// Vertical field of view of a framed scene without a lens, degrees: a portrait lens with little perspective.
const VFOV: f64 = 30.0;

impl Scene {
    /// Gives the scene the default camera: it looks along -z with y up, and shows all spheres.
    pub fn frame_all(&mut self, framing: &Framing) -> Result<()> {
        self.frame_from(Facing::FRONT, framing)
    }

    /// Gives the scene the default camera of its file: molecules are seen along their principal axes ([`Spread::facing`]),
    /// all else as by [`Scene::frame_all`].
    ///
    /// # Errors
    /// As [`Camera::fit`].
    pub fn frame_by_default(&mut self, is_molecule: bool, framing: &Framing) -> Result<()> {
        let is_tall = self.image.height > self.image.width;
        let facing = if is_molecule { Spread::of(&self.spheres)?.facing(is_tall) } else { Facing::FRONT };
        self.frame_from(facing, framing)
    }

    /// Gives the scene a camera with the default lens, which looks in this direction and shows all spheres.
    ///
    /// # Errors
    /// As [`Camera::fit`].
    pub fn frame_from(&mut self, facing: Facing, framing: &Framing) -> Result<()> {
        facing.turn(&mut self.camera);
        self.camera.lens = Lens::Vfov { degrees: VFOV, distance: 1.0 };
        self.camera.fit(self.image, &self.spheres, framing)
    }
}

impl Camera {
    /// Moves the eye so that all of these spheres, which may be some of a scene's, are completely visible within the
    /// viewport less its margin, for an image of this size. The direction, the up vector and the angles of the lens are kept.
    ///
    /// A sphere is within the pyramid of a viewport if its centre is at least a radius inside of each of the four
    /// planes through the eye. The planes' directions are known, so each plane is placed to touch the extreme sphere on
    /// its side. The eye is where the tighter of the two pairs of planes meets; the other pair is centred.
    ///
    /// An orthographic camera sees a box instead of a pyramid: the horizontal and vertical extents of the spheres give
    /// its height, and the eye lies in front of the nearest sphere by the scene's own size.
    ///
    /// # Errors
    /// Errors of [`Camera::basis`] and [`Camera::viewport`]; [`Error::Scene`] for spheres so near the limits of f64
    /// that no eye is far enough.
    pub fn fit(&mut self, image: ImagePlane, spheres: &dyn SphereSource, framing: &Framing) -> Result<()> {
        match self.reach(image, spheres, framing, None)? {
            Some(reach) => self.fit_to(image, framing, &reach),
            None => Ok(()),
        }
    }

    /// The reach of these spheres to the sides of the view, relative to a point: that of another reach, so that both can be
    /// joined, or the middle of the spheres. `None` without spheres. An `at` becomes the view.
    ///
    /// # Errors
    /// As [`Camera::fit`].
    pub fn reach(
        &mut self,
        image: ImagePlane,
        spheres: &dyn SphereSource,
        framing: &Framing,
        like: Option<&Reach>,
    ) -> Result<Option<Reach>> {
        let ends @ [low, high] = spheres.ends()?;
        if low.x > high.x {
            return Ok(None);
        }
        let normals = self.normals(image, framing)?;
        let (middle, sides) = if framing.ball {
            let ball = ball(spheres, framing.aim.unwrap_or_else(|| middle(ends)))?;
            let middle = like.map_or_else(|| ball.middle(), |like| like.middle);
            (middle, ball.sides(normals, middle)?)
        } else {
            // Coordinates are relative to the middle, so that distant scenes lose no precision.
            let middle = like.map_or_else(|| middle(ends), |like| like.middle);
            (middle, spheres.sides(normals, middle)?)
        };
        Ok(Some(Reach { ends, middle, sides }))
    }

    /// The normals of the view's sides, which point inwards: left, right, bottom, top, and for parallel rays back and front. An
    /// `at` becomes the view.
    fn normals(&mut self, image: ImagePlane, framing: &Framing) -> Result<[DVec3; 6]> {
        if let Look::At(at) = self.look {
            // An `at` that gives no direction is reported before it is changed.
            self.basis()?;
            self.look = Look::View(at - self.eye);
        }
        let basis = self.basis()?;
        let viewport = self.viewport(image.width, image.height)?;
        if matches!(self.lens, Lens::Intrinsics { .. }) {
            let problem = "a lens of intrinsics belongs to its pose, and is not moved to show all spheres";
            return Err(Error::settings(problem, format!("use a viewport or {}", setting::VFOV)));
        }
        if viewport.is_parallel() {
            return Ok([basis.u, -basis.u, basis.v, -basis.v, basis.w, -basis.w]);
        }
        let pair = |axis: DVec3, [[sine, cosine], [other_sine, other_cosine]]: [[f64; 2]; 2]| {
            [cosine * axis - sine * basis.w, -other_cosine * axis - other_sine * basis.w]
        };
        let (across, down) = slopes(framing, viewport);
        let ([left, right], [bottom, top]) = (pair(basis.u, across), pair(basis.v, down));
        Ok([left, right, bottom, top, DVec3::ZERO, DVec3::ZERO])
    }

    /// Moves the eye so that everything within this reach is completely visible, as [`Camera::fit`] does; the direction
    /// of the view and the angles of the lens are those for which the reach was taken.
    ///
    /// # Errors
    /// As [`Camera::fit`].
    pub fn fit_to(&mut self, image: ImagePlane, framing: &Framing, reach: &Reach) -> Result<()> {
        self.place(image, framing, reach)?;
        if self.eye.is_finite() {
            return Ok(());
        }
        let problem = format!("{}: the eye that sees them all is beyond the range of f64", extent(reach.ends));
        Err(Error::scene(Place::field("spheres"), problem, "use a larger unit of length in the scene"))
    }

    /// The same; the eye may not be finite.
    fn place(&mut self, image: ImagePlane, framing: &Framing, reach: &Reach) -> Result<()> {
        let basis = self.basis()?;
        let viewport = self.viewport(image.width, image.height)?;
        let Reach { middle, sides: [left, right, bottom, top, _, front], .. } = *reach;
        let aim = framing.aim.map(|aim| aim - middle).map(|aim| [basis.u, basis.v, basis.w].map(|axis| axis.dot(aim)));
        if viewport.is_parallel() {
            let (right, top, front) = (-right, -top, -front);
            let shape = f64::from(image.height) / f64::from(image.width);
            // The middle of the picture on an axis, and the least length of its free part.
            let span = |low: f64, high: f64, aim: Option<f64>| match aim {
                None => ((low + high) / 2.0, high - low),
                Some(aim) => (aim, 2.0 * (high - aim).max(aim - low)),
            };
            let ((x, across), (y, down)) =
                (span(left, right, aim.map(|aim| aim[0])), span(bottom, top, aim.map(|a| a[1])));
            let [inset_left, inset_right] = framing.legend_shares;
            let height = (down / free(framing)).max(across * shape / (free(framing) - inset_left - inset_right));
            let shown = if framing.keep_height { viewport.vh } else { height };
            if !framing.keep_height {
                self.lens = Lens::Orthographic { height };
            }
            let back = front + height.max(right - left);
            let x = x - (inset_left - inset_right) / 2.0 * shown / shape;
            self.eye = middle + x * basis.u + y * basis.v + back * basis.w;
            return Ok(());
        }
        let (across, down) = slopes(framing, viewport);
        // The eye's least distance back, and its coordinate along the axis: a constant, and a part of the distance.
        let pair = |low: f64, high: f64, [[sine, cosine], [other_sine, other_cosine]]: [[f64; 2]; 2], axis: usize| {
            // Both planes in the scale of the first one; 1 where they are alike.
            let scale = cosine / other_cosine;
            let (high, other_sine) = (high * scale, other_sine * scale);
            let part = (sine - other_sine) / (2.0 * cosine);
            match aim {
                None => (-(low + high) / (sine + other_sine), (low - high) / (2.0 * cosine), part),
                Some(aim) => {
                    let at = aim[axis] - part * aim[2];
                    let least = (at * cosine - low).max(-at * cosine - high);
                    (2.0 * least / (sine + other_sine), at, part)
                }
            }
        };
        let ((z_across, x, along_x), (z_down, y, along_y)) = (pair(left, right, across, 0), pair(bottom, top, down, 1));
        let z = z_across.max(z_down);
        self.eye = middle + (x + along_x * z) * basis.u + (y + along_y * z) * basis.v + z * basis.w;
        Ok(())
    }
}

/// The reach of spheres to the sides of a view: their extreme distances along the normals of the sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// The corners of the box around the spheres.
    ends: [DVec3; 2],
    /// The point that the distances are relative to.
    middle: DVec3,
    /// The least distances of the spheres along the normals of the view's sides, which point inwards: left, right,
    /// bottom, top, and for parallel rays back and front.
    sides: [f64; 6],
}

impl Reach {
    /// The reach of both; `other` was taken like this one.
    #[must_use]
    pub fn with(self, other: &Self) -> Self {
        let mut sides = self.sides;
        sides.iter_mut().zip(other.sides).for_each(|(side, other)| *side = side.min(other));
        let ([low, high], [other_low, other_high]) = (self.ends, other.ends);
        Self { ends: [low.min(other_low), high.max(other_high)], sides, ..self }
    }
}

/// The share of the image between its margins. Rounding errors of framing are far below the least margin.
fn free(framing: &Framing) -> f64 {
    1.0 - framing.margin.clamp(1e-9, 0.9)
}

/// Sine and cosine of the angles between the view axis and the sides of the viewport less its margin: left and right,
/// bottom and top. The sine is negative where the free part begins beyond the axis.
fn slopes(framing: &Framing, viewport: Viewport) -> ([[f64; 2]; 2], [[f64; 2]; 2]) {
    let to = |side: f64, inset: f64| {
        let slope = (free(framing) - 2.0 * inset) * side / (2.0 * viewport.d);
        let length = slope.hypot(1.0);
        [slope / length, 1.0 / length]
    };
    (framing.legend_shares.map(|inset| to(viewport.vw, inset)), [to(viewport.vh, 0.0); 2])
}

impl Spheres {
    /// The least n.(c - p) - r of all spheres; infinite without any.
    pub(super) fn least_along(&self, normal: DVec3, from: DVec3) -> f64 {
        let along = |id: usize| normal.dot(DVec3::from_array(self.centers[id]) - from) - self.radii[id];
        let least = parallel::blocks(0..self.len(), CHEAP, &|ids, _| ids.map(along).fold(f64::INFINITY, f64::min));
        least.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// The ball about a point that contains all spheres.
fn ball(spheres: &dyn SphereSource, middle: DVec3) -> Result<Spheres> {
    let mut radius = 0.0_f64;
    spheres.each(&mut |block| {
        let reach = |id: usize| (DVec3::from_array(block.centers[id]) - middle).length() + block.radii[id];
        let most = parallel::blocks(0..block.len(), CHEAP, &|ids, _| ids.map(reach).fold(0.0, f64::max));
        radius = most.into_iter().fold(radius, f64::max);
        Ok(())
    })?;
    let mut ball = Spheres::default();
    ball.push(middle.to_array(), radius, None);
    Ok(ball)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ImagePlane;
    use crate::{Camera, Scene};

    /// Every sphere is inside of all four planes, and the tighter pair of planes is touched, for every position and
    /// scale.
    #[test]
    fn framing_cuts_no_sphere_and_is_tight() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        for case in 0..200 {
            let scale = 10f64.powi(case % 24 - 12);
            let offset = DVec3::new(random(), random(), random()) * scale * if case % 3 == 0 { 1e6 } else { 1.0 };
            let mut spheres = Spheres::default();
            for _ in 0..1 + case % 40 {
                let center = offset + DVec3::new(random(), random(), random()) * scale;
                spheres.push(center.to_array(), scale * (0.01 + 0.2 * (random() + 0.5)), None);
            }
            let view = DVec3::new(random(), random(), random());
            let lens = Lens::Vfov { degrees: 1.0 + 170.0 * (random() + 0.5), distance: 3.0 };
            let camera =
                Camera { eye: DVec3::ZERO, look: Look::View(view), up: DVec3::new(random(), random(), 1.0), lens };
            let image = ImagePlane { width: 1 + case as u32 * 7, height: 100, background: [0.0; 3] };
            let mut scene = Scene { camera, image, spheres, lighting: Default::default() };
            scene.camera.fit(image, &scene.spheres, &Framing { margin: 0.0, ..Framing::default() }).expect("framed");
            let (basis, v) =
                (scene.camera.basis().expect("a basis"), scene.camera.viewport(image.width, 100).expect("one"));
            let mut least = [f64::INFINITY; 4];
            for (center, radius) in scene.spheres.centers.iter().zip(&scene.spheres.radii) {
                let p = DVec3::from_array(*center) - scene.camera.eye;
                for (k, (axis, side)) in
                    [(basis.u, v.vw), (-basis.u, v.vw), (basis.v, v.vh), (-basis.v, v.vh)].iter().enumerate()
                {
                    let normal = (*axis * v.d - basis.w * (side / 2.0)).normalize();
                    least[k] = least[k].min((normal.dot(p) - radius) / scale);
                }
            }
            // 1e-9 of the scene's extent: the margin of 1e-9, less the rounding of an offset of 1e6.
            assert!(least.iter().all(|gap| *gap >= -1e-9), "case {case}: cut by {least:?}");
            let tight = |a: f64, b: f64| a.max(b) < 1e-6;
            assert!(tight(least[0], least[1]) || tight(least[2], least[3]), "case {case}: loose by {least:?}");
        }
    }

    #[test]
    fn orthographic_framing_is_tight() {
        let mut spheres = Spheres::default();
        spheres.push([1.0, 2.0, -5.0], 1.0, None);
        spheres.push([4.0, 2.0, 3.0], 0.5, None);
        let camera = Camera { lens: Lens::Orthographic { height: 1.0 }, ..Camera::CANONICAL };
        let image = ImagePlane { width: 200, height: 100, background: [0.0; 3] };
        let mut scene = Scene { camera, image, spheres, lighting: Default::default() };
        scene.camera.fit(image, &scene.spheres, &Framing { margin: 0.0, ..Framing::default() }).expect("framed");
        let Lens::Orthographic { height } = scene.camera.lens else { panic!("still parallel") };
        // From 0 to 4.5 across, half as high; from 1 to 3 down is less.
        assert!((height - 2.25).abs() < 1e-8, "{height}");
        assert!((scene.camera.eye.x - 2.25).abs() < 1e-12 && (scene.camera.eye.y - 2.0).abs() < 1e-12);
        assert!(scene.camera.eye.z > 3.5, "{}", scene.camera.eye.z);
    }
}
