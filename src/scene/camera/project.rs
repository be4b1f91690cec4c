//! The place of a point of the scene in an image, for what is drawn over a picture.

use super::{Basis, Camera, CameraRecord, CurvedRays, Intrinsics, Lens, Viewport};
use glam::DVec3;
use halfline_ground::error::Result;

/// A point as an image shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// Columns from the left edge and rows from the top edge: the middle of the first pixel is (0.5, 0.5).
    pub at: [f64; 2],
    /// Pixels across in a unit of length at its depth; of a curved lens the mean of all directions across its ray, of a
    /// panorama at its equator.
    pub scale: f64,
}

/// A camera for an image of a certain size, which projects points into it.
#[derive(Debug, Clone, Copy)]
pub struct Projector {
    basis: Basis,
    lens: ProjectedLens,
}

/// The part of a lens that places are made of.
#[derive(Debug, Clone, Copy)]
enum ProjectedLens {
    /// Focal lengths and principal point, pixels.
    Pixels(Intrinsics),
    /// Parallel rays through a view of this size into an image of so many pixels.
    Parallel {
        view: [f64; 2],
        image: [f64; 2],
    },
    Curved(CurvedRays),
}

impl Camera {
    /// The camera for points that are drawn into an image of `size` columns and rows.
    ///
    /// # Errors
    /// Errors of [`Camera::basis`] and [`Camera::check`].
    pub fn projector(&self, size: [u32; 2]) -> Result<Projector> {
        let [width, height] = size;
        let basis = self.basis()?;
        let lens = match self.lens {
            Lens::Curved { curve, fx, fy, cx, cy } => {
                ProjectedLens::Curved(CurvedRays::new(curve, [fx, fy, cx, cy], size)?)
            }
            _ => match CameraRecord::new(self, size, None)?.intrinsics {
                Some(pixels) => ProjectedLens::Pixels(pixels),
                None => {
                    let Viewport { vw, vh, .. } = self.viewport(width, height)?;
                    ProjectedLens::Parallel { view: [vw, vh], image: size.map(f64::from) }
                }
            },
        };
        Ok(Projector { basis, lens })
    }

    /// The place of a point in an image of `size` columns and rows, as of [`Projector::place`]. For many points keep a [`Projector`].
    ///
    /// # Errors
    /// Errors of [`Camera::projector`].
    pub fn project(&self, size: [u32; 2], point: DVec3) -> Result<Option<Projected>> {
        Ok(self.projector(size)?.place(point))
    }
}

impl Projector {
    /// The place of a point, also beyond the edges of the image: that whose viewing ray goes through the point, by the model of a curved lens.
    /// `None` for a point that no ray of the lens sees: one that is not in front of the eye, beyond the fold of a distorted lens or a
    /// fisheye, or at the eye itself.
    #[must_use]
    pub fn place(&self, point: DVec3) -> Option<Projected> {
        let Self { basis, lens } = self;
        let away = point - basis.e;
        let [x, y, depth] = [away.dot(basis.u), away.dot(basis.v), -away.dot(basis.w)];
        let is_ahead = depth > 0.0;
        match lens {
            ProjectedLens::Pixels(Intrinsics { fx, fy, cx, cy }) => {
                let at = [cx + fx * x / depth, cy - fy * y / depth];
                Some(Projected { at, scale: fx / depth }).filter(|_| is_ahead)
            }
            ProjectedLens::Parallel { view: [vw, vh], image: [width, height] } => {
                let at = [(x / vw + 0.5) * width, (0.5 - y / vh) * height];
                Some(Projected { at, scale: width / vw }).filter(|_| is_ahead)
            }
            ProjectedLens::Curved(rays) => {
                let distance = away.length();
                let toward = DVec3::new(x, -y, depth) / distance;
                let at = rays.point(toward).filter(|_| distance > 0.0)?;
                Some(Projected { at, scale: rays.scale(toward) / distance })
            }
        }
    }

    /// Origin and direction of the viewing ray through a point of the image, columns and rows from its upper left corner, in f64 arithmetic. The
    /// direction has any length. `None` where a curved lens has no ray.
    #[must_use]
    pub fn ray(&self, [column, row]: [f64; 2]) -> Option<[DVec3; 2]> {
        let Basis { e, u, v, w } = self.basis;
        match self.lens {
            ProjectedLens::Pixels(Intrinsics { fx, fy, cx, cy }) => {
                Some([e, (column - cx) / fx * u - (row - cy) / fy * v - w])
            }
            ProjectedLens::Parallel { view: [vw, vh], image: [width, height] } => {
                Some([e + (column / width - 0.5) * vw * u + (0.5 - row / height) * vh * v, -w])
            }
            ProjectedLens::Curved(rays) => {
                let DVec3 { x, y, z } = rays.direction([column, row])?;
                Some([e, self.basis.to_world([x, -y, -z])])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::Judge;
    use crate::frame::Aov;
    use crate::render::Renderer;
    use crate::scene::camera::{Curve, Lens, Look};
    use crate::scene::{ImagePlane, Scene, Spheres};
    use crate::settings::{Backend, Settings};
    use crate::testing::Rng;

    /// A small sphere is hit by the ray of the pixel that it is projected into, and by none of its neighbours but one.
    #[test]
    fn a_sphere_is_where_its_centre_is_projected() {
        let lenses = [
            Lens::Vfov { degrees: 50.0, distance: 1.0 },
            Lens::Orthographic { height: 9.0 },
            Lens::Intrinsics { fx: 70.0, fy: 60.0, cx: 21.5, cy: 33.0 },
        ];
        for lens in lenses {
            let camera = Camera { eye: DVec3::new(1.0, 2.0, 9.0), look: Look::At(DVec3::ZERO), up: DVec3::Y, lens };
            for (n, center) in [[0.0, 0.0, 0.0], [0.7, -0.4, 1.2], [-1.1, 0.8, -2.0]].into_iter().enumerate() {
                let Projected { at: [x, y], scale } =
                    camera.project([64, 48], center.into()).expect("a camera").expect("in front");
                let mut spheres = Spheres::default();
                // Of a diameter of 1.2 pixels: the ray of the pixel's middle meets it if it is within 0.6.
                spheres.push(center, 0.6 / scale, None);
                let image = ImagePlane { width: 64, height: 48, ..ImagePlane::default() };
                let judge =
                    Judge::new(&Scene { camera, image, spheres, lighting: Default::default() }).expect("a scene");
                let [row, column] = [y, x].map(|place| place.floor() as u32);
                let away = (x - f64::from(column) - 0.5).hypot(y - f64::from(row) - 0.5);
                let hit = judge.pixel(row, column).is_some();
                // Pixels of the third lens are not square.
                assert!(hit || away > 0.5, "{lens:?} {n}: {x} {y}");
                assert!(
                    judge.pixel(row + 3, column).is_none() && judge.pixel(row, column - 3).is_none(),
                    "{lens:?} {n}"
                );
            }
            assert_eq!(camera.project([64, 48], DVec3::new(1.0, 2.0, 20.0)).expect("a camera"), None);
        }
    }

    /// Each small sphere is seen in the pixel that it is projected into by the lens itself, and points that no ray sees have no place.
    #[test]
    fn a_curved_lens_shows_a_sphere_where_its_centre_is_projected() {
        let (fx, fy, cx, cy) = (30.0, 31.0, 33.5, 22.25);
        let bent = Curve::Distorted { k: [-0.2, 0.04, 0.001, 0.0, 0.0, 0.0], p: [0.003, -0.002] };
        let folded = Curve::Distorted { k: [-0.35, 0.0, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] };
        let fisheye = Curve::Fisheye { k: [0.05, -0.01, 0.0, 0.0] };
        let settings = Settings { backend: Backend::Cpu, aovs: vec![Aov::Id], ..Settings::default() };
        let mut renderer = Renderer::new(&settings).expect("the CPU path");
        let mut rng = Rng(0xca11);
        for curve in [bent, folded, fisheye, Curve::Panorama] {
            let lens = Lens::Curved { curve, fx, fy, cx, cy };
            let camera = Camera { eye: DVec3::new(1.0, 2.0, 9.0), look: Look::At(DVec3::ZERO), up: DVec3::Y, lens };
            let projector = camera.projector([64, 48]).expect("a camera");
            let (mut shown, mut without) = (0, 0);
            for _ in 0..120 {
                let away = DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 0.4));
                let center = camera.eye + away.normalize() * rng.between(3.0, 9.0);
                let Some(Projected { at: [x, y], scale }) = projector.place(center) else {
                    without += 1;
                    continue;
                };
                assert_eq!(camera.project([64, 48], center).expect("a camera"), projector.place(center));
                if !(0.0..64.0).contains(&x) || !(0.0..48.0).contains(&y) || scale == 0.0 {
                    continue;
                }
                let mut spheres = Spheres::default();
                // Pixels of these lenses are up to three times as long as wide.
                spheres.push(center.to_array(), 1.7 / scale, None);
                let image = ImagePlane { width: 64, height: 48, ..ImagePlane::default() };
                let scene = Scene { camera, image, spheres, lighting: Default::default() };
                let frame = renderer.render(&scene, &settings).expect("a frame");
                let [row, column] = [y, x].map(|place| place.floor() as usize);
                let hits: Vec<usize> = (0..64 * 48).filter(|n| frame.ids()[*n] >= 0).collect();
                // At a pole of the panorama, and where a fisheye looks back, a sphere covers many pixels.
                let is_wide = hits.len() > 60;
                // Toward a fold discs become narrower than a pixel.
                let is_next = |n: &usize| (n / 64).abs_diff(row) <= 1 && (n % 64).abs_diff(column) <= 1;
                let is_there = frame.ids()[64 * row + column] == 0 || curve == folded && hits.iter().any(is_next);
                assert!(is_there, "{curve:?} {center}: {x} {y} {scale} {hits:?}");
                let is_near = |n: &usize| (n / 64).abs_diff(row) <= 6 && (n % 64).abs_diff(column) <= 12;
                assert!(
                    is_wide || hits.iter().all(is_near) || curve == Curve::Panorama,
                    "{curve:?} {center}: {hits:?}"
                );
                shown += 1;
            }
            assert!(shown > 25, "{curve:?}: {shown}");
            // A panorama has all directions, and a plane those ahead, as far as its model does not fold.
            assert!(curve != Curve::Panorama || without == 0, "{curve:?}: {without}");
            assert!(curve != folded || without > 40, "{curve:?}: {without}");
            assert_eq!(projector.place(camera.eye), None);
        }
    }
}
