//! The values of a column of BinaryCIF, one after the other: the encodings of the specification, undone in the reverse of their
//! order. Numbers of FixedPoint and IntervalQuantization are computed in f64, whatever type the file had them in before.

use super::values::{field, real, text, whole};
use halfline_ground::quote::quote;
use rmpv::Value;
use std::io::Write as _;

/// A column.
pub(super) struct Column {
    pub(super) name: String,
    values: Values,
    /// 0 for a value, 1 for `.`, 2 for `?`; `None` where all are values.
    mask: Option<Whole>,
}

/// Numbers that are decoded one by one.
type Whole = Box<dyn Iterator<Item = i64> + Send>;
type Real = Box<dyn Iterator<Item = f64> + Send>;

/// Decoded values.
enum Values {
    Whole(Whole),
    Real(Real),
    Texts(Texts),
}

/// Texts by their indices.
struct Texts {
    bytes: Vec<u8>,
    /// The first byte of each text, and the end of the last.
    offsets: Vec<usize>,
    indices: Whole,
}

impl Texts {
    /// Moves past the next text, which is empty where there is none.
    fn next(&mut self) -> Found<&[u8]> {
        let index = self.indices.next().ok_or(FEW)?;
        // A text that is missing has the index -1.
        let Ok(index) = usize::try_from(index) else { return Ok(b"") };
        let range = self.offsets.get(index..index.saturating_add(2)).ok_or("there is no text of its index")?;
        Ok(self.bytes.get(range[0]..range[1]).ok_or("its text is not in stringData")?)
    }
}

/// The problem of a column that ends.
const FEW: &str = "there is no value";

/// A problem of the file.
type Found<T> = Result<T, String>;

/// The most encodings of a column: each takes its numbers from the next one, within the same stack. The specification combines five.
const MOST_ENCODINGS: usize = 16;

impl Column {
    /// The column `{data, mask}` of so many rows.
    pub(super) fn new(name: String, mut column: Value, rows: u64) -> Found<Self> {
        let data = field(&mut column, "data").ok_or("it has no data")?;
        let mask = match field(&mut column, "mask") {
            None | Some(Value::Nil) => None,
            Some(mask) => Some(whole_of(values(mask, rows)?)?),
        };
        Ok(Self { name, values: values(data, rows)?, mask })
    }

    /// Moves past the next value; returns it where it is a finite number. Any other is written.
    pub(super) fn next_number(&mut self, word: &mut Vec<u8>) -> Found<Option<f64>> {
        let number = match &mut self.values {
            Values::Whole(numbers) => numbers.next().ok_or(FEW)? as f64,
            Values::Real(numbers) => numbers.next().ok_or(FEW)?,
            Values::Texts(_) => return self.next(word).map(|()| None),
        };
        if self.is_missing()? {
            return Ok(None);
        }
        if !number.is_finite() {
            drop(write!(word, "{number}"));
        }
        Ok(Some(number).filter(|number| number.is_finite()))
    }

    /// Moves past the next value. It is refused where [`Column::next`] refuses it, so that a file is damaged or not whatever is read of it.
    pub(super) fn pass(&mut self) -> Found<()> {
        let is_there = match &mut self.values {
            Values::Whole(numbers) => numbers.next().is_some(),
            Values::Real(numbers) => numbers.next().is_some(),
            Values::Texts(texts) => {
                texts.next()?;
                true
            }
        };
        if !is_there {
            return Err(FEW.to_owned());
        }
        self.is_missing().map(drop)
    }

    /// Whether the mask says that the value is none.
    fn is_missing(&mut self) -> Found<bool> {
        let Some(mask) = &mut self.mask else { return Ok(false) };
        Ok(mask.next().ok_or("the mask has no value")? != 0)
    }

    /// Writes the next value, nothing where there is none.
    pub(super) fn next(&mut self, word: &mut Vec<u8>) -> Found<()> {
        match &mut self.values {
            Values::Whole(numbers) => drop(write!(word, "{}", numbers.next().ok_or(FEW)?)),
            Values::Real(numbers) => drop(write!(word, "{}", numbers.next().ok_or(FEW)?)),
            Values::Texts(texts) => word.extend(texts.next()?),
        }
        if self.is_missing()? {
            word.clear();
        }
        Ok(())
    }
}

/// The values of `{data, encoding}`; `count` of them are used.
fn values(mut encoded: Value, count: u64) -> Found<Values> {
    let Some(Value::Binary(bytes)) = field(&mut encoded, "data") else { return Err("data has no bytes".to_owned()) };
    decode(bytes, field(&mut encoded, "encoding"), count)
}

/// Undoes the encodings of these bytes, the last one first; `count` of the values are used.
fn decode(bytes: Vec<u8>, encodings: Option<Value>, count: u64) -> Found<Values> {
    let Some(Value::Array(mut encodings)) = encodings else { return Err("there is no array of encodings".to_owned()) };
    if encodings.len() > MOST_ENCODINGS {
        return Err(format!("{} encodings are more than {MOST_ENCODINGS}", encodings.len()));
    }
    let mut last = encodings.pop().ok_or("there is no encoding")?;
    let kind = text(field(&mut last, "kind")).unwrap_or_default();
    let mut found = match &kind[..] {
        "ByteArray" => plain(bytes, whole(&mut last, "type")?)?,
        "StringArray" => texts(bytes, last, count)?,
        _ => return Err(format!("the last encoding is {}", quote(&kind))),
    };
    while let Some(mut encoding) = encodings.pop() {
        let numbers = whole_of(found)?;
        let kind = text(field(&mut encoding, "kind")).unwrap_or_default();
        found = match &kind[..] {
            "FixedPoint" => {
                let factor = real(&mut encoding, "factor")?;
                Values::Real(Box::new(numbers.map(move |number| number as f64 / factor)))
            }
            "IntervalQuantization" => {
                let [low, high] = [real(&mut encoding, "min")?, real(&mut encoding, "max")?];
                let steps = whole(&mut encoding, "numSteps")?.saturating_sub(1) as f64;
                let step = (high - low) / steps;
                Values::Real(Box::new(numbers.map(move |number| low + number as f64 * step)))
            }
            "RunLength" => Values::Whole(runs(numbers, count)),
            "Delta" => {
                let mut sum = whole(&mut encoding, "origin")?;
                Values::Whole(Box::new(numbers.map(move |number| {
                    sum = sum.wrapping_add(number);
                    sum
                })))
            }
            "IntegerPacking" => {
                let is_unsigned = matches!(field(&mut encoding, "isUnsigned"), Some(Value::Boolean(true)));
                Values::Whole(unpacked(numbers, whole(&mut encoding, "byteCount")?, is_unsigned)?)
            }
            _ => return Err(format!("there is no encoding {}", quote(&kind))),
        };
    }
    Ok(found)
}

/// Whole numbers, which all encodings but the first have.
fn whole_of(values: Values) -> Found<Whole> {
    match values {
        Values::Whole(numbers) => Ok(numbers),
        _ => Err("an encoding has other values than whole numbers".to_owned()),
    }
}

/// Numbers of a type, little-endian.
fn plain(bytes: Vec<u8>, kind: i64) -> Found<Values> {
    /// The numbers of `N` bytes each.
    fn each<const N: usize, T>(bytes: Vec<u8>, of: fn([u8; N]) -> T) -> impl Iterator<Item = T> {
        let count = bytes.len() / N;
        (0..count).map(move |k| {
            let mut number = [0; N];
            number.copy_from_slice(&bytes[N * k..N * (k + 1)]);
            of(number)
        })
    }
    Ok(match kind {
        1 => Values::Whole(Box::new(each(bytes, |b| i64::from(i8::from_le_bytes(b))))),
        2 => Values::Whole(Box::new(each(bytes, |b| i64::from(i16::from_le_bytes(b))))),
        3 => Values::Whole(Box::new(each(bytes, |b| i64::from(i32::from_le_bytes(b))))),
        4 => Values::Whole(Box::new(each(bytes, |b| i64::from(u8::from_le_bytes(b))))),
        5 => Values::Whole(Box::new(each(bytes, |b| i64::from(u16::from_le_bytes(b))))),
        6 => Values::Whole(Box::new(each(bytes, |b| i64::from(u32::from_le_bytes(b))))),
        32 => Values::Real(Box::new(each(bytes, |b| f64::from(f32::from_le_bytes(b))))),
        33 => Values::Real(Box::new(each(bytes, f64::from_le_bytes))),
        _ => return Err(format!("there is no type {kind} of numbers")),
    })
}

/// Texts: `{stringData, offsets, offsetEncoding, dataEncoding}`.
fn texts(indices: Vec<u8>, mut encoding: Value, count: u64) -> Found<Values> {
    let Some(Value::String(data)) = field(&mut encoding, "stringData") else {
        return Err("there is no stringData".to_owned());
    };
    let bytes = data.into_bytes();
    let Some(Value::Binary(offsets)) = field(&mut encoding, "offsets") else {
        return Err("there are no offsets".to_owned());
    };
    // Texts differ, so they are not many more than their bytes.
    let most = bytes.len() + 2;
    let offsets = whole_of(decode(offsets, field(&mut encoding, "offsetEncoding"), most as u64 + 1)?)?;
    let offsets: Vec<usize> = offsets.take(most + 1).map(|at| usize::try_from(at).unwrap_or(usize::MAX)).collect();
    if offsets.len() > most {
        return Err("stringData has fewer bytes than texts".to_owned());
    }
    let indices = whole_of(decode(indices, field(&mut encoding, "dataEncoding"), count)?)?;
    Ok(Values::Texts(Texts { bytes, offsets, indices }))
}

/// Undoes RunLength: values, each followed by its number. Of `count` values at most twice as many numbers are needed, as pairs of another
/// RunLength: a few bytes stand for any number of them, which the encoding before may take without a value of its own.
fn runs(mut pairs: Whole, count: u64) -> Whole {
    let (mut value, mut left) = (0, 0);
    let next = move || {
        while left <= 0 {
            (value, left) = (pairs.next()?, pairs.next()?);
        }
        left -= 1;
        Some(value)
    };
    Box::new(std::iter::from_fn(next).take(usize::try_from(count.saturating_mul(2)).unwrap_or(usize::MAX)))
}

/// Undoes IntegerPacking: a number at an end of its type is added to the next one.
fn unpacked(mut parts: Whole, bytes: i64, is_unsigned: bool) -> Found<Whole> {
    let [low, high] = match (bytes, is_unsigned) {
        (1, true) => [-1, 0xff],
        (2, true) => [-1, 0xffff],
        (1, false) => [-0x80, 0x7f],
        (2, false) => [-0x8000, 0x7fff],
        _ => return Err(format!("byteCount is {bytes}, not 1 or 2")),
    };
    Ok(Box::new(std::iter::from_fn(move || {
        let mut sum = 0i64;
        loop {
            let part = parts.next()?;
            sum = sum.wrapping_add(part);
            if part != low && part != high {
                return Some(sum);
            }
        }
    })))
}
