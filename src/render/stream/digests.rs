//! The fingerprint of all spheres of a stream, most of them forgotten: it equals the fingerprint of the same spheres in memory.

use super::pieces::{Differing, Pieces};
use crate::scene::Spheres;
use blake3::Hash;
use bytemuck::NoUninit;
use serde::{Deserialize, Serialize};

/// The most spheres that have a fingerprint: the place of the last byte fits into 60 bits.
pub(super) const MAX_SPHERES: u64 = 1 << 55;

/// Digests of the numbers of all spheres, by their ids.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Digests {
    centers: Pieces,
    radii: Pieces,
    colors: Pieces,
    #[serde(default, skip_serializing_if = "Pieces::is_empty")]
    opacities: Pieces,
}

impl Digests {
    /// Adds spheres whose first has the id `first`.
    pub(super) fn add(&mut self, first: u64, block: &Spheres) -> Result<(), Differing> {
        add(&mut self.centers, first, &block.centers)?;
        add(&mut self.radii, first, &block.radii)?;
        block.colors.as_ref().map_or(Ok(()), |colors| add(&mut self.colors, first, colors))?;
        block.opacities.as_ref().map_or(Ok(()), |opacities| add(&mut self.opacities, first, opacities))
    }

    /// Adds bytes that stand for the centres, from place `at` on.
    pub(super) fn describe(&mut self, at: u64, bytes: &[u8]) {
        // Every place is added once.
        let _ = self.centers.add(at, bytes);
    }

    /// Adds what others know.
    pub(super) fn join(&mut self, other: &Self) -> Result<(), Differing> {
        self.centers.join(&other.centers)?;
        self.radii.join(&other.radii)?;
        self.colors.join(&other.colors)?;
        self.opacities.join(&other.opacities)
    }

    /// The intervals of ids whose spheres were added, in order.
    pub(super) fn ids(&self) -> Vec<[u64; 2]> {
        self.radii.known().into_iter().map(|ends| ends.map(|byte| byte / size_of::<f64>() as u64)).collect()
    }

    /// The digests of all centres, radii, colours and opacities; of what is known of them where spheres are missing.
    pub(super) fn all(&self) -> [Hash; 4] {
        [&self.centers, &self.radii, &self.colors, &self.opacities]
            .map(|list| list.whole().unwrap_or_else(|| list.of_parts()))
    }
}

fn add<T: NoUninit>(pieces: &mut Pieces, first: u64, values: &[T]) -> Result<(), Differing> {
    pieces.add(first * size_of::<T>() as u64, bytemuck::cast_slice(values))
}
