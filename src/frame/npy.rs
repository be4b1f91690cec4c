//! NumPy's .npy: one buffer per file, nothing lost. Written as format version 1.0, little endian, C order;
//! read in any version, byte order and axis order, for the plain number types.

use super::Buffer;
use super::array::{Array, Values, count};
use super::encode::Encoder;
use super::format::{Format, Style};
use super::plain::{self, Plain};
use super::provenance::Provenance;
use super::sheet::{Form, Head, Input, Kind, Rows, Sink, invalid, pulled};
use crate::error::{Error, Place, Result};
use crate::memory::check;
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
    let (style, rows) = (Style::default(), buffer.shape[0]);
    let mut encoder = Encoder::plain(buffer, &style).ok_or_else(|| invalid("no .npy holds this buffer"))?;
    out.write_all(&header(encoder.forms()[0], [buffer.shape[1], rows])?)?;
    out.write_all(&pulled(&mut encoder, 0, 0..rows)?)
}

/// Writes the only buffer. A .npy has no room for words, so provenance follows the last number, where NumPy does not look.
pub(super) fn write_sheet(head: &Head, rows: &mut dyn Rows, out: &mut dyn Sink) -> io::Result<()> {
    head.form()?;
    write_layer(head, 0, rows, out)?;
    out.write_all(head.provenance.trailer().as_bytes())
}

/// The types of samples, by NumPy's names.
const TYPES: [(Kind, &str); 4] = [(Kind::F32, "<f4"), (Kind::F64, "<f8"), (Kind::I32, "<i4"), (Kind::U8, "|u1")];

/// Writes one buffer.
pub(super) fn write_layer<W: Write + ?Sized>(
    head: &Head,
    layer: usize,
    rows: &mut dyn Rows,
    out: &mut W,
) -> io::Result<()> {
    out.write_all(&header(head.forms[layer], head.size())?)?;
    head.bands().try_for_each(|band| out.write_all(&pulled(rows, layer, band)?))
}

/// What stands before the numbers of `[width, height]` pixels.
pub(super) fn header(form: Form, [width, height]: [usize; 2]) -> io::Result<Vec<u8>> {
    let known = TYPES.iter().find(|(kind, _)| *kind == form.kind);
    let (_, descr) = known.ok_or_else(|| invalid(format!("these samples of {} are not those of a .npy", form.aov)))?;
    let mut shape = vec![height as u64, width as u64];
    if form.channels > 1 {
        shape.push(form.channels as u64);
    }
    let mut bytes = Vec::new();
    npyz::WriteOptions::new_header_only()
        .dtype(npyz::DType::new_scalar(descr.parse().map_err(io::Error::other)?))
        .shape(&shape)
        .writer(&mut bytes)
        .write_header_only()?;
    Ok(bytes)
}

/// Opens what [`write_sheet`] wrote; `None` where it does not say where it comes from.
pub(super) fn open<'a>(mut input: Box<dyn Input + 'a>, name: &str) -> Result<Option<(Head, Box<dyn Rows + 'a>)>> {
    let (bytes, length) = plain::start(&mut *input, name)?;
    let (found, numbers) = Header::of(&bytes, name)?;
    let (first, size) = ((bytes.len() - numbers.len()) as u64, found.bytes());
    let Some(end) = size.and_then(|size| first.checked_add(size)).filter(|end| *end <= length) else {
        return Err(found.short(length.saturating_sub(first), name));
    };
    let words = plain::tail(&mut *input, end, length, name)?.and_then(|tail| Provenance::from_trailer(&tail));
    let Some(head) = words.and_then(|words| Head::new(Format::Npy, words)) else { return Ok(None) };
    if !head.form().and_then(|form| header(form, head.size())).is_ok_and(|header| bytes.starts_with(&header)) {
        return Ok(None);
    }
    let layers = vec![(first, head.row(0))];
    let rows = Plain { input, name: name.into(), layers, bottom_up: None, samples: Vec::new() };
    Ok(Some((head, Box::new(rows))))
}

/// Reads the array in `bytes`, a whole .npy file; `name` is what errors call it. Booleans become 0 and 1,
/// integers the next wider of i32 and i64 that holds them all. Behind the last value stands nothing, or where the file
/// comes from.
///
/// # Errors
/// [`Error::Scene`] at the file for anything malformed, truncated or not made of plain numbers.
pub fn read(bytes: &[u8], name: &str) -> Result<Array> {
    let (header, data, rest) = parts(bytes, name)?;
    // Integers may become wider ones, and the order of the axes another.
    check(4 * data.len() as u64, || format!("the numbers of {name}"))?;
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
    let (header, data) = Header::of(bytes, name)?;
    let needed = header.bytes().and_then(|n| usize::try_from(n).ok());
    let Some((data, rest)) = needed.and_then(|n| data.split_at_checked(n)) else {
        return Err(header.short(data.len() as u64, name));
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
    /// That of the file which begins with `bytes`, and those behind it.
    fn of(bytes: &'a [u8], name: &str) -> Result<(Self, &'a [u8])> {
        let (text, data) =
            split(bytes).ok_or_else(|| malformed(name, "the .npy header is cut short or malformed".into()))?;
        let header =
            Self::parse(text).ok_or_else(|| malformed(name, "the .npy header is not that of a plain array".into()))?;
        header.size().ok_or_else(|| header.unknown(name))?;
        Ok((header, data))
    }

    /// Bytes of all values; `None` for more than there can be.
    fn bytes(&self) -> Option<u64> {
        count(&self.shape)?.checked_mul(self.size()?).map(|n| n as u64)
    }

    /// The fault of a file that has only so many bytes for the values.
    fn short(&self, found: u64, name: &str) -> Error {
        malformed(name, format!("{found} bytes do not hold {:?} of {:?}", self.shape, self.descr))
    }

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
