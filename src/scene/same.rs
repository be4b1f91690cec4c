//! Identity of a scene's spheres between frames, without reading them.

use super::Spheres;
use super::list::List;

/// The identity of the positions and radii of some spheres.
pub(crate) struct SameSpheres {
    /// The lists themselves where no one can change them; otherwise the frame in which they were read, and their
    /// addresses.
    kept: Option<(List<[f64; 3]>, List<f64>)>,
    read: (u64, [usize; 2]),
    count: usize,
}

impl SameSpheres {
    /// The identity of these spheres. Lists that others may change count as unchanged only within one number `frame`.
    pub(crate) fn of(spheres: &Spheres, frame: u64) -> Self {
        let kept = spheres.centers.kept().zip(spheres.radii.kept());
        Self { kept, read: (frame, addresses(spheres)), count: spheres.len() }
    }

    /// Whether no one can change the spheres, so that any frame and any renderer may compare them.
    pub(crate) fn is_kept(&self) -> bool {
        self.kept.is_some()
    }

    /// Whether these are the same spheres.
    pub(crate) fn is_of(&self, spheres: &Spheres, frame: u64) -> bool {
        self.count == spheres.len()
            && match &self.kept {
                Some((centers, radii)) => centers.is_same(&spheres.centers) && radii.is_same(&spheres.radii),
                None => self.read == (frame, addresses(spheres)),
            }
    }
}

fn addresses(spheres: &Spheres) -> [usize; 2] {
    [spheres.centers.as_ptr() as usize, spheres.radii.as_ptr() as usize]
}
