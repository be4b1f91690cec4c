//! The hash of a file's samples, stored in its provenance to detect corrupted or edited files.

use super::rows::{Head, Rows, malformed};
use halfline::error::Result;
use halfline::frame::provenance::Provenance;
use halfline::parallel;

/// BLAKE3 of each layer's samples in the order of [`Rows`] and of each manifest, and of these hashes: 32 hexadecimal digits.
pub(super) struct Digest(Vec<blake3::Hasher>);

impl Digest {
    /// The digest of a file before its samples.
    pub(super) fn new(head: &Head) -> Self {
        let mut all = vec![blake3::Hasher::new(); head.layers()];
        let attributes = head.mattes.iter().map(|matte| matte.attributes());
        all.extend(attributes.map(|attributes| {
            let mut hash = blake3::Hasher::new();
            attributes.iter().for_each(|(_, text)| _ = hash.update(text.as_bytes()));
            hash
        }));
        Self(all)
    }

    /// The digest of all rows.
    pub(super) fn of(head: &Head, rows: &mut dyn Rows) -> Result<Self> {
        let mut digest = Self::new(head);
        for band in head.bands() {
            for layer in 0..head.layers() {
                digest.update(layer, &rows.rows(layer, band.clone())?);
            }
        }
        Ok(digest)
    }

    /// Adds the next samples of a layer.
    pub(super) fn update(&mut self, layer: usize, samples: &[u8]) {
        // Below this size, threads make BLAKE3 slower, as its documentation says.
        const MANY: usize = 1 << 17;
        if samples.len() < MANY {
            self.0[layer].update(samples);
        } else {
            parallel::hash(&mut self.0[layer], samples);
        }
    }

    /// The digest as text.
    pub(super) fn text(&self) -> String {
        let mut all = blake3::Hasher::new();
        self.0.iter().for_each(|layer| _ = all.update(layer.finalize().as_bytes()));
        all.finalize().to_hex()[..32].to_owned()
    }

    /// Compares samples with the hash in `provenance`, if there is one.
    pub(super) fn check(&self, provenance: &Provenance, name: &str) -> Result<()> {
        match provenance.pixels() {
            Some(pixels) if pixels != self.text() => Err(malformed(
                name,
                "file",
                "its pixels do not match their hash: the file was changed or cut after it was written",
            )),
            _ => Ok(()),
        }
    }
}
