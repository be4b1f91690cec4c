//! NumPy's .npy: one buffer per file, without loss. Written as format version 1.0, little-endian, C order; read in any
//! version, byte order and axis order, for plain number types.

use super::encode::Encoder;
use super::format::{FileFormat, FormatOptions};
use super::layer::{LayerFormat, SampleType};
use super::plain::{self, Plain};
use super::rows::{Head, Rows, SeekRead, Sink, invalid, pulled};
use crate::error::{Error, Place, Result};
use crate::frame::Buffer;
use crate::frame::array::{Array, Values};
use crate::frame::provenance::Provenance;
use crate::memory::check;
use crate::npy::{DType, Header};
use std::io::{self, Write};

pub use crate::npy::MAGIC;

/// Writes `buffer` as `[H, W]`, `[H, W, 3]` or `[H, W, L]` of `<f4`, `<f8`, `<i4`, `<i8` or `|u1`, without provenance.
///
/// # Errors
/// The errors of `out`, and `InvalidInput` for a buffer that fails [`Buffer::check`].
pub fn write(buffer: &Buffer, out: &mut dyn Write) -> io::Result<()> {
    buffer.check().map_err(invalid)?;
    let (style, rows) = (FormatOptions::default(), buffer.shape[0]);
    let mut encoder = Encoder::plain(buffer, &style).ok_or_else(|| invalid("a .npy cannot hold this buffer"))?;
    out.write_all(&header(encoder.forms()[0], [buffer.shape[1], rows])?)?;
    out.write_all(&pulled(&mut encoder, 0, 0..rows)?)
}

/// Writes the only buffer. The header of a .npy cannot hold metadata, so the provenance follows the last number, which
/// NumPy does not read.
pub(super) fn write_sheet(head: &Head, rows: &mut dyn Rows, out: &mut dyn Sink) -> io::Result<()> {
    head.form()?;
    write_layer(head, 0, rows, out)?;
    out.write_all(head.provenance.trailer().as_bytes())
}

/// The sample types, with NumPy's names.
const TYPES: [(SampleType, &str); 5] = [
    (SampleType::F32, "<f4"),
    (SampleType::F64, "<f8"),
    (SampleType::I32, "<i4"),
    (SampleType::I64, "<i8"),
    (SampleType::U8, "|u1"),
];

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

/// The header for the numbers of `[width, height]` pixels.
pub(super) fn header(form: LayerFormat, [width, height]: [usize; 2]) -> io::Result<Vec<u8>> {
    let known = TYPES.iter().find(|(kind, _)| *kind == form.kind);
    let (_, descr) =
        known.ok_or_else(|| invalid(format!("a .npy cannot hold samples of {} of this type", form.aov)))?;
    let mut shape = vec![height as u64, width as u64];
    if form.aov.is_vector() {
        shape.push(form.channels as u64);
    }
    Ok(Header::bytes(descr, &shape))
}

/// Opens a file that [`write_sheet`] wrote; `None` where it has no provenance.
pub(super) fn open<'a>(mut input: Box<dyn SeekRead + 'a>, name: &str) -> Result<Option<(Head, Box<dyn Rows + 'a>)>> {
    let (bytes, length) = plain::start(&mut *input, name)?;
    let (array, numbers) = Layout::of(&bytes, name)?;
    let (first, size) = ((bytes.len() - numbers.len()) as u64, array.bytes);
    let Some(end) = first.checked_add(size).filter(|end| *end <= length) else {
        return Err(array.short(length.saturating_sub(first), name));
    };
    let words = plain::tail(&mut *input, end, length, name)?.and_then(|tail| Provenance::from_trailer(&tail));
    let Some(head) = words.and_then(|words| Head::new(FileFormat::Npy, words)) else { return Ok(None) };
    if !head.form().and_then(|form| header(form, head.size())).is_ok_and(|header| bytes.starts_with(&header)) {
        return Ok(None);
    }
    let layers = vec![(first, head.row(0))];
    let rows = Plain { input, name: name.into(), layers, bottom_up: None, samples: Vec::new() };
    Ok(Some((head, Box::new(rows))))
}

/// Reads the array in `bytes`, a complete .npy file; errors refer to it by `name`. Booleans become 0 and 1, integers
/// the smaller of i32 and i64 that holds their type. After the last value there may be a provenance.
///
/// # Errors
/// [`Error::Scene`] at the file for malformed, truncated or non-numeric data.
pub fn read(bytes: &[u8], name: &str) -> Result<Array> {
    let (array, data) = Layout::of(bytes, name)?;
    let size = usize::try_from(array.bytes).ok();
    let Some((data, rest)) = size.and_then(|size| data.split_at_checked(size)) else {
        return Err(array.short(data.len() as u64, name));
    };
    // Integers may become wider, and the axes may be reordered.
    check(4 * data.len() as u64, || format!("the numbers of {name}"))?;
    let values = array.values(data);
    if !rest.is_empty() && Provenance::from_trailer(rest).is_none() {
        return Err(malformed(name, format!("{} bytes follow the last value", rest.len())));
    }
    Array::new(name, array.shape, values)
}

fn malformed(name: &str, problem: String) -> Error {
    Error::scene(Place::file(name), problem, "use a .npy file of plain numbers")
}

/// The supported number types: NumPy's letter and size.
#[derive(Clone, Copy)]
enum Type {
    Bool,
    U8,
    I8,
    U16,
    I16,
    I32,
    U32,
    I64,
    F32,
    F64,
}

/// The layout of an array in its file.
struct Layout {
    of: Type,
    big_endian: bool,
    fortran: bool,
    shape: Vec<usize>,
    /// Bytes of all values.
    bytes: u64,
}

impl Layout {
    /// The layout of the file that begins with `bytes`, and the bytes after the header.
    fn of<'b>(bytes: &'b [u8], name: &str) -> Result<(Self, &'b [u8])> {
        let mut data = bytes;
        let header = Header::read(&mut data).map_err(|fault| malformed(name, fault.to_string()))?;
        let unknown = || malformed(name, format!("values of type {} cannot be read", header.dtype));
        let DType::Plain(text) = &header.dtype else { return Err(unknown()) };
        let (order, kind) = text.split_at_checked(1).ok_or_else(unknown)?;
        let of = match kind {
            "b1" => Type::Bool,
            "u1" => Type::U8,
            "i1" => Type::I8,
            "u2" => Type::U16,
            "i2" => Type::I16,
            "i4" => Type::I32,
            "u4" => Type::U32,
            "i8" => Type::I64,
            "f4" => Type::F32,
            "f8" => Type::F64,
            _ => return Err(unknown()),
        };
        let big_endian = match order {
            "<" | "|" => false,
            ">" => true,
            _ => return Err(unknown()),
        };
        let large = || malformed(name, format!("an array of shape {:?} is too large", header.shape));
        let bytes = header.data_bytes().ok_or_else(large)?;
        let shape = header.shape.iter().map(|side| usize::try_from(*side).ok()).collect::<Option<_>>();
        Ok((Self { of, big_endian, fortran: header.fortran, shape: shape.ok_or_else(large)?, bytes }, data))
    }

    /// The error for a file that has only `found` bytes of values.
    fn short(&self, found: u64, name: &str) -> Error {
        malformed(name, format!("{found} bytes cannot hold the {} bytes of shape {:?}", self.bytes, self.shape))
    }

    fn values(&self, data: &[u8]) -> Values {
        match self.of {
            Type::Bool => Values::U8(self.ordered(data.iter().map(|x| u8::from(*x != 0)).collect())),
            Type::U8 => Values::U8(self.ordered(data.to_vec())),
            Type::I8 => Values::I32(self.ordered(data.iter().map(|x| i32::from(*x as i8)).collect())),
            Type::U16 => Values::U16(self.numbers(data, u16::from_le_bytes)),
            Type::I16 => Values::I32(self.numbers(data, |b| i16::from_le_bytes(b).into())),
            Type::I32 => Values::I32(self.numbers(data, i32::from_le_bytes)),
            Type::U32 => Values::I64(self.numbers(data, |b| u32::from_le_bytes(b).into())),
            Type::I64 => Values::I64(self.numbers(data, i64::from_le_bytes)),
            Type::F32 => Values::F32(self.numbers(data, f32::from_le_bytes)),
            Type::F64 => Values::F64(self.numbers(data, f64::from_le_bytes)),
        }
    }

    fn numbers<T: Copy, const N: usize>(&self, data: &[u8], little: impl Fn([u8; N]) -> T) -> Vec<T> {
        let (values, _) = data.as_chunks::<N>();
        let native = |mut bytes: [u8; N]| {
            if self.big_endian {
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
