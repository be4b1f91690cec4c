//! First hits of the viewing rays of a view: the output of every engine.

use super::raw::Raw;
use super::settle::Settled;
use crate::kernel::Kernel;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;

/// The first hits of the rays of some pixels.
pub(crate) struct FirstHits {
    /// Ids, and what the kernel computes of hits. Ids and normals are final; depths and colours of settled pixels are not.
    pub(crate) raw: Raw,
    /// The pixels that were decided in exact arithmetic, in their order.
    pub(crate) settled: Vec<Settled>,
}

impl FirstHits {
    /// Room for the hits of so many pixels.
    ///
    /// # Errors
    /// [`crate::Error::Limits`] if the allocation fails.
    pub(crate) fn new(kernel: &Kernel, pixels: usize, pool: &Pool) -> Result<Self> {
        Ok(Self { raw: Raw::new(kernel, pixels, pool)?, settled: Vec::new() })
    }

    /// Takes the answers of these pixels in place of the kernel's.
    pub(crate) fn settle(&mut self, settled: Vec<Settled>) {
        self.raw.settle(&settled);
        self.settled = settled;
    }

    /// The sphere of each pixel; [`NONE`](crate::view::ray::NONE) for a miss. The other memory returns to the pool.
    pub(crate) fn into_ids(mut self, pool: &Pool) -> Vec<u32> {
        let ids = std::mem::take(&mut self.raw.id);
        self.raw.put_back(pool);
        ids
    }
}
