//! NumPy's .npy: one buffer per file, nothing lost. Written as format version 1.0, little endian, C order;
//! read in any version, byte order and axis order, for the plain number types.

use super::format::{Format, Style};
use super::provenance::Provenance;
use super::sheet::{Kind, Layer, Sheet, invalid};
use super::{Aov, Buffer, encode};
use crate::error::{Error, Place, Result};
use crate::measure::{Array, Values, count};
use npyz::WriterBuilder;
use std::io::{self, Write};

/// The bytes every .npy file begins with.
pub const MAGIC: &[u8] = b"\x93NUMPY";

/// Writes `buffer` as `[H, W]` or `[H, W, 3]` of `<f4`, `<f8`, `<i4` or `|u1`, and nothing behind it.
///
/// # Errors
/// `out`'s own, and `InvalidInput` for a buffer that fails [`Buffer::check`].
pub fn write(buffer: &Buffer, out: &mut dyn Write) -> io::Result<()> {
    buffer.check().map_err(invalid)?;
    let layer = encode::layer(buffer, None, Format::Npy, &Style::default());
    write_layer(&layer, [buffer.shape[1], buffer.shape[0]], out)
}

/// Writes the only layer. A .npy has no room for words, so provenance follows the last number, where NumPy does not look.
pub(super) fn write_sheet(sheet: &Sheet<'_>, out: &mut dyn Write) -> io::Result<()> {
    write_layer(sheet.layer()?, sheet.size(), out)?;
    out.write_all(sheet.provenance.trailer().as_bytes())
}

/// The types of samples, by NumPy's names.
const TYPES: [(Kind, &str); 4] = [(Kind::F32, "<f4"), (Kind::F64, "<f8"), (Kind::I32, "<i4"), (Kind::U8, "|u1")];

/// Writes `[width, height]` pixels.
pub(super) fn write_layer(layer: &Layer<'_>, [width, height]: [usize; 2], out: &mut dyn Write) -> io::Result<()> {
    let known = TYPES.iter().find(|(kind, _)| *kind == layer.kind);
    let (_, descr) = known.ok_or_else(|| invalid(format!("these samples of {} are not those of a .npy", layer.aov)))?;
    let mut shape = vec![height as u64, width as u64];
    if layer.channels > 1 {
        shape.push(layer.channels as u64);
    }
    npyz::WriteOptions::new_header_only()
        .dtype(npyz::DType::new_scalar(descr.parse().map_err(io::Error::other)?))
        .shape(&shape)
        .writer(&mut *out)
        .write_header_only()?;
    out.write_all(&layer.bytes)
}

/// Reads what [`write_sheet`] wrote; `None` where it does not say where it comes from.
pub(super) fn read_sheet(bytes: &[u8], name: &str) -> Result<Option<Sheet<'static>>> {
    let (_, _, rest) = parts(bytes, name)?;
    let Some(provenance) = Provenance::from_trailer(rest) else { return Ok(None) };
    let Some([aov]) = provenance.buffers().and_then(|all| <[_; 1]>::try_from(all).ok()) else { return Ok(None) };
    let (layer, _) = read_layer(bytes, name, aov)?;
    Ok(Sheet::new(vec![layer], provenance))
}

/// Reads what [`write_layer`] wrote, and what follows it.
pub(super) fn read_layer<'b>(bytes: &'b [u8], name: &str, aov: Aov) -> Result<(Layer<'static>, &'b [u8])> {
    let (header, data, rest) = parts(bytes, name)?;
    let known = TYPES.iter().find(|(_, descr)| *descr == header.descr).filter(|_| !header.fortran);
    let channels = header.shape.get(2).copied().unwrap_or(1);
    let (true, Some((kind, _))) = (matches!(header.shape.len(), 2 | 3), known) else {
        let problem = format!("{:?} of {:?} is no {aov} buffer", header.shape, header.descr);
        return Err(Error::scene(Place::file(name), problem, "give files that halfline render wrote"));
    };
    Ok((Layer { aov, kind: *kind, channels, bytes: data.to_vec().into() }, rest))
}

/// Reads the array in `bytes`, a whole .npy file; `name` is what errors call it. Booleans become 0 and 1,
/// integers the next wider of i32 and i64 that holds them all. Behind the last value stands nothing, or where the file
/// comes from.
///
/// # Errors
/// [`Error::Scene`] at the file for anything malformed, truncated or not made of plain numbers.
pub fn read(bytes: &[u8], name: &str) -> Result<Array> {
    let (header, data, rest) = parts(bytes, name)?;
    let values = header.values(data).ok_or_else(|| header.unknown(name))?;
    if !rest.is_empty() && Provenance::from_trailer(rest).is_none() {
        return Err(malformed(name, format!("{} bytes follow the last value", rest.len())));
    }
    Array::new(name, header.shape, values)
}

fn malformed(name: &str, problem: String) -> Error {
    Error::scene(Place::file(name), problem, "give a .npy file of plain numbers")
}

/// The header, the bytes of the values, and what follows them.
fn parts<'b>(bytes: &'b [u8], name: &str) -> Result<(Header<'b>, &'b [u8], &'b [u8])> {
    let (text, data) =
        split(bytes).ok_or_else(|| malformed(name, "the .npy header is cut short or malformed".into()))?;
    let header =
        Header::parse(text).ok_or_else(|| malformed(name, "the .npy header is not that of a plain array".into()))?;
    let size = header.size().ok_or_else(|| header.unknown(name))?;
    let needed = count(&header.shape).and_then(|n| n.checked_mul(size));
    let Some((data, rest)) = needed.and_then(|n| data.split_at_checked(n)) else {
        let problem = format!("{} bytes do not hold {:?} of {:?}", data.len(), header.shape, header.descr);
        return Err(malformed(name, problem));
    };
    Ok((header, data, rest))
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

    fn unknown(&self, name: &str) -> Error {
        malformed(name, format!("values of type {:?} are not read", self.descr))
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
