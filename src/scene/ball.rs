//! One sphere as numbers.

use super::Spheres;

/// Centre and radius of a sphere, as the scene states them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ball {
    pub(crate) center: [f64; 3],
    pub(crate) radius: f64,
}

/// A sphere of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NumberedBall {
    /// Index in the scene's order.
    pub(crate) id: u32,
    pub(crate) ball: Ball,
}

impl NumberedBall {
    /// The sphere of this index, from the centres and radii of all.
    #[inline(always)]
    pub(crate) fn of(centers: &[[f64; 3]], radii: &[f64], index: usize) -> Self {
        Self { id: index as u32, ball: Ball { center: centers[index], radius: radii[index] } }
    }
}

impl From<[f64; 4]> for Ball {
    /// Centre, and behind it the radius.
    #[inline(always)]
    fn from([x, y, z, radius]: [f64; 4]) -> Self {
        Self { center: [x, y, z], radius }
    }
}

impl Spheres {
    /// The sphere of this index.
    #[inline(always)]
    pub(crate) fn ball(&self, id: u32) -> Ball {
        Ball { center: self.centers[id as usize], radius: self.radii[id as usize] }
    }
}
