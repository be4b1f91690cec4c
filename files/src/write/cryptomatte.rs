//! Cryptomatte layers in a file, by the specification 1.2.0 of Friedman and Jones (Psyop): the hash of an object's name is its id,
//! stored as the bits of a float.

use halfline::frame::provenance::Provenance;
use std::collections::BTreeMap;

/// Objects of a pixel that a file holds, as the specification suggests.
pub(super) const RANKS: usize = 6;

/// Samples of a pixel: id and coverage of each rank.
pub(super) const CHANNELS: usize = 2 * RANKS;

/// The keyword of the layers and the digests of their names.
pub(super) const LAYERS: &str = "halfline:cryptomatte";

/// The facts about a layer in the header of its file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MatteHead {
    /// Its name.
    pub layer: String,
    /// The names of the objects that the file shows, and their ids in 8 hexadecimal digits.
    pub manifest: BTreeMap<String, String>,
}

impl MatteHead {
    /// The names and values of its attributes, whose key is the hash of the layer's name.
    pub(super) fn attributes(&self) -> [(String, String); 4] {
        let manifest = serde_json::to_string(&self.manifest).unwrap_or_default();
        let of = |field: &str, value: &str| (attribute(&self.layer, field), value.to_owned());
        [
            of("name", &self.layer),
            of("hash", "MurmurHash3_32"),
            of("conversion", "uint32_to_float32"),
            of("manifest", &manifest),
        ]
    }

    /// The layers of a file with this provenance; `manifest` gives the text of an attribute. `None` for a text that is no manifest.
    pub(super) fn all(provenance: &Provenance, manifest: impl Fn(&str) -> Option<String>) -> Option<Vec<Self>> {
        let Some(layers) = provenance.get(LAYERS) else { return Some(Vec::new()) };
        let of = |layer: &str| {
            let name = layer.split_once('=').map(|(name, _)| name.to_owned());
            let layer = name.filter(|name| name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_'))?;
            let manifest = serde_json::from_str(&manifest(&attribute(&layer, "manifest"))?).ok()?;
            Some(Self { layer, manifest })
        };
        layers.split(',').map(of).collect()
    }

    /// The layers of a frame whose tiles have these, as many each: with the objects of all tiles.
    pub(super) fn joined<'a>(tiles: impl Iterator<Item = &'a [Self]>) -> Vec<Self> {
        let mut joined: Vec<Self> = Vec::new();
        for mattes in tiles {
            joined.iter_mut().zip(mattes).for_each(|(all, own)| all.manifest.extend(own.manifest.clone()));
            joined.extend(mattes.iter().skip(joined.len()).cloned());
        }
        joined
    }

    /// The names of its channels: id and coverage of each rank.
    pub(super) fn channels(&self) -> impl Iterator<Item = String> {
        (0..CHANNELS).map(|n| format!("{}{:02}.{}", self.layer, n / 4, ["R", "G", "B", "A"][n % 4]))
    }
}

/// The name of an attribute: at most 31 letters, so that every reader of EXR takes it.
fn attribute(layer: &str, field: &str) -> String {
    format!("cryptomatte/{}/{field}", &hexadecimal(id_of(layer))[..7])
}

/// The id of a name: its MurmurHash3_x86_32, with another lowest bit of the exponent where the float would be subnormal, infinite
/// or NaN.
pub(super) fn id_of(name: &str) -> u32 {
    let hash = mur3::murmurhash3_x86_32(name.as_bytes(), 0);
    let exponent = hash >> 23 & 0xff;
    if exponent == 0 || exponent == 0xff { hash ^ 1 << 23 } else { hash }
}

pub(super) fn hexadecimal(id: u32) -> String {
    format!("{id:08x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The manifest of the specification, and values of the package mmh3 for Python, the last four with another exponent.
    #[test]
    fn ids_are_those_of_other_programs() {
        for (name, id) in [
            ("bunny", 0x1385_1a76),
            ("default", 0x42c9_679f),
            ("454", 0xff3f_fb25),
            ("796", 0x80af_dfe2),
            ("1847", 0x7f63_4a1c),
            ("", 0x0080_0000),
        ] {
            assert_eq!(id_of(name), id, "{name}");
            assert!(f32::from_bits(id).is_normal(), "{name}");
        }
        assert_eq!(attribute("CryptoObject", "conversion"), "cryptomatte/3ae39a5/conversion");
    }
}
