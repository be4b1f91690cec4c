//! Framing: the nearest camera from which all spheres are completely visible.

use super::camera::{Camera, CurvedRays, Lens, Look, Viewport};
use super::orient::{Facing, Spread};
use super::source::{SphereSource, middle};
use super::{ImagePlane, Scene, Spheres, extent};
use glam::DVec3;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::parallel::{self, CHEAP};

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

/// Sine and cosine of the angles between the view axis and the sides of the free part of the image: left and right, bottom and top. A sine is
/// negative where the free part begins beyond the axis.
type Slopes = [[[f64; 2]; 2]; 2];

/// Vertical field of view of a framed scene without a lens, degrees: a portrait lens with little perspective.
const VFOV: f64 = 30.0;

impl Scene {
    /// Gives the image another size, for which the lens is made again.
    pub fn resize(&mut self, [width, height]: [u32; 2]) {
        self.camera.lens = self.camera.lens.resized([self.image.width, self.image.height], [width, height]);
        (self.image.width, self.image.height) = (width, height);
    }

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
    /// A distorted lens and a fisheye have the widest pyramid that is within their image, at most 60 degrees from the axis to each side. The
    /// eye of a panorama, which sees all around, is the middle of the box around the spheres, and its `at` stays.
    ///
    /// # Errors
    /// Errors of [`Camera::basis`], [`Camera::viewport`] and [`Camera::check`]; [`Error::Scene`] for spheres so near the limits of f64
    /// that no eye is far enough, and for a curved lens without a ray in the middle of the free part of its image.
    pub fn fit(&mut self, image: ImagePlane, spheres: &dyn SphereSource, framing: &Framing) -> Result<()> {
        match self.reach(image, spheres, framing, None)? {
            Some(reach) => self.fit_to(image, framing, &reach),
            None => Ok(()),
        }
    }

    /// The reach of these spheres to the sides of the view, relative to a point: the middle of the spheres, or the point of
    /// another reach, to join both. `None` without spheres. An `at` becomes the view.
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
        if self.lens.is_panorama() {
            return Ok([DVec3::ZERO; 6]);
        }
        if let Look::At(at) = self.look {
            // An `at` that gives no direction is reported before it is changed.
            self.basis()?;
            self.look = Look::View(at - self.eye);
        }
        let basis = self.basis()?;
        let Some([across, down]) = self.slopes(image, framing)? else {
            return Ok([basis.u, -basis.u, basis.v, -basis.v, basis.w, -basis.w]);
        };
        let pair = |axis: DVec3, [[sine, cosine], [other_sine, other_cosine]]: [[f64; 2]; 2]| {
            [cosine * axis - sine * basis.w, -other_cosine * axis - other_sine * basis.w]
        };
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

    /// Whether the height of an image of this size, and not its width, decides from how near [`Camera::fit`] sees these spheres.
    /// True without spheres and for a panorama, which see everything.
    ///
    /// # Errors
    /// As [`Camera::fit`].
    pub fn is_bound_by_height(&self, image: ImagePlane, spheres: &dyn SphereSource, framing: &Framing) -> Result<bool> {
        let mut camera = *self;
        let Some(reach) = camera.reach(image, spheres, framing, None)? else { return Ok(true) };
        let [across, down] = camera.place(image, framing, &reach)?;
        Ok(down >= across)
    }

    /// As [`Camera::fit_to`]; the eye may not be finite. Returns how far back the eye is, or how high the view of parallel rays, by the
    /// width and by the height of the image.
    fn place(&mut self, image: ImagePlane, framing: &Framing, reach: &Reach) -> Result<[f64; 2]> {
        if self.lens.is_panorama() {
            self.eye = middle(reach.ends);
            return Ok([0.0; 2]);
        }
        let basis = self.basis()?;
        let Reach { middle, sides: [left, right, bottom, top, _, front], .. } = *reach;
        let aim = framing.aim.map(|aim| aim - middle).map(|aim| [basis.u, basis.v, basis.w].map(|axis| axis.dot(aim)));
        let Some([across, down]) = self.slopes(image, framing)? else {
            let viewport = self.viewport(image.width, image.height)?;
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
            let heights = [across * shape / (free(framing) - inset_left - inset_right), down / free(framing)];
            let height = heights[0].max(heights[1]);
            let shown = if framing.keep_height { viewport.vh } else { height };
            if !framing.keep_height {
                self.lens = Lens::Orthographic { height };
            }
            let back = front + height.max(right - left);
            let x = x - (inset_left - inset_right) / 2.0 * shown / shape;
            self.eye = middle + x * basis.u + y * basis.v + back * basis.w;
            return Ok(heights);
        };
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
        Ok([z_across, z_down])
    }

    /// The slopes of the sides; `None` for parallel rays.
    fn slopes(&self, image: ImagePlane, framing: &Framing) -> Result<Option<Slopes>> {
        let (size, free) = ([image.width, image.height], free(framing));
        if let Lens::Curved { curve, fx, fy, cx, cy } = self.lens {
            let insets = [framing.legend_shares[0], framing.legend_shares[1], 0.0, 0.0];
            let rays = CurvedRays::new(curve, [fx, fy, cx, cy], size)?;
            let Some(angles) = rays.pyramid(insets.map(|inset| inset + (1.0 - free) / 2.0)) else {
                let problem = "the lens has no ray in the middle of the image, so that nothing can be framed there";
                let mend = "give the eye and the point to look at, or correct the coefficients and the principal point";
                return Err(Error::scene(Place::field("camera.lens"), problem, mend));
            };
            let [left, right, bottom, top] = angles.map(f64::sin_cos).map(<[f64; 2]>::from);
            return Ok(Some([[left, right], [bottom, top]]));
        }
        let Viewport { vw, vh, d } = self.viewport(image.width, image.height)?;
        if d.is_infinite() {
            return Ok(None);
        }
        // How far the middle of the image is from the axis: to the right, and up.
        let shift = match self.lens {
            Lens::Intrinsics { fx, fy, cx, cy } => {
                [(f64::from(image.width) / 2.0 - cx) / fx, (cy - f64::from(image.height) / 2.0) / fy]
            }
            _ => [0.0; 2],
        };
        let to = |side: f64, inset: f64, shift: f64| {
            let slope = (free - 2.0 * inset) * side / (2.0 * d) + shift;
            let length = slope.hypot(1.0);
            [slope / length, 1.0 / length]
        };
        let [inset_left, inset_right] = framing.legend_shares;
        let across = [to(vw, inset_left, -shift[0]), to(vw, inset_right, shift[0])];
        Ok(Some([across, [to(vh, 0.0, -shift[1]), to(vh, 0.0, shift[1])]]))
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
    use crate::scene::camera::Curve;
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

    /// Every point of every sphere that rays of an eye touch lies in the image, by the formulas of OpenCV's documentation, for a lens that bends
    /// edges inwards, one that bends them outwards, one that folds, an off-centre one, and fisheyes.
    #[test]
    fn framing_through_a_curved_lens_cuts_no_sphere() {
        let distorted = |k: [f64; 3], p| Curve::Distorted { k: [k[0], k[1], k[2], 0.0, 0.0, 0.0], p };
        let curved = |curve, [fx, fy, cx, cy]: [f64; 4]| Lens::Curved { curve, fx, fy, cx, cy };
        let middle = [80.0, 82.0, 60.0, 45.0];
        let lenses = [
            (curved(distorted([-0.2, 0.04, 0.0], [0.003, -0.002]), middle), 0.9),
            (curved(distorted([0.3, 0.1, 0.0], [0.0; 2]), [80.0, 80.0, 50.0, 52.0]), 0.9),
            // Its picture is a disc: the image has no ray beyond.
            (curved(distorted([-0.9, 0.0, 0.0], [0.0; 2]), [60.0, 60.0, 60.0, 45.0]), 0.35),
            (curved(Curve::Fisheye { k: [0.05, -0.01, 0.0, 0.0] }, [120.0, 120.0, 61.5, 44.0]), 0.8),
            (Lens::fisheye(100.0, [0.0; 4], 120, 90), 0.8),
            (Lens::fisheye(180.0, [0.0; 4], 120, 90), 0.5),
            (Lens::fisheye(360.0, [0.0; 4], 120, 90), 0.2),
            (Lens::Intrinsics { fx: 90.0, fy: 80.0, cx: 20.0, cy: 70.0 }, 0.9),
        ];
        let image = ImagePlane { width: 120, height: 90, background: [0.0; 3] };
        let mut rng = crate::testing::Rng(0xf17);
        // The share of the image that the spheres take at least.
        for (lens, least) in lenses {
            for legend in [[0.0; 2], [0.2, 0.0], [0.0, 0.3]] {
                let mut spheres = Spheres::default();
                for _ in 0..30 {
                    let center = [0; 3].map(|_| rng.between(-4.0, 4.0));
                    spheres.push(center, rng.between(0.1, 1.2), None);
                }
                let view = DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), 1.0);
                let mut camera = Camera { eye: DVec3::ZERO, look: Look::View(view), up: DVec3::Y, lens };
                let framing = Framing { legend_shares: legend, ..Framing::default() };
                camera.fit(image, &spheres, &framing).expect("framed");
                let basis = camera.basis().expect("a basis");
                let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
                for (center, radius) in spheres.centers.iter().zip(&spheres.radii) {
                    let toward = DVec3::from_array(*center) - camera.eye;
                    let distance = toward.length();
                    assert!(distance > *radius, "{lens:?}: the eye is inside");
                    let (axis, sine) = (toward / distance, radius / distance);
                    let side = axis.any_orthonormal_vector();
                    let other = axis.cross(side);
                    for n in 0..24 {
                        let (s, c) = (f64::from(n) / 24.0 * std::f64::consts::TAU).sin_cos();
                        let ray = (1.0 - sine * sine).sqrt() * axis + sine * (c * side + s * other);
                        let at = shown(lens, [ray.dot(basis.u), -ray.dot(basis.v), -ray.dot(basis.w)]);
                        for k in 0..2 {
                            (low[k], high[k]) = (low[k].min(at[k]), high[k].max(at[k]));
                        }
                    }
                }
                let ends = [120.0 * legend[0], 120.0 * (1.0 - legend[1])];
                let is_shown = low[0] >= ends[0] && high[0] <= ends[1] && low[1] >= 0.0 && high[1] <= 90.0;
                assert!(is_shown, "{lens:?} {legend:?}: {low:?} {high:?}");
                let used = ((high[0] - low[0]) / (ends[1] - ends[0])).max((high[1] - low[1]) / 90.0);
                assert!(used > 0.7 * least || legend != [0.0; 2], "{lens:?}: {used} of the image is used");
            }
        }
    }

    /// The place of a direction (right, down, ahead) by docs.opencv.org, calib3d and fisheye.
    fn shown(lens: Lens, [x, y, z]: [f64; 3]) -> [f64; 2] {
        match lens {
            Lens::Intrinsics { fx, fy, cx, cy } => [fx * x / z + cx, fy * y / z + cy],
            Lens::Curved { curve: Curve::Distorted { k, p: [p1, p2] }, fx, fy, cx, cy } => {
                let (x, y) = (x / z, y / z);
                let r2 = x * x + y * y;
                let s = 1.0 + k[0] * r2 + k[1] * r2 * r2 + k[2] * r2 * r2 * r2;
                let across = x * s + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
                [fx * across + cx, fy * (y * s + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y) + cy]
            }
            Lens::Curved { curve: Curve::Fisheye { k }, fx, fy, cx, cy } => {
                let r = x.hypot(y);
                let theta = r.atan2(z);
                let bent = theta * (1.0 + k[0] * theta.powi(2) + k[1] * theta.powi(4));
                [fx * bent * x / r + cx, fy * bent * y / r + cy]
            }
            _ => unreachable!("no lens of this test"),
        }
    }

    /// A panorama is seen from the middle of the box around the spheres.
    #[test]
    fn the_eye_of_a_panorama_is_in_the_middle() {
        let mut spheres = Spheres::default();
        spheres.push([1.0, 2.0, -5.0], 1.0, None);
        spheres.push([5.0, 2.0, 3.0], 1.0, None);
        let mut camera = Camera { lens: Lens::panorama(64, 32), ..Camera::CANONICAL };
        camera
            .fit(ImagePlane { width: 64, height: 32, ..ImagePlane::default() }, &spheres, &Framing::default())
            .expect("framed");
        assert_eq!((camera.eye, camera.look), (DVec3::new(3.0, 2.0, -1.0), Camera::CANONICAL.look));
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
