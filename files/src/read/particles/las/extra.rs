//! The fields of a point behind those of its format, which a record of the header describes (LAS Specification 1.4, Extra Bytes).

use crate::npy::Scalar;
use halfline::quote::{count, quote};
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
    /// integer; some writers leave those of a float too.
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
