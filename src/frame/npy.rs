//! NumPy's .npy: one buffer per file, nothing lost. Written as format version 1.0, little endian, C order;
//! read in any version, byte order and axis order, for the plain number types.

use super::Buffer;
use super::array::{Array, Values};
use super::encode::Encoder;
use super::format::{Format, Style};
use super::plain::{self, Plain};
use super::provenance::Provenance;
use super::sheet::{Form, Head, Input, Kind, Rows, Sink, invalid, pulled};
use crate::error::{Error, Place, Result};
use crate::memory::check;
use crate::npy::{DType, Header};
use std::io::{self, Write};

pub(crate) use crate::npy::MAGIC;

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
    Ok(Header::bytes(descr, &shape))
}

/// Opens what [`write_sheet`] wrote; `None` where it does not say where it comes from.
pub(super) fn open<'a>(mut input: Box<dyn Input + 'a>, name: &str) -> Result<Option<(Head, Box<dyn Rows + 'a>)>> {
    let (bytes, length) = plain::start(&mut *input, name)?;
    let (array, numbers) = Layout::of(&bytes, name)?;
    let (first, size) = ((bytes.len() - numbers.len()) as u64, array.bytes);
    let Some(end) = first.checked_add(size).filter(|end| *end <= length) else {
        return Err(array.short(length.saturating_sub(first), name));
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
    let (array, data) = Layout::of(bytes, name)?;
    let size = usize::try_from(array.bytes).ok();
    let Some((data, rest)) = size.and_then(|size| data.split_at_checked(size)) else {
        return Err(array.short(data.len() as u64, name));
    };
    // Integers may become wider ones, and the order of the axes another.
    check(4 * data.len() as u64, || format!("the numbers of {name}"))?;
    let values = array.values(data);
    if !rest.is_empty() && Provenance::from_trailer(rest).is_none() {
        return Err(malformed(name, format!("{} bytes follow the last value", rest.len())));
    }
    Array::new(name, array.shape, values)
}

fn malformed(name: &str, problem: String) -> Error {
    Error::scene(Place::file(name), problem, "give a .npy file of plain numbers")
}

/// Number types that are read: NumPy's letter and size.
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

/// How the numbers of an array lie in its file.
struct Layout {
    of: Type,
    big_endian: bool,
    fortran: bool,
    shape: Vec<usize>,
    /// Bytes of all values.
    bytes: u64,
}

impl Layout {
    /// That of the file which begins with `bytes`, and those behind the header.
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

    /// The fault of a file that has only so many bytes for the values.
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
