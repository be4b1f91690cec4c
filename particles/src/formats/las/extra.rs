//! The fields of a point behind the fields of its format; a record of the header describes them (LAS Specification 1.4, Extra Bytes).

use crate::npy::header::Scalar;
use halfline_ground::quote::{count, quote};
use std::cell::Cell;

/// The user and the number of that record.
pub(super) const USER: &[u8] = b"LASF_Spec\0";
pub(super) const RECORD: u16 = 4;

/// A number of an extra field.
pub(super) struct ExtraField {
    pub(super) name: String,
    /// Its first byte in a point.
    at: usize,
    scalar: Scalar,
    scale: f64,
    offset: f64,
    /// The bytes of a number that is none, and the number of points that have it.
    no_data: Option<[u8; 8]>,
    missing: Cell<u64>,
}

/// Bytes of a description.
const LENGTH: usize = 192;

/// The types from 1 on; from 11 on they are two of these, and from 21 on three.
const TYPES: [&str; 10] = ["|u1", "|i1", "<u2", "<i2", "<u4", "<i4", "<u8", "<i8", "<f4", "<f8"];

/// Options that say that a number means none, and that a scale and an offset apply.
const NO_DATA: u8 = 1;
const SCALED: u8 = 1 << 3;
const MOVED: u8 = 1 << 4;

impl ExtraField {
    /// Its number in a point; NaN where it has none.
    pub(super) fn number(&self, record: &[u8]) -> f64 {
        let bytes = &record[self.at..self.at + self.scalar.size()];
        if self.is_none(bytes) {
            self.missing.set(self.missing.get() + 1);
            return f64::NAN;
        }
        self.scalar.number(bytes) * self.scale + self.offset
    }

    /// Whether a number is the one that means none. The specification widens it to 8 bytes, which leaves the first bytes of an
    /// integer; some writers leave the first bytes of a float too.
    fn is_none(&self, bytes: &[u8]) -> bool {
        let Some(none) = self.no_data else { return false };
        match (self.scalar.is_whole(), bytes.len()) {
            (false, 4) if none[..4] != [0; 4] && none[4..] == [0; 4] => none[..4] == *bytes,
            (false, _) => self.scalar.number(bytes) == f64::from_le_bytes(none),
            (true, size) => none[..size] == *bytes,
        }
    }

    /// The warning about points without a number; `None` where each has one.
    pub(super) fn warning(&self) -> Option<String> {
        let points = Some(self.missing.get()).filter(|points| *points > 0)?;
        let have = if points == 1 { "has" } else { "have" };
        Some(format!(
            "{} {have} no {}: the file says which number of this field means none",
            count(points, "point"),
            quote(&self.name)
        ))
    }
}

/// The fields of points of `record` bytes, behind the `format` bytes of their format. What the record describes beyond a point is
/// left out.
pub(super) fn fields(descriptions: &[u8], format: usize, record: usize) -> Vec<ExtraField> {
    let (mut fields, mut at) = (Vec::new(), format);
    for description in descriptions.chunks_exact(LENGTH) {
        let (kind, options) = (usize::from(description[2]), description[3]);
        let number = |first: usize, part: usize| {
            let bytes = description[first + 8 * part..].first_chunk().copied().unwrap_or_default();
            Some(f64::from_le_bytes(bytes)).filter(|number| number.is_finite())
        };
        let scalar = kind.checked_sub(1).and_then(|kind| Scalar::of_numpy(TYPES.get(kind % TYPES.len())?));
        let Some(scalar) = scalar.filter(|_| kind <= 3 * TYPES.len()) else {
            // Bytes without a meaning, whose number is in place of the options.
            at += usize::from(options);
            continue;
        };
        let name = description[4..36].split(|byte| *byte == 0).next().unwrap_or_default();
        let name = String::from_utf8_lossy(name).trim().to_owned();
        let parts = 1 + (kind - 1) / TYPES.len();
        for part in 0..parts {
            if at + scalar.size() > record {
                return fields;
            }
            let name = if parts == 1 { name.clone() } else { format!("{name}_{part}") };
            let scale = number(112, part).filter(|_| options & SCALED > 0).unwrap_or(1.0);
            let offset = number(136, part).filter(|_| options & MOVED > 0).unwrap_or(0.0);
            let no_data = description[40 + 8 * part..].first_chunk().copied().filter(|_| options & NO_DATA > 0);
            if !name.is_empty() {
                fields.push(ExtraField { name, at, scalar, scale, offset, no_data, missing: Cell::new(0) });
            }
            at += scalar.size();
        }
    }
    fields
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A description with this type and these options, whose number that means none is widened to 8 bytes.
    fn description(kind: u8, options: u8, none: [u8; 8]) -> Vec<u8> {
        let mut bytes = vec![0; LENGTH];
        (bytes[2], bytes[3]) = (kind, options);
        bytes[4..8].copy_from_slice(b"Dist");
        bytes[40..48].copy_from_slice(&none);
        bytes[112..120].copy_from_slice(&0.5f64.to_le_bytes());
        bytes[136..144].copy_from_slice(&10f64.to_le_bytes());
        bytes
    }

    #[test]
    fn a_number_that_means_none_is_none_by_the_bit_of_the_options() {
        let narrow = |bytes: &[u8]| {
            let mut all = [0; 8];
            all[..bytes.len()].copy_from_slice(bytes);
            all
        };
        let (signed, float) = ((-99i64).to_le_bytes(), (-99f64).to_le_bytes());
        // The type, the bytes of -99 or 99 in a point, and its bytes in the description, widened and as they are.
        for (kind, raw, wide) in [
            (1, vec![99], 99u64.to_le_bytes()),
            (2, (-99i8).to_le_bytes().to_vec(), signed),
            (3, 99u16.to_le_bytes().to_vec(), 99u64.to_le_bytes()),
            (4, (-99i16).to_le_bytes().to_vec(), signed),
            (5, 99u32.to_le_bytes().to_vec(), 99u64.to_le_bytes()),
            (6, (-99i32).to_le_bytes().to_vec(), signed),
            (7, u64::MAX.to_le_bytes().to_vec(), u64::MAX.to_le_bytes()),
            (8, (-99i64).to_le_bytes().to_vec(), signed),
            (9, (-99f32).to_le_bytes().to_vec(), float),
            (10, (-99f64).to_le_bytes().to_vec(), float),
        ] {
            for none in [wide, narrow(&raw)] {
                for options in 0..32 {
                    let of = |bytes: &[u8]| {
                        let fields = fields(&description(kind, options, none), 20, 20 + bytes.len());
                        let record = [&[0; 20], bytes].concat();
                        (fields[0].number(&record), fields[0].warning())
                    };
                    let mut other = raw.clone();
                    other[raw.len() - 1] ^= 1;
                    let (number, warning) = of(&raw);
                    let is_none = options & 1 > 0;
                    assert_eq!((number.is_nan(), warning.is_some()), (is_none, is_none), "{kind} {options}");
                    let plain = Scalar::of_numpy(TYPES[usize::from(kind) - 1]).expect("a type").number(&other);
                    let scaled = if options & 8 > 0 { plain * 0.5 } else { plain };
                    let moved = if options & 16 > 0 { scaled + 10.0 } else { scaled };
                    assert_eq!(of(&other), (moved, None), "{kind} {options}");
                }
            }
        }
        let [field] = &fields(&description(1, 1, [7; 8]), 20, 21)[..] else { panic!("one field") };
        let numbers = [7, 7, 8].map(|byte| field.number(&[&[0; 20][..], &[byte]].concat()));
        assert_eq!(numbers.map(f64::is_nan), [true, true, false]);
        assert!(field.warning().is_some_and(|warning| warning.starts_with("2 points have no `Dist`")));
    }
}
