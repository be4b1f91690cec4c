//! The bytes of a layer.

use super::arithmetic::{INVALID, Source};
use crate::particles::bytes::DAMAGED;
use halfline_ground::error::{Error, Place, Result};

/// The bytes of a layer.
pub(super) struct Layer {
    bytes: Vec<u8>,
    at: usize,
    place: Place,
}

impl Layer {
    /// These bytes, which are at a place.
    pub(super) fn new(bytes: Vec<u8>, place: Place) -> Self {
        Self { bytes, at: 0, place }
    }
}

impl Source for Layer {
    fn byte(&mut self) -> Result<u8> {
        let byte = self.bytes.get(self.at).copied();
        self.at += 1;
        byte.ok_or_else(|| Error::scene(self.place.clone(), "the layer ends within the points of its chunk", DAMAGED))
    }

    fn invalid(&self) -> Error {
        Error::scene(self.place.clone(), INVALID, DAMAGED)
    }
}
