//! Lists of numbers as few bytes, exactly: as multiples of a power of ten where nearly all are such, else as f32 where these are enough.

use serde::{Deserialize, Serialize};

/// The most digits after the point.
const DIGITS: u8 = 9;

/// Of so many values of a list one may be no multiple: NaN, or a zero with a sign.
const EXCEPTIONS: usize = 64;

/// The most values of a list beyond the bytes of all: a list of one value needs no bytes.
const REPEATED: usize = 1 << 24;

/// A list of numbers, by the form of its values. Bytes of the same place are together, which compresses better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Form {
    /// One value, by its bits.
    Constant(u64),
    /// Differences of whole numbers, which are divided by 10 to this power.
    Decimal(u8),
    /// f32
    Single,
    /// f64
    Double,
}

/// The form of a list and its number of values; the bytes follow the bytes of the list before.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Entry {
    form: Form,
    count: u64,
    /// The places of values that have another form, and their bits.
    exceptions: Vec<(u64, u64)>,
}

/// Lists that are packed. Equal ones are kept once.
#[derive(Debug, Default)]
pub(super) struct Packed {
    entries: Vec<Entry>,
    parts: Vec<Vec<u8>>,
}

/// The table of lists, without their bytes.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Table(Vec<Entry>);

/// The lists of a table with their bytes.
pub(super) struct Lists<'a>(Vec<(&'a Entry, &'a [u8])>);

impl Packed {
    /// Adds a list; returns its number.
    pub(super) fn add(&mut self, values: &[f64]) -> u32 {
        let (form, exceptions, bytes) = packed(values);
        let entry = Entry { form, count: values.len() as u64, exceptions };
        let same = |n: &usize| self.entries[*n] == entry && self.parts[*n] == bytes;
        let known = (0..self.entries.len()).find(same);
        known.unwrap_or_else(|| {
            self.entries.push(entry);
            self.parts.push(bytes);
            self.entries.len() - 1
        }) as u32
    }

    /// The table, and the bytes of all lists.
    pub(super) fn into_parts(self) -> (Table, Vec<u8>) {
        (Table(self.entries), self.parts.concat())
    }
}

impl Table {
    /// The lists in these bytes; `None` where they are too few or too many.
    pub(super) fn lists<'a>(&'a self, mut bytes: &'a [u8]) -> Option<Lists<'a>> {
        let most = (bytes.len() + REPEATED) as u64;
        self.0.iter().all(|entry| entry.count <= most).then_some(())?;
        let mut lists = Vec::with_capacity(self.0.len());
        for entry in &self.0 {
            let (part, rest) =
                bytes.split_at_checked(usize::try_from(entry.count).ok()?.checked_mul(entry.form.size())?)?;
            lists.push((entry, part));
            bytes = rest;
        }
        bytes.is_empty().then_some(Lists(lists))
    }
}

impl Lists<'_> {
    /// The values of a list; `None` for a number without a list, or for another number of values.
    pub(super) fn get(&self, number: u32, count: usize) -> Option<Vec<f64>> {
        let (entry, bytes) = self.0.get(number as usize)?;
        let mut values = (entry.count == count as u64).then(|| unpacked(entry.form, bytes, count))?;
        for (place, bits) in &entry.exceptions {
            *values.get_mut(usize::try_from(*place).ok()?)? = f64::from_bits(*bits);
        }
        Some(values)
    }
}

impl Form {
    /// Bytes of a value.
    fn size(self) -> usize {
        match self {
            Self::Constant(_) => 0,
            Self::Decimal(_) | Self::Single => 4,
            Self::Double => 8,
        }
    }
}

fn packed(values: &[f64]) -> (Form, Vec<(u64, u64)>, Vec<u8>) {
    let first = values.first().copied().unwrap_or_default();
    if values.iter().all(|x| x.to_bits() == first.to_bits()) {
        return (Form::Constant(first.to_bits()), Vec::new(), Vec::new());
    }
    // The first values show the form of most lists.
    let few = |misses: usize, values: &[f64]| misses <= values.len() / EXCEPTIONS;
    let start = &values[..values.len().min(8 * EXCEPTIONS)];
    let fits = |digits: &u8| few(start.iter().filter(|x| whole(**x, *digits).is_none()).count(), start);
    let scaled = |digits: u8| {
        let numbers: Vec<Option<i32>> = values.iter().map(|x| whole(*x, digits)).collect();
        few(numbers.iter().filter(|number| number.is_none()).count(), values).then_some((digits, numbers))
    };
    if let Some((digits, numbers)) = (0..=DIGITS).filter(fits).find_map(scaled) {
        let exceptions = numbers.iter().zip(values).zip(0..);
        let exceptions = exceptions.filter(|((number, _), _)| number.is_none()).map(|((_, x), n)| (n, x.to_bits()));
        let (exceptions, mut last) = (exceptions.collect(), 0);
        let difference = |number: &Option<i32>| {
            let number = number.unwrap_or(last);
            let x = number.wrapping_sub(std::mem::replace(&mut last, number));
            // The sign goes to the lowest bit, so that small numbers have zeros in front.
            ((x << 1) ^ (x >> 31)).to_le_bytes()
        };
        return (Form::Decimal(digits), exceptions, planes(&numbers.iter().map(difference).collect::<Vec<_>>()));
    }
    let single = |x: &f64| f64::from(*x as f32).to_bits() == x.to_bits();
    if values.iter().all(single) {
        return (
            Form::Single,
            Vec::new(),
            planes(&values.iter().map(|x| (*x as f32).to_le_bytes()).collect::<Vec<_>>()),
        );
    }
    (Form::Double, Vec::new(), planes(&values.iter().map(|x| x.to_le_bytes()).collect::<Vec<_>>()))
}

/// The whole number that, divided by ten to the power of `digits`, is exactly `value`.
fn whole(value: f64, digits: u8) -> Option<i32> {
    let number = (value * 10f64.powi(digits.into())).round();
    let is_exact = number.abs() <= f64::from(i32::MAX) && decimal(number as i32, digits).to_bits() == value.to_bits();
    is_exact.then_some(number as i32)
}

fn decimal(number: i32, digits: u8) -> f64 {
    f64::from(number) / 10f64.powi(digits.into())
}

fn unpacked(form: Form, bytes: &[u8], count: usize) -> Vec<f64> {
    match form {
        Form::Constant(bits) => vec![f64::from_bits(bits); count],
        Form::Decimal(digits) => {
            let mut last = 0i32;
            let next = |bytes: [u8; 4]| {
                let zigzag = u32::from_le_bytes(bytes);
                last = last.wrapping_add((zigzag >> 1) as i32 ^ -((zigzag & 1) as i32));
                decimal(last, digits)
            };
            values(bytes, count).map(next).collect()
        }
        Form::Single => values(bytes, count).map(|bytes| f32::from_le_bytes(bytes).into()).collect(),
        Form::Double => values(bytes, count).map(f64::from_le_bytes).collect(),
    }
}

/// First the first bytes of all values, then the second ones, and so on.
fn planes<const N: usize>(values: &[[u8; N]]) -> Vec<u8> {
    (0..N).flat_map(|plane| values.iter().map(move |value| value[plane])).collect()
}

/// The values whose bytes [`planes`] arranged.
fn values<const N: usize>(bytes: &[u8], count: usize) -> impl Iterator<Item = [u8; N]> {
    (0..count).map(move |n| std::array::from_fn(|plane| bytes[plane * count + n]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn form_and_size(values: &[f64]) -> (Form, usize) {
        let mut packed = Packed::default();
        assert_eq!([packed.add(values), packed.add(values)], [0, 0], "equal lists are kept once");
        let form = packed.entries[0].form;
        let (table, bytes) = packed.into_parts();
        let lists = table.lists(&bytes).expect("lists");
        let again = lists.get(0, values.len()).expect("a list");
        let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&again), bits(values));
        assert!(lists.get(0, values.len() + 1).is_none() && lists.get(1, values.len()).is_none());
        assert!(table.lists(&[&bytes[..], &[0]].concat()).is_none(), "bytes that belong to no list");
        assert!(bytes.is_empty() || table.lists(&bytes[1..]).is_none(), "a byte too few");
        (form, bytes.len())
    }

    #[test]
    fn numbers_keep_their_bits() {
        for (values, form, size) in [
            (&[][..], Form::Constant(0), 0),
            (&[0.1; 5], Form::Constant(0.1f64.to_bits()), 0),
            (&[-0.0; 2], Form::Constant((-0.0f64).to_bits()), 0),
            (&[1.0, -2.0, 2147483647.0, -2147483647.0], Form::Decimal(0), 16),
            (&[12.345, -0.001, 7.0], Form::Decimal(3), 12),
            (&[1e-9, 0.5], Form::Decimal(9), 8),
            (&[0.0, -0.0], Form::Single, 8),
            (&[2f64.powi(100), f64::INFINITY, f64::from(0.1f32)], Form::Single, 12),
            (&[0.1, f64::NAN], Form::Double, 16),
            (&[0.1, 1e-12], Form::Double, 16),
            (&[1.5, 2147483648.0], Form::Single, 8),
            (&[0.25, 0.5, -0.0, f64::NAN].repeat(64)[..], Form::Single, 4 * 256),
            (&[&[0.1; 200][..], &[-0.0, 0.3, f64::NAN]].concat(), Form::Decimal(1), 4 * 203),
        ] {
            assert_eq!(form_and_size(values), (form, size), "{values:?}");
        }
    }
}
