//! Cameras for some spheres of a scene: an eye outside of every sphere, in the direction from which the others hide
//! them least.

use super::camera::{Camera, Viewport};
use super::{CutPlane, Facing, Framing, ImagePlane, Spheres, Spread};
use glam::DVec3;
use halfline_ground::error::Result;
use halfline_ground::parallel::{self, CHEAP};
use halfline_ground::quote::setting::{CLIP, CUT_AT, FOCUS, HIDE, OPACITY, VIEW};
use std::cmp::Ordering;
use std::collections::HashSet;

/// A camera that shows some spheres of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outlook {
    /// The camera.
    pub camera: Camera,
    /// The share of their picture that no other opaque sphere covers, 0 to 1, estimated on a coarse grid.
    pub visible_share: f64,
    /// The number of squares of the grid in which they are seen.
    area: u32,
}

/// A focus has a warning if less than this share of it is seen.
const HIDDEN: f64 = 0.5;

impl Outlook {
    /// A warning where less than half of the spheres is seen; `is_best` says whether no direction shows more.
    #[must_use]
    pub fn warning(&self, is_best: bool) -> Option<String> {
        let percent = (100.0 * self.visible_share).round();
        let other = if is_best { String::new() } else { format!(", {VIEW} auto looks from where least is hidden") };
        (self.visible_share < HIDDEN).then(|| {
            format!(
                "{percent} % of {FOCUS} is seen, the rest is behind other spheres; {HIDE}, {CLIP} or {CUT_AT} removes these, in pixels \
                 {OPACITY} shows through them{other}"
            )
        })
    }
}

/// Squares of the grid along the longer side of the image.
const GRID: f64 = 96.0;

/// The eye keeps a tenth of a sphere's radius away from it.
const CLEAR: f64 = 1.1;

/// The factor by which the lens narrows in a step, 2^(1/4), and the most steps: 2^16 in all.
const NARROWER: f64 = 1.189_207_115_002_721;
const STEPS: usize = 64;

/// The direction along the principal axes is taken if it shows this share of what the best one does.
const AS_GOOD: f64 = 0.9;

impl Spheres {
    /// The centres and radii of the spheres whose flag is set, as planes cut them; flags beyond the spheres do not matter.
    #[must_use]
    pub fn part(&self, flags: &[bool]) -> Self {
        let chosen: Vec<usize> = (0..self.len()).filter(|n| flags.get(*n).is_some_and(|flag| *flag)).collect();
        let centers: Vec<[f64; 3]> = chosen.iter().map(|n| self.centers[*n]).collect();
        let radii: Vec<f64> = chosen.iter().map(|n| self.radii[*n]).collect();
        let ids: Vec<u32> = chosen.iter().map(|n| *n as u32).collect();
        let cuts = self.cuts.as_ref().map(|cuts| cuts.chosen(&ids));
        Self { centers: centers.into(), radii: radii.into(), cuts, ..Self::default() }
    }
}

impl Spheres {
    /// This share of the spheres, rounded up: those whose centres are nearest to the median of all centres, axis by axis; of equally near ones
    /// the first. So a few spheres far away do not decide what a camera shows. Without colours.
    #[must_use]
    pub fn central(&self, share: f64) -> Self {
        let mut count = (share * self.len() as f64).ceil().min(self.len() as f64) as usize;
        let median = [0, 1, 2].map(|axis| {
            let mut along = parallel::map(&self.centers, |center| center[axis]);
            let middle = along.len() / 2;
            if along.is_empty() { 0.0 } else { *along.select_nth_unstable_by(middle, f64::total_cmp).1 }
        });
        let from = DVec3::from_array(median);
        let away = parallel::map(&self.centers, |center| (DVec3::from_array(*center) - from).length());
        let mut sorted = away.clone();
        let Some(last) = count.checked_sub(1) else { return self.part(&[]) };
        let most = *sorted.select_nth_unstable_by(last, f64::total_cmp).1;
        count -= away.iter().filter(|length| **length < most).count();
        let is_central = |length: &f64| {
            let is_tie = *length == most && count > 0;
            count -= usize::from(is_tie);
            *length < most || is_tie
        };
        self.part(&away.iter().map(is_central).collect::<Vec<_>>())
    }
}

/// Directions of integers on the faces of a cube, of unit length.
fn directions() -> impl Iterator<Item = DVec3> {
    let steps = || (-2..=2).map(f64::from);
    let all = steps().flat_map(move |x| steps().flat_map(move |y| steps().map(move |z| DVec3::new(x, y, z))));
    all.filter(|at| at.abs().max_element() == 2.0).map(DVec3::normalize)
}

/// A direction of view in which an axis lies across the image, or upright, as far as it is seen.
fn turned(view: DVec3, along: DVec3, is_tall: bool) -> Facing {
    let projected = along - view.dot(along) * view;
    let up = match projected.try_normalize().filter(|_| projected.length() > 0.1) {
        Some(axis) if is_tall => axis,
        Some(axis) => axis.cross(view),
        None if view.y.abs() < 0.9 => DVec3::Y,
        None => DVec3::Z,
    };
    Facing { view, up }
}

/// Some spheres within a scene, in an image.
pub struct Surroundings<'a> {
    image: ImagePlane,
    framing: &'a Framing,
    part: &'a Spheres,
    all: &'a Spheres,
    /// The indices of the scene's spheres that are in the part, and of its opaque ones that are not.
    own: Vec<usize>,
    others: Vec<usize>,
}

fn bits(center: &[f64; 3], radius: f64) -> [u64; 4] {
    let [x, y, z] = center.map(f64::to_bits);
    [x, y, z, radius.to_bits()]
}

impl<'a> Surroundings<'a> {
    /// `part` among `all` the spheres of a scene.
    #[must_use]
    pub fn new(image: ImagePlane, part: &'a Spheres, all: &'a Spheres, framing: &'a Framing) -> Self {
        let own: HashSet<[u64; 4]> = part.centers.iter().zip(&part.radii).map(|(c, r)| bits(c, *r)).collect();
        let is_own = |n: &usize| own.contains(&bits(&all.centers[*n], all.radii[*n]));
        let is_left = |n: &usize| !all.cuts.as_ref().is_some_and(|cuts| cuts.is_removed(*n as u32));
        let (own, others): (Vec<usize>, Vec<usize>) = (0..all.len()).filter(is_left).partition(is_own);
        let others = others.into_iter().filter(|n| all.opacity(*n as u32) == 1.0).collect();
        Self { image, framing, part, all, own, others }
    }

    /// The camera that shows the part from the direction in which most of it is seen, as [`Self::look`]. Candidates are
    /// its largest face from both sides ([`Spread::facing`]), and 98 directions over the sphere. A face is taken if it
    /// shows at least 0.9 of the area that the best direction shows, else the best direction, the first of equals. The
    /// longest axis of the part lies across the image, or upright in a tall one.
    ///
    /// # Errors
    /// As [`Camera::fit`].
    pub fn least_hidden(&self, camera: &Camera) -> Result<Outlook> {
        let spread = Spread::of(self.part)?;
        let is_tall = self.image.height > self.image.width;
        let face = spread.facing(is_tall);
        let back = Facing { view: -face.view, up: face.up };
        let along = if is_tall { face.up } else { face.view.cross(face.up) };
        let others = directions().map(|back| turned(-back, along, is_tall));
        let candidates: Vec<Facing> = [face, back].into_iter().chain(others).collect();
        let look = |n: usize| self.look(candidates[n], camera);
        let found = parallel::try_collect(candidates.len(), 1, &|range| range.map(look).collect::<Result<_>>())?;
        let best = found.iter().map(|outlook| outlook.area).max().unwrap_or(0);
        let good = |outlook: &&Outlook| f64::from(outlook.area) >= AS_GOOD * f64::from(best);
        // The first two by their faces, the others by what they show.
        let first = found.iter().take(2).find(good);
        let best = || found.iter().find(|outlook| outlook.area == best);
        Ok(*first.or_else(best).unwrap_or(&found[0]))
    }

    /// The camera that shows the part from this direction, with the lens of `camera`. If its eye were inside of a sphere of
    /// the scene, the lens is narrowed, and the eye is farther away, until it is not.
    ///
    /// # Errors
    /// As [`Camera::fit`].
    pub fn look(&self, facing: Facing, camera: &Camera) -> Result<Outlook> {
        let ImagePlane { width, height, .. } = self.image;
        let mut start = *camera;
        facing.turn(&mut start);
        let mut found = start;
        found.fit(self.image, self.part, self.framing)?;
        if found.lens.is_orthographic() {
            // Rays start on the plane of the eye, which lies in front of all.
            let back = -facing.view.normalize();
            let front = |spheres: &Spheres| -spheres.least_along(-back, found.eye);
            let extent = front(self.all) - front(self.part);
            found.eye += back * extent.max(0.0);
        } else {
            for _ in 0..STEPS {
                if !self.is_inside(found.eye) {
                    break;
                }
                start.zoom(NARROWER, width, height)?;
                found = start;
                found.fit(self.image, self.part, self.framing)?;
            }
        }
        self.from(found)
    }

    /// Whether planes remove the part.
    #[must_use]
    pub fn is_removed(&self) -> bool {
        self.own.is_empty()
    }

    /// The part as a final camera shows it, as planes cut the scene.
    ///
    /// # Errors
    /// Errors of the camera.
    pub fn from(&self, camera: Camera) -> Result<Outlook> {
        let [area, whole] = self.visible_squares(&camera)?;
        Ok(Outlook { camera, visible_share: f64::from(area) / f64::from(whole.max(1)), area })
    }

    /// Whether a point is inside of a sphere, or almost.
    fn is_inside(&self, eye: DVec3) -> bool {
        let is_near =
            |id: usize| (DVec3::from_array(self.all.centers[id]) - eye).length() <= CLEAR * self.all.radii[id];
        parallel::any(self.all.len(), CHEAP, &|mut ids| ids.any(is_near))
    }

    /// The squares of the grid in which the part is seen, and those in which it would be without the others.
    fn visible_squares(&self, camera: &Camera) -> Result<[u32; 2]> {
        let mut grid = Grid::new(camera, self.image)?;
        for n in &self.own {
            grid.each(self.all, *n, |square, depth| square.nearest = square.nearest.min(depth));
        }
        for n in &self.others {
            grid.each(self.all, *n, |square, depth| square.is_hidden |= depth < square.nearest);
        }
        let own = || grid.squares.iter().filter(|square| square.nearest < f64::INFINITY);
        Ok([own().filter(|square| !square.is_hidden).count() as u32, own().count() as u32])
    }
}

/// A square of the image: the nearest depth of the part, and whether another sphere is before it.
#[derive(Debug, Clone, Copy)]
struct Square {
    nearest: f64,
    is_hidden: bool,
}

/// The image in squares. Spheres cover discs of it, which is exact in its middle.
struct Grid {
    squares: Vec<Square>,
    columns: usize,
    rows: usize,
    eye: DVec3,
    /// Right, up and back.
    axes: [DVec3; 3],
    /// Squares in a unit of length, at distance 1 or at all distances.
    scale: f64,
    is_parallel: bool,
}

impl Grid {
    fn new(camera: &Camera, image: ImagePlane) -> Result<Self> {
        let basis = camera.basis()?;
        let viewport = camera.central_viewport(image.width, image.height)?;
        let Viewport { vw, vh, d } = viewport;
        let side = vw.max(vh) / GRID;
        let [columns, rows] = [vw, vh].map(|length| ((length / side).ceil() as usize).max(1));
        let is_parallel = viewport.is_parallel();
        let scale = if is_parallel { 1.0 / side } else { d / side };
        let squares = vec![Square { nearest: f64::INFINITY, is_hidden: false }; columns * rows];
        Ok(Self { squares, columns, rows, eye: basis.e, axes: [basis.u, basis.v, basis.w], scale, is_parallel })
    }

    /// Visits the squares whose middle a sphere covers, with the depth of its surface there, or of its face on a plane.
    fn each(&mut self, spheres: &Spheres, n: usize, mut visit: impl FnMut(&mut Square, f64)) {
        let planes = spheres.cuts.as_ref().filter(|cuts| cuts.is_cut(n as u32)).map(|cuts| &cuts.planes[..]);
        let (away, radius) = (DVec3::from_array(spheres.centers[n]) - self.eye, spheres.radii[n]);
        let [x, y, z] = self.axes.map(|axis| axis.dot(away));
        let depth = -z;
        if depth <= 0.0 {
            return;
        }
        let scale = if self.is_parallel { self.scale } else { self.scale / depth };
        let half = [self.columns, self.rows].map(|side| side as f64 / 2.0);
        let (x, y, reach) = (half[0] + x * scale, half[1] - y * scale, radius * scale);
        // A square's middle is at its number and a half. Numbers beyond the image become its first or last.
        let ends = |at: f64, side: usize| {
            let first = (at - reach - 0.5).ceil().clamp(0.0, side as f64) as usize;
            first..((at + reach - 0.5).floor() + 1.0).clamp(first as f64, side as f64) as usize
        };
        for row in ends(y, self.rows) {
            for column in ends(x, self.columns) {
                let [dx, dy] = [column as f64 + 0.5 - x, row as f64 + 0.5 - y];
                let inside = 1.0 - (dx * dx + dy * dy) / (reach * reach);
                if inside < 0.0 {
                    continue;
                }
                let ends = [-1.0, 1.0].map(|side| depth + side * radius * inside.sqrt());
                let at = [column as f64 + 0.5 - half[0], half[1] - row as f64 - 0.5].map(|x| x / self.scale);
                if let Some(depth) = planes.map_or(Some(ends[0]), |planes| self.kept(planes, at, ends)) {
                    visit(&mut self.squares[row * self.columns + column], depth);
                }
            }
        }
    }

    /// The first depth between two that planes keep of a ray at this place of the image.
    fn kept(&self, planes: &[CutPlane], [x, y]: [f64; 2], [mut first, mut last]: [f64; 2]) -> Option<f64> {
        let [right, up, back] = self.axes;
        let across = x * right + y * up;
        let (start, direction) = if self.is_parallel { (self.eye + across, -back) } else { (self.eye, across - back) };
        for CutPlane { normal, distance } in planes {
            let normal = DVec3::from_array(*normal);
            let (gap, along) = (distance - normal.dot(start), normal.dot(direction));
            match along.total_cmp(&0.0) {
                Ordering::Less => first = first.max(gap / along),
                _ if along > 0.0 => last = last.min(gap / along),
                _ if gap < 0.0 => return None,
                _ => {}
            }
        }
        (first < last).then_some(first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_of_the_spheres_is_that_near_the_median() {
        let at = |x: f64| [x, 0.0, 1.0];
        let centers: Vec<[f64; 3]> = [0.0, 1.0, -1.0, 50.0, 2.0, -60.0, 1.0].map(at).to_vec();
        let spheres = Spheres {
            radii: (1..8).map(f64::from).collect::<Vec<_>>().into(),
            centers: centers.into(),
            ..Spheres::default()
        };
        // The median is 1; 1, 1, then 0 and 2 at the same distance, then -1, 50, -60.
        for (share, expected) in [
            (1.0, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0][..]),
            (6.0 / 7.0, &[1.0, 2.0, 3.0, 4.0, 5.0, 7.0]),
            (0.6, &[1.0, 2.0, 3.0, 5.0, 7.0]),
            (0.4, &[1.0, 2.0, 7.0]),
            (1e-9, &[2.0]),
        ] {
            assert_eq!(spheres.central(share).radii.to_vec(), expected, "{share}");
        }
        assert!(Spheres::default().central(0.5).is_empty());
    }
}
