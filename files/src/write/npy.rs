//! NumPy's .npy: one buffer per file, without loss. Written as format version 1.0, little-endian, C order; read in any
//! version, byte order and axis order, for plain number types.

use super::encode::Encoder;
use super::format::{FileFormat, FormatOptions};
use super::layer::{LayerFormat, SampleType};
use super::plain;
use super::rows::{Found, Head, Rows, SeekRead, Sink, invalid, pulled};
use halfline::error::{Error, Place, Result};
use halfline::frame::Buffer;
use halfline::frame::array::{Array, Values};
use halfline::frame::provenance::Provenance;
use halfline::memory::check;
use halfline_particles::npy::header::{Header, NumberKind, Scalar};
use std::io::{self, Write};

pub use halfline_particles::npy::header::MAGIC;

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
pub(super) fn open<'a>(input: Box<dyn SeekRead + 'a>, name: &str) -> Result<Found<'a>> {
    let layout = |bytes: &[u8], length: u64| {
        let (array, numbers) = Layout::of(bytes, name)?;
        let first = (bytes.len() - numbers.len()) as u64;
        let end = first.checked_add(array.bytes).filter(|end| *end <= length);
        end.map(|end| [first, end]).ok_or_else(|| array.short(length.saturating_sub(first), name))
    };
    plain::open(input, name, FileFormat::Npy, layout, |head| header(head.form()?, head.size()))
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

/// The layout of an array in its file.
struct Layout {
    of: Scalar,
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
        let readable = |of: &Scalar| (of.kind, of.size()) != (NumberKind::Unsigned, 8);
        let unknown = || malformed(name, format!("values of type {} cannot be read", header.dtype));
        let of = header.dtype.scalar().filter(readable).ok_or_else(unknown)?;
        let large = || malformed(name, format!("an array of shape {:?} is too large", header.shape));
        let bytes = header.data_bytes().ok_or_else(large)?;
        let shape = header.shape.iter().map(|side| usize::try_from(*side).ok()).collect::<Option<_>>();
        Ok((Self { of, fortran: header.fortran, shape: shape.ok_or_else(large)?, bytes }, data))
    }

    /// The error for a file that has only `found` bytes of values.
    fn short(&self, found: u64, name: &str) -> Error {
        malformed(name, format!("{found} bytes cannot hold the {} bytes of shape {:?}", self.bytes, self.shape))
    }

    fn values(&self, data: &[u8]) -> Values {
        match (self.of.kind, self.of.size()) {
            (NumberKind::Bool, _) => Values::U8(self.numbers(data, |[x]: [u8; 1]| u8::from(x != 0))),
            (NumberKind::Unsigned, 1) => Values::U8(self.numbers(data, |[x]: [u8; 1]| x)),
            (NumberKind::Unsigned, 2) => Values::U16(self.numbers(data, u16::from_le_bytes)),
            (NumberKind::Unsigned, _) => Values::I64(self.numbers(data, |b| u32::from_le_bytes(b).into())),
            (NumberKind::Signed, 1) => Values::I32(self.numbers(data, |[x]: [u8; 1]| (x as i8).into())),
            (NumberKind::Signed, 2) => Values::I32(self.numbers(data, |b| i16::from_le_bytes(b).into())),
            (NumberKind::Signed, 4) => Values::I32(self.numbers(data, i32::from_le_bytes)),
            (NumberKind::Signed, _) => Values::I64(self.numbers(data, i64::from_le_bytes)),
            (NumberKind::Float, 4) => Values::F32(self.numbers(data, f32::from_le_bytes)),
            (NumberKind::Float, _) => Values::F64(self.numbers(data, f64::from_le_bytes)),
        }
    }

    /// The values in C order.
    fn numbers<T, const N: usize>(&self, data: &[u8], little: impl Fn([u8; N]) -> T) -> Vec<T> {
        let (values, _) = data.as_chunks::<N>();
        let native = |mut bytes: [u8; N]| {
            if self.of.big {
                bytes.reverse();
            }
            little(bytes)
        };
        if !self.fortran || self.shape.len() < 2 {
            return values.iter().map(|bytes| native(*bytes)).collect();
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
        (0..values.len()).map(|index| native(values[from(index)])).collect()
    }
}
