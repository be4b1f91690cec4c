//! Headers of NumPy's .npy files, format versions 1.0 to 3.0, as `numpy.lib.format` states them. A header is a Python
//! dictionary with three entries: `descr` (the type of the values), `fortran_order` and `shape`. The crate npyz (0.9.1)
//! takes over 20 s for 100 nested brackets and reserves 4 GiB where a damaged length says so.

mod literal;
mod scalar;

use halfline_ground::quote::quote;
use literal::Literal;
pub use scalar::{NumberKind, Scalar, bits, levels};
use std::fmt::{self, Display, Formatter};
use std::io::{self, Read};

/// The bytes every .npy file begins with.
pub const MAGIC: &[u8] = b"\x93NUMPY";

/// The longest header that NumPy accepts; headers of this program have about a hundred bytes.
const LONGEST: usize = 10_000;

/// A header: the layout of the values after it.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    pub dtype: DType,
    /// Whether the first index varies fastest.
    pub fortran: bool,
    pub shape: Vec<u64>,
}

/// The type of a value.
#[derive(Debug, Clone, PartialEq)]
pub enum DType {
    /// A type string of the array interface, such as `<f8`.
    Plain(String),
    /// An array of that many values of one type.
    Array(u64, Box<DType>),
    /// Named fields in sequence.
    Record(Vec<Field>),
}

/// A field of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    pub name: String,
    pub dtype: DType,
}

/// Why a file has no usable header.
#[derive(Debug)]
pub enum Fault {
    Io(io::Error),
    /// The file does not begin with [`MAGIC`].
    Magic,
    /// The file ends before its header does.
    Cut,
    /// The length of the header in bytes is too large.
    Long(usize),
    /// The header's text, or the part of it that a message can quote.
    Malformed(String),
}

impl Fault {
    /// The part of the file that is wrong.
    pub fn field(&self) -> &'static str {
        if matches!(self, Self::Magic) { "magic" } else { "header" }
    }
}

impl Display for Fault {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io(error) => error.fmt(f),
            Self::Magic => f.write_str("not a NumPy array file"),
            Self::Cut => f.write_str("the file ends within its header"),
            Self::Long(bytes) => write!(f, "the header has {bytes} bytes, more than {LONGEST}"),
            Self::Malformed(text) => write!(f, "{text:?} does not describe an array"),
        }
    }
}

impl Header {
    /// Reads the header; `reader` is then at the first value. Memory is bounded independently of the file's content.
    pub fn read(reader: &mut impl Read) -> Result<Self, Fault> {
        let mut exact = |bytes: &mut [u8]| {
            reader.read_exact(bytes).map_err(|error| match error.kind() {
                io::ErrorKind::UnexpectedEof => Fault::Cut,
                _ => Fault::Io(error),
            })
        };
        let mut start = [0; 8];
        exact(&mut start)?;
        let version = start.strip_prefix(MAGIC).ok_or(Fault::Magic)?[0];
        let mut length = [0; 4];
        exact(&mut length[..if version == 1 { 2 } else { 4 }])?;
        let length = u32::from_le_bytes(length) as usize;
        if length > LONGEST {
            return Err(Fault::Long(length));
        }
        let mut text = vec![0; length];
        exact(&mut text)?;
        let known = (1..=3).contains(&version);
        // Before version 3.0 a header is in ISO 8859-1; some writers have UTF-8 there too.
        let letters = |bytes: &[u8]| bytes.iter().map(|byte| char::from(*byte)).collect();
        let text = match String::from_utf8(text) {
            Ok(text) => text,
            Err(error) if version < 3 => letters(error.as_bytes()),
            Err(error) => String::from_utf8_lossy(error.as_bytes()).into_owned(),
        };
        let header = Some(&text).filter(|_| known).and_then(|text| Self::parse(text));
        header.ok_or_else(|| Fault::Malformed(text.trim_end().chars().take(120).collect()))
    }

    fn parse(text: &str) -> Option<Self> {
        let Literal::Dict(entries) = Literal::parse(text)? else { return None };
        let entry = |name: &str| entries.iter().find(|(key, _)| key == name).map(|(_, value)| value);
        let Literal::Bool(fortran) = *entry("fortran_order")? else { return None };
        let Literal::List(sides) = entry("shape")? else { return None };
        let shape = sides.iter().map(Literal::number).collect::<Option<_>>()?;
        let header = Self { dtype: DType::new(entry("descr")?)?, fortran, shape };
        // Without this check a shape could claim more bytes than a u64 counts.
        let is_countable = header.data_bytes().is_some() || header.dtype.bytes().is_none();
        is_countable.then_some(header)
    }

    /// The number of bytes of the array's data. `None` if the data type has no fixed size, or if the product of the
    /// nonzero sides overflows a u64.
    pub fn data_bytes(&self) -> Option<u64> {
        let one = self.dtype.bytes()? as u64;
        let nonzero = self.shape.iter().filter(|side| **side > 0).try_fold(one, |n, side| n.checked_mul(*side))?;
        Some(if self.shape.contains(&0) { 0 } else { nonzero })
    }

    /// The bytes of the header of an array in C order, version 1.0, padded to a multiple of 64.
    pub fn bytes(type_string: &str, shape: &[u64]) -> Vec<u8> {
        let sides: String = shape.iter().map(|side| format!("{side}, ")).collect();
        let text = format!("{{'descr': '{type_string}', 'fortran_order': False, 'shape': ({sides}), }}");
        let start = MAGIC.len() + 4;
        let length = (start + text.len() + 1).next_multiple_of(64) - start;
        let mut bytes = MAGIC.to_vec();
        bytes.extend([1, 0]);
        bytes.extend((length as u16).to_le_bytes());
        bytes.extend(format!("{text:width$}\n", width = length - 1).as_bytes());
        bytes
    }
}

impl DType {
    fn new(descr: &Literal) -> Option<Self> {
        match descr {
            Literal::Text(name) => Some(Self::Plain(name.clone())),
            Literal::List(fields) => fields.iter().map(Field::new).collect::<Option<_>>().map(Self::Record),
            _ => None,
        }
    }

    /// Bytes per value; `None` if they are not fixed (Python objects) or exceed any memory.
    pub fn bytes(&self) -> Option<usize> {
        match self {
            Self::Plain(name) => {
                let kind = name.chars().nth(1)?;
                // `<M8[ns]` ends with a unit.
                let digits = name.get(2..)?.split('[').next()?;
                let size: usize = digits.parse().ok()?;
                // Text is counted in characters of four bytes.
                size.checked_mul(if kind == 'U' { 4 } else { 1 })
            }
            Self::Array(count, inner) => inner.bytes()?.checked_mul(usize::try_from(*count).ok()?),
            Self::Record(fields) => fields.iter().try_fold(0usize, |sum, field| sum.checked_add(field.dtype.bytes()?)),
        }
    }
}

impl DType {
    /// The type of numbers that it is one of, if it is.
    pub fn scalar(&self) -> Option<Scalar> {
        if let Self::Plain(name) = self { Scalar::of_numpy(name) } else { None }
    }
}

impl Display for DType {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plain(name) => quote(name).fmt(f),
            Self::Array(count, inner) => write!(f, "{count} x {inner}"),
            Self::Record(_) => f.write_str("records"),
        }
    }
}

impl Field {
    /// `(name, type)` or `(name, type, shape)`; the name may be `(title, name)`.
    fn new(field: &Literal) -> Option<Self> {
        let Literal::List(parts) = field else { return None };
        let (name, descr, shape) = match &parts[..] {
            [name, descr] => (name, descr, None),
            [name, descr, shape] => (name, descr, Some(shape)),
            _ => return None,
        };
        let name = match name {
            Literal::Text(name) => name,
            Literal::List(pair) => match &pair[..] {
                [Literal::Text(_), Literal::Text(name)] => name,
                _ => return None,
            },
            _ => return None,
        };
        let sides = match shape {
            None => Vec::new(),
            Some(Literal::List(sides)) => sides.iter().map(Literal::number).collect::<Option<_>>()?,
            Some(side) => vec![side.number()?],
        };
        let array = |inner, side: &u64| DType::Array(*side, Box::new(inner));
        Some(Self { name: name.clone(), dtype: sides.iter().rev().fold(DType::new(descr)?, array) })
    }
}

#[cfg(test)]
mod tests;
