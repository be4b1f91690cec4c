//! NumPy's .npy: one buffer per file, nothing lost. Written as format version 1.0, little endian, C order;
//! read in any version, byte order and axis order, for the plain number types.

use super::{Buffer, Data};
use crate::error::{Error, Place, Result};
use crate::measure::{Array, Values, count};
use npyz::WriterBuilder;
use std::io::{self, Write};

/// The bytes every .npy file begins with.
pub const MAGIC: &[u8] = b"\x93NUMPY";

/// Writes `buffer` as `[H, W]` or `[H, W, 3]` of `<f4`, `<f8`, `<i4` or `|u1`.
///
/// # Errors
/// `out`'s own, and `InvalidInput` for a buffer that fails [`Buffer::check`].
pub fn write(buffer: &Buffer, out: &mut dyn Write) -> io::Result<()> {
    buffer.check().map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
    let dtype: npyz::TypeStr = match buffer.data {
        Data::F32(_) => "<f4",
        Data::F64(_) => "<f8",
        Data::I32(_) => "<i4",
        Data::U8(_) => "|u1",
    }
    .parse()
    .map_err(io::Error::other)?;
    let shape: Vec<u64> = buffer.shape.iter().map(|side| *side as u64).collect();
    npyz::WriteOptions::new_header_only()
        .dtype(npyz::DType::new_scalar(dtype))
        .shape(&shape)
        .writer(&mut *out)
        .write_header_only()?;
    match &buffer.data {
        Data::F32(values) => values_to(out, values, |x| x.to_le_bytes()),
        Data::F64(values) => values_to(out, values, |x| x.to_le_bytes()),
        Data::I32(values) => values_to(out, values, |x| x.to_le_bytes()),
        Data::U8(values) => out.write_all(values),
    }
}

/// All values at once where memory already holds them as the file does.
fn values_to<T: bytemuck::NoUninit, const N: usize>(
    out: &mut dyn Write,
    values: &[T],
    little: impl Fn(T) -> [u8; N],
) -> io::Result<()> {
    if cfg!(target_endian = "little") {
        return out.write_all(bytemuck::cast_slice(values));
    }
    values.iter().try_for_each(|value| out.write_all(&little(*value)))
}

/// Reads the array in `bytes`, a whole .npy file; `name` is what errors call it. Booleans become 0 and 1,
/// integers the next wider of i32 and i64 that holds them all. Bytes after the last value are ignored, as NumPy does.
///
/// # Errors
/// [`Error::Scene`] at the file for anything malformed, truncated or not made of plain numbers.
pub fn read(bytes: &[u8], name: &str) -> Result<Array> {
    let malformed = |problem: String| Error::scene(Place::file(name), problem, "give a .npy file of plain numbers");
    let (text, data) = split(bytes).ok_or_else(|| malformed("the .npy header is cut short or malformed".into()))?;
    let header = Header::parse(text).ok_or_else(|| malformed("the .npy header is not that of a plain array".into()))?;
    let unknown = || malformed(format!("values of type {:?} are not read", header.descr));
    let size = header.size().ok_or_else(unknown)?;
    let needed = count(&header.shape).and_then(|n| n.checked_mul(size));
    let Some(data) = needed.and_then(|n| data.get(..n)) else {
        let problem = format!("{} bytes do not hold {:?} of {:?}", data.len(), header.shape, header.descr);
        return Err(malformed(problem));
    };
    let values = header.values(data).ok_or_else(unknown)?;
    Array::new(name, header.shape, values)
}

/// The header's text and the data behind it.
fn split(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let rest = bytes.strip_prefix(MAGIC)?;
    let (version, rest) = rest.split_first_chunk::<2>()?;
    let (length, rest) = match version[0] {
        1 => rest.split_first_chunk::<2>().map(|(n, rest)| (usize::from(u16::from_le_bytes(*n)), rest))?,
        2 | 3 => rest.split_first_chunk::<4>().map(|(n, rest)| (u32::from_le_bytes(*n) as usize, rest))?,
        _ => return None,
    };
    let (text, data) = rest.split_at_checked(length)?;
    Some((str::from_utf8(text).ok()?, data))
}

/// What the header's Python dictionary says. npyz's own reader overflows on absurd shapes and recurses on nested
/// literals, so the three entries of a plain array are read here.
struct Header<'a> {
    descr: &'a str,
    fortran: bool,
    shape: Vec<usize>,
}

impl<'a> Header<'a> {
    fn parse(text: &'a str) -> Option<Self> {
        let entry = |key: &str| {
            let at = [format!("'{key}'"), format!("\"{key}\"")].iter().find_map(|k| Some(text.find(k)? + k.len()))?;
            Some(text[at..].trim_start().strip_prefix(':')?.trim_start())
        };
        let descr = entry("descr")?;
        let quote = descr.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
        let (descr, _) = descr[1..].split_once(quote)?;
        let fortran = match entry("fortran_order")? {
            order if order.starts_with("False") => false,
            order if order.starts_with("True") => true,
            _ => return None,
        };
        let (shape, _) = entry("shape")?.strip_prefix('(')?.split_once(')')?;
        let sides = shape.split(',').map(str::trim).filter(|side| !side.is_empty());
        let shape = sides.map(|side| side.trim_end_matches('L').parse().ok()).collect::<Option<_>>()?;
        Some(Self { descr, fortran, shape })
    }

    /// Bytes of one value.
    fn size(&self) -> Option<usize> {
        self.descr.get(2..)?.parse().ok().filter(|size| [1, 2, 4, 8].contains(size))
    }

    fn values(&self, data: &[u8]) -> Option<Values> {
        let big = match self.descr.as_bytes().first()? {
            b'<' | b'|' => false,
            b'>' => true,
            b'=' => cfg!(target_endian = "big"),
            _ => return None,
        };
        Some(match self.descr.get(1..)? {
            "b1" => Values::U8(self.ordered(data.iter().map(|x| u8::from(*x != 0)).collect())),
            "u1" => Values::U8(self.ordered(data.to_vec())),
            "i1" => Values::I32(self.ordered(data.iter().map(|x| i32::from(*x as i8)).collect())),
            "u2" => Values::U16(self.numbers(data, big, u16::from_le_bytes)),
            "i2" => Values::I32(self.numbers(data, big, |b| i16::from_le_bytes(b).into())),
            "i4" => Values::I32(self.numbers(data, big, i32::from_le_bytes)),
            "u4" => Values::I64(self.numbers(data, big, |b| u32::from_le_bytes(b).into())),
            "i8" => Values::I64(self.numbers(data, big, i64::from_le_bytes)),
            "f4" => Values::F32(self.numbers(data, big, f32::from_le_bytes)),
            "f8" => Values::F64(self.numbers(data, big, f64::from_le_bytes)),
            _ => return None,
        })
    }

    fn numbers<T: Copy, const N: usize>(&self, data: &[u8], big: bool, little: impl Fn([u8; N]) -> T) -> Vec<T> {
        let (values, _) = data.as_chunks::<N>();
        let native = |mut bytes: [u8; N]| {
            if big {
                bytes.reverse();
            }
            little(bytes)
        };
        self.ordered(values.iter().map(|bytes| native(*bytes)).collect())
    }

    /// The values in C order.
    fn ordered<T: Copy>(&self, values: Vec<T>) -> Vec<T> {
        if !self.fortran || self.shape.len() < 2 {
            return values;
        }
        let from = |mut index: usize| {
            let (mut place, mut stride) = (0, values.len());
            for side in self.shape.iter().rev() {
                stride /= side;
                place += index % side * stride;
                index /= side;
            }
            place
        };
        (0..values.len()).map(|index| values[from(index)]).collect()
    }
}
