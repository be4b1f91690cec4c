//! The hash of a file's samples, which its provenance holds: a number that a disk or a program changed is noticed.

use super::provenance::Provenance;
use super::sheet::{Head, Rows, malformed};
use crate::error::Result;

/// BLAKE3 of each buffer's samples in the order of [`Rows`], and of these hashes: 32 hexadecimal digits.
pub(super) struct Digest(Vec<blake3::Hasher>);

impl Digest {
    /// Of so many buffers.
    pub(super) fn new(layers: usize) -> Self {
        Self(vec![blake3::Hasher::new(); layers])
    }

    /// Of all rows.
    pub(super) fn of(head: &Head, rows: &mut dyn Rows) -> Result<Self> {
        let mut digest = Self::new(head.forms.len());
        for band in head.bands() {
            for layer in 0..head.forms.len() {
                digest.update(layer, &rows.rows(layer, band.clone())?);
            }
        }
        Ok(digest)
    }

    /// The next samples of a buffer.
    pub(super) fn update(&mut self, layer: usize, samples: &[u8]) {
        // Below this, says BLAKE3, threads only cost.
        const MANY: usize = 1 << 17;
        if samples.len() < MANY {
            self.0[layer].update(samples);
        } else {
            self.0[layer].update_rayon(samples);
        }
    }

    /// As it is written.
    pub(super) fn text(&self) -> String {
        let mut all = blake3::Hasher::new();
        self.0.iter().for_each(|layer| _ = all.update(layer.finalize().as_bytes()));
        all.finalize().to_hex()[..32].to_owned()
    }

    /// Refuses samples that are not those of which `provenance` has the hash. Without a hash nothing is known.
    pub(super) fn check(&self, provenance: &Provenance, name: &str) -> Result<()> {
        match provenance.pixels() {
            Some(pixels) if pixels != self.text() => Err(malformed(
                name,
                "file",
                "its pixels were changed after it was written, or cut: their hash is another",
            )),
            _ => Ok(()),
        }
    }
}
