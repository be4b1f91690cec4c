//! Arrays of numbers read from files.

use halfline_ground::error::{Error, Result};
use std::fmt;

/// An array of numbers as a file holds it, from halfline or another program.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    name: String,
    shape: Vec<usize>,
    values: Values,
    picture: bool,
}

/// The values of an [`Array`], in C order.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Values {
    /// PNG of 8 bits, masks.
    U8(Vec<u8>),
    /// PNG of 16 bits.
    U16(Vec<u16>),
    /// Ids.
    I32(Vec<i32>),
    /// Wider integers, from other programs.
    I64(Vec<i64>),
    /// Colour, normal.
    F32(Vec<f32>),
    /// Distance, depth, position, bound.
    F64(Vec<f64>),
}

impl Values {
    /// The number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(values) => values.len(),
            Self::U16(values) => values.len(),
            Self::I32(values) => values.len(),
            Self::I64(values) => values.len(),
            Self::F32(values) => values.len(),
            Self::F64(values) => values.len(),
        }
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Their type, as NumPy names it.
    pub fn dtype(&self) -> &'static str {
        match self {
            Self::U8(_) => "uint8",
            Self::U16(_) => "uint16",
            Self::I32(_) => "int32",
            Self::I64(_) => "int64",
            Self::F32(_) => "float32",
            Self::F64(_) => "float64",
        }
    }

    /// The value at `index`, exactly; `None` past the end.
    pub fn get(&self, index: usize) -> Option<ArrayValue> {
        match self {
            Self::U8(values) => values.get(index).map(|x| ArrayValue::Int((*x).into())),
            Self::U16(values) => values.get(index).map(|x| ArrayValue::Int((*x).into())),
            Self::I32(values) => values.get(index).map(|x| ArrayValue::Int((*x).into())),
            Self::I64(values) => values.get(index).map(|x| ArrayValue::Int(*x)),
            Self::F32(values) => values.get(index).map(|x| ArrayValue::Float((*x).into())),
            Self::F64(values) => values.get(index).map(|x| ArrayValue::Float(*x)),
        }
    }
}

/// One value of an [`Array`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ArrayValue {
    /// A value of an integer type.
    Int(i64),
    /// A value of a floating-point type.
    Float(f64),
}

impl ArrayValue {
    /// The nearest f64; exact for integers up to 2^53.
    pub fn to_f64(self) -> f64 {
        match self {
            Self::Int(x) => x as f64,
            Self::Float(x) => x,
        }
    }
}

impl fmt::Display for ArrayValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Int(x) => write!(f, "{x}"),
            // Debug uses exponents where Display writes three hundred digits.
            Self::Float(x) => write!(f, "{x:?}"),
        }
    }
}

/// The number of values of a shape; `None` if any product of its sides overflows, even where a side is 0.
pub(crate) fn count(shape: &[usize]) -> Option<usize> {
    let nonzero = shape.iter().filter(|side| **side > 0).try_fold(1usize, |n, side| n.checked_mul(*side))?;
    Some(if shape.contains(&0) { 0 } else { nonzero })
}

impl Array {
    /// An array of plain numbers; messages refer to it by `name`.
    ///
    /// # Errors
    /// [`Error::Settings`] if the shape holds another number of values.
    pub fn new(name: impl Into<String>, shape: Vec<usize>, values: Values) -> Result<Self> {
        if count(&shape) != Some(values.len()) {
            let problem = format!("found {} values for the shape {shape:?}", values.len());
            return Err(Error::settings(problem, "use as many values as the shape holds"));
        }
        Ok(Self { name: name.into(), shape, values, picture: false })
    }

    /// Marks the values as levels of a picture: 0 is black, the maximum of their type is white.
    pub fn picture(mut self) -> Self {
        self.picture = true;
        self
    }

    /// The file's name, for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The shape, slowest dimension first.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// The values, in C order.
    pub fn values(&self) -> &Values {
        &self.values
    }

    /// Whether it was read from a picture, so that its values are levels: 0 is black, the maximum of their type white.
    pub fn is_picture(&self) -> bool {
        self.picture
    }

    /// Rows, columns and values per pixel. A list is one row; axes after the second are components.
    pub fn layout(&self) -> [usize; 3] {
        match &self.shape[..] {
            [] => [1, 1, 1],
            [columns] => [1, *columns, 1],
            [rows, columns, components @ ..] => [*rows, *columns, components.iter().product()],
        }
    }
}
