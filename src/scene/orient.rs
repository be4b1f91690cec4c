//! Directions of view: by name, and along the principal axes of points.

use super::camera::{Camera, Look};
use super::source::{SphereSource, middle};
use glam::DVec3;
use halfline_ground::error::{Result, named};

/// A direction of view and the up vector that belongs to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facing {
    /// The direction to look in, of any length but zero.
    pub view: DVec3,
    /// The up direction.
    pub up: DVec3,
}

impl Facing {
    /// Along -z with y up, as molecular viewers show a file.
    pub const FRONT: Self = Self { view: DVec3::NEG_Z, up: DVec3::Y };

    /// Gives a camera this direction.
    pub fn turn(self, camera: &mut Camera) {
        (camera.look, camera.up) = (Look::View(self.view), self.up);
    }
}

/// A direction of view by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NamedView {
    /// Along -z with y up: x to the right.
    Front,
    /// Along z with y up: x to the left.
    Back,
    /// From the side of the least x, along x with y up.
    Left,
    /// From the side of the largest x, along -x with y up.
    Right,
    /// From the side of the largest y, along -y with -z up: x to the right.
    Top,
    /// From the side of the least y, along y with z up: x to the right.
    Bottom,
    /// From the corner of the largest x, y and z, along (-1, -1, -1) with y up.
    Iso,
    /// Along the principal axes, see [`Spread::facing`].
    Auto,
}

named! { NamedView, "view", Front "front" Back "back" Left "left" Right "right" Top "top" Bottom "bottom" Iso "iso" Auto "auto" }

impl NamedView {
    /// The direction; `None` where it depends on the spheres.
    #[must_use]
    pub fn facing(self) -> Option<Facing> {
        let of = |view: DVec3, up: DVec3| Some(Facing { view, up });
        match self {
            Self::Front => Some(Facing::FRONT),
            Self::Back => of(DVec3::Z, DVec3::Y),
            Self::Left => of(DVec3::X, DVec3::Y),
            Self::Right => of(DVec3::NEG_X, DVec3::Y),
            Self::Top => of(DVec3::NEG_Y, DVec3::NEG_Z),
            Self::Bottom => of(DVec3::Y, DVec3::Z),
            Self::Iso => of(DVec3::NEG_ONE, DVec3::Y),
            Self::Auto => None,
        }
    }
}

/// The sums of coordinates and of their products, from which the principal axes follow. Points are added one after the
/// other in their order, so that the sums are the same however they are divided into blocks, and for any number of
/// threads.
#[derive(Debug, Clone, Copy)]
pub struct Spread {
    /// Coordinates are relative to this point, in this unit: squares of no scene overflow or vanish.
    middle: DVec3,
    unit: f64,
    count: f64,
    sum: [f64; 3],
    /// Of x x, y y, z z, x y, x z, y z.
    products: [f64; 6],
}

/// Spreads along two axes whose ratio is above this count as equal: then no direction between them is preferred.
const EQUAL: f64 = 0.95;

/// A spread below this share of the largest is rounding of coordinates on a line or a plane.
const NONE: f64 = 1e-6;

impl Spread {
    /// No points yet, of those whose box has these corners.
    fn about([low, high]: [DVec3; 2]) -> Self {
        let size = (high / 2.0 - low / 2.0).max_element();
        let unit = if size > 0.0 && size.is_finite() { size } else { 1.0 };
        Self { middle: middle([low, high]), unit, count: 0.0, sum: [0.0; 3], products: [0.0; 6] }
    }

    /// The centres of spheres.
    ///
    /// # Errors
    /// As [`SphereSource::each`].
    pub fn of(spheres: &dyn SphereSource) -> Result<Self> {
        let mut spread = Self::about(spheres.ends()?);
        spheres.each(&mut |block| {
            spread.add(&block.centers);
            Ok(())
        })?;
        Ok(spread)
    }

    /// Adds points.
    fn add(&mut self, points: &[[f64; 3]]) {
        for point in points {
            let [x, y, z] = ((DVec3::from_array(*point) - self.middle) / self.unit).to_array();
            self.count += 1.0;
            self.sum.iter_mut().zip([x, y, z]).for_each(|(sum, x)| *sum += x);
            self.products.iter_mut().zip([x * x, y * y, z * z, x * y, x * z, y * z]).for_each(|(sum, xy)| *sum += xy);
        }
    }

    /// The direction that shows the largest face: the axis of least spread points to the eye, and the axis of the largest
    /// lies across the image, or upright where `is_tall`.
    ///
    /// Axes whose spreads differ by less than 5 % are not distinguished. Of three such axes (a capsid) the view is
    /// [`Facing::FRONT`]; of two (a disc, a rod) the file's x, or its z for a rod, turns them. Both signs of an axis are
    /// equal, so the component of largest size, or the first within 1 % of it, is made positive.
    #[must_use]
    pub fn facing(&self, is_tall: bool) -> Facing {
        let (spreads, [long, _, short]) = self.axes();
        let near = |a: usize, b: usize| spreads[b] >= EQUAL * spreads[a];
        let (across, back) = match (near(0, 1), near(1, 2)) {
            (true, true) => return Facing::FRONT,
            (true, false) => (in_plane(short, DVec3::X, DVec3::Y), signed(short)),
            (false, true) => (signed(long), in_plane(long, DVec3::Z, DVec3::Y)),
            (false, false) => (signed(long), signed(short)),
        };
        let up = if is_tall { across } else { back.cross(across) };
        Facing { view: -back, up }
    }

    /// The standard deviations along the principal axes, the largest first, and the axes.
    fn axes(&self) -> ([f64; 3], [DVec3; 3]) {
        let n = self.count.max(1.0);
        let [x, y, z] = self.sum.map(|sum| sum / n);
        let means = [x * x, y * y, z * z, x * y, x * z, y * z];
        let mut of = self.products;
        of.iter_mut().zip(means).for_each(|(product, means)| *product = *product / n - means);
        let [xx, yy, zz, xy, xz, yz] = of;
        let (variances, axes) = eigen([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| variances[*b].total_cmp(&variances[*a]));
        let spreads = order.map(|k| variances[k].max(0.0).sqrt());
        (spreads.map(|spread| if spread < NONE * spreads[0] { 0.0 } else { spread }), order.map(|k| axes[k]))
    }
}

/// The unit vector perpendicular to `normal` that is nearest to `like`, or to `other` where `like` is almost parallel.
fn in_plane(normal: DVec3, like: DVec3, other: DVec3) -> DVec3 {
    let like = if normal.dot(like).abs() > 0.9 { other } else { like };
    (like - normal.dot(like) * normal).normalize()
}

/// The axis or its negative.
fn signed(axis: DVec3) -> DVec3 {
    let parts = axis.to_array();
    let largest = parts.iter().fold(0.0, |largest: f64, part| largest.max(part.abs()));
    let first = parts.iter().find(|part| part.abs() >= 0.99 * largest);
    if first.is_some_and(|part| *part < 0.0) { -axis } else { axis }
}

/// The eigenvalues and the unit eigenvectors of a symmetric matrix, by Jacobi's rotations (Golub and Van Loan, Matrix
/// Computations, 4th edition, section 8.5). Square roots and quotients only, which round alike on every machine.
fn eigen(mut matrix: [[f64; 3]; 3]) -> ([f64; 3], [DVec3; 3]) {
    let mut axes = [DVec3::X, DVec3::Y, DVec3::Z];
    // Convergence is quadratic: a few sweeps reach the last digit.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = matrix[p][q];
            if off == 0.0 {
                continue;
            }
            let tau = (matrix[q][q] - matrix[p][p]) / (2.0 * off);
            let tangent = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
            let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
            let sine = tangent * cosine;
            let rotated = |a: f64, b: f64| (cosine * a - sine * b, sine * a + cosine * b);
            for row in &mut matrix {
                (row[p], row[q]) = rotated(row[p], row[q]);
            }
            for (column, (a, b)) in matrix[p].into_iter().zip(matrix[q]).enumerate() {
                (matrix[p][column], matrix[q][column]) = rotated(a, b);
            }
            (axes[p], axes[q]) = (cosine * axes[p] - sine * axes[q], sine * axes[p] + cosine * axes[q]);
        }
    }
    ([0, 1, 2].map(|k| matrix[k][k]), axes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Spheres;
    use glam::DQuat;

    /// Points at both ends of three axes of these half lengths, turned.
    fn cross(lengths: [f64; 3], turn: DQuat) -> Spread {
        let ends = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip(lengths);
        let points = ends.flat_map(|(axis, length)| [turn * axis * length, turn * -axis * length]);
        let mut spheres = Spheres::default();
        points.for_each(|point| spheres.push((point + DVec3::new(5.0, -7.0, 11.0)).to_array(), 1.0, None));
        Spread::of(&spheres).expect("in memory")
    }

    fn close(a: DVec3, b: DVec3) -> bool {
        // Some roundings of coordinates up to 14.
        (a - b).length() < 1e-13
    }

    #[test]
    fn the_largest_face_is_shown_with_the_longest_axis_across() {
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, 0.2, -0.4));
        let facing = cross([3.0, 2.0, 1.0], turn).facing(false);
        assert!(close(facing.view, turn * DVec3::NEG_Z) && close(facing.up, turn * DVec3::Y), "{facing:?}");
        let facing = cross([3.0, 2.0, 1.0], turn).facing(true);
        assert!(close(facing.view, turn * DVec3::NEG_Z) && close(facing.up, turn * DVec3::X), "{facing:?}");
        // A molecule that lies on its side in the file.
        let facing = cross([1.0, 3.0, 2.0], DQuat::IDENTITY).facing(false);
        assert!(close(facing.view, DVec3::NEG_X) && close(facing.up, DVec3::X.cross(DVec3::Y)), "{facing:?}");
    }

    #[test]
    fn what_is_alike_from_several_sides_is_shown_as_the_file_has_it() {
        for turn in [DQuat::IDENTITY, DQuat::from_scaled_axis(DVec3::new(0.3, 0.2, -0.4))] {
            // 1.04 is less than 5 % more; a cube, an icosahedron and one atom have no axes at all.
            for alike in [[1.0; 3], [1.0, 1.04, 1.0], [0.0; 3]] {
                assert_eq!(cross(alike, turn).facing(false), Facing::FRONT, "{alike:?}");
            }
            let disc = cross([1.0, 2.0, 2.0], turn).facing(false);
            assert!(close(disc.view, turn * DVec3::NEG_X), "{disc:?}");
            let rod = cross([3.0, 1.0, 1.0], turn).facing(false);
            let across = rod.view.cross(rod.up);
            assert!(close(across, turn * DVec3::X) && rod.view.z < -0.9, "{rod:?}");
        }
        // A line has one axis, in whichever direction its rounding errors lie.
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, 0.2, -0.4));
        let line = cross([3.0, 0.0, 0.0], turn).facing(false);
        assert!(close(line.view.cross(line.up), turn * DVec3::X) && line.view.z < -0.9, "{line:?}");
    }

    #[test]
    fn sums_are_the_same_in_blocks_and_at_any_scale() {
        let points: Vec<[f64; 3]> =
            (0..1000).map(|n| [7, 11, 13].map(|k| f64::from(n * k % 101) / [1.0, 3.0, 9.0][k as usize % 3])).collect();
        let of = |scale: f64, blocks: usize| {
            let points: Vec<[f64; 3]> = points.iter().map(|point| point.map(|x| x * scale)).collect();
            let ends = points.iter().map(|point| DVec3::from_array(*point));
            let low = ends.clone().fold(DVec3::INFINITY, DVec3::min);
            let mut spread = Spread::about([low, ends.fold(DVec3::NEG_INFINITY, DVec3::max)]);
            points.chunks(blocks).for_each(|block| spread.add(block));
            spread.facing(false)
        };
        let whole = of(1.0, 1000);
        assert_ne!(whole, Facing::FRONT);
        // Powers of two scale without rounding.
        let huge = [1e-300_f64, 1e300].map(|scale| 2f64.powi(scale.log2() as i32));
        for (scale, blocks) in [(1.0, 1), (1.0, 7), (huge[0], 1000), (huge[1], 64)] {
            assert_eq!(of(scale, blocks), whole, "{scale} {blocks}");
        }
    }

    #[test]
    fn named_views_have_a_picture_of_their_own() {
        for view in NamedView::ALL {
            assert_eq!(view.name().parse::<NamedView>().expect("a name"), view);
            let Some(Facing { view, up }) = view.facing() else { continue };
            let camera = Camera { look: Look::View(view), up, ..Camera::CANONICAL };
            camera.basis().expect("a basis");
        }
        let right = |view: NamedView| {
            let Facing { view, up } = view.facing().expect("fixed");
            Camera { look: Look::View(view), up, ..Camera::CANONICAL }.basis().expect("a basis").u
        };
        let found = [NamedView::Front, NamedView::Back, NamedView::Left, NamedView::Right].map(right);
        assert_eq!(found, [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z]);
        assert_eq!([NamedView::Top, NamedView::Bottom].map(right), [DVec3::X; 2]);
    }
}
