//! Numbers in binary files: the type names of PLY and NumPy, and their decoding.

/// A binary number type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scalar {
    pub kind: NumberKind,
    /// 1, 2, 4 or 8 bytes.
    size: usize,
    /// Whether the most significant byte comes first.
    pub big: bool,
}

/// The kind of a binary number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumberKind {
    Bool,
    Signed,
    Unsigned,
    Float,
}

impl Scalar {
    /// The type with this name in a PLY header.
    pub fn of_ply(name: &str, big: bool) -> Option<Self> {
        let (kind, size) = match name {
            "char" | "int8" => (NumberKind::Signed, 1),
            "uchar" | "uint8" => (NumberKind::Unsigned, 1),
            "short" | "int16" => (NumberKind::Signed, 2),
            "ushort" | "uint16" => (NumberKind::Unsigned, 2),
            "int" | "int32" => (NumberKind::Signed, 4),
            "uint" | "uint32" => (NumberKind::Unsigned, 4),
            "float" | "float32" => (NumberKind::Float, 4),
            "double" | "float64" => (NumberKind::Float, 8),
            _ => return None,
        };
        Some(Self { kind, size, big })
    }

    /// A type string of NumPy, such as `<f8`; `None` for what is not a real number, and for the long doubles of some processors.
    pub fn of_numpy(name: &str) -> Option<Self> {
        let (order, rest) = name.split_at_checked(1)?;
        let (kind, size) = rest.split_at_checked(1)?;
        let kind = match kind {
            "i" => NumberKind::Signed,
            "u" => NumberKind::Unsigned,
            "b" => NumberKind::Bool,
            "f" => NumberKind::Float,
            _ => return None,
        };
        let size = size.parse().ok()?;
        let sizes: &[usize] = match kind {
            NumberKind::Bool => &[1],
            NumberKind::Float => &[2, 4, 8],
            _ => &[1, 2, 4, 8],
        };
        let big = match order {
            "<" => false,
            ">" => true,
            // A single byte has no order.
            "|" if size == 1 => false,
            _ => return None,
        };
        sizes.contains(&size).then_some(Self { kind, size, big })
    }

    /// Numbers of this kind, of 1, 2, 4 or 8 bytes.
    pub const fn of(kind: NumberKind, size: usize, big: bool) -> Self {
        Self { kind, size, big }
    }

    /// Floats of 4 or 8 bytes.
    pub const fn float(size: usize, big: bool) -> Self {
        Self { kind: NumberKind::Float, size, big }
    }

    /// Whole numbers without a sign, of 1, 2, 4 or 8 bytes.
    pub const fn unsigned(size: usize, big: bool) -> Self {
        Self { kind: NumberKind::Unsigned, size, big }
    }

    /// Bytes per number.
    pub fn size(self) -> usize {
        self.size
    }

    /// The three levels of a packed colour, 0xRRGGBB, of these 4 bytes.
    pub fn levels(self, bytes: &[u8]) -> [f64; 3] {
        let bytes = bytes.first_chunk().copied().unwrap_or_default();
        levels(if self.big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    /// Whether it is a type of floats.
    pub fn is_float(self) -> bool {
        self.kind == NumberKind::Float
    }

    /// Whether it is an integer type.
    pub fn is_whole(self) -> bool {
        self.kind != NumberKind::Float
    }

    /// Appends the numbers that some fields begin with. The types of most files are constants of their loops.
    pub(crate) fn extend<'a>(self, fields: impl Iterator<Item = &'a [u8]>, numbers: &mut Vec<f64>) {
        fn of<'a, const N: usize>(
            fields: impl Iterator<Item = &'a [u8]>,
            numbers: &mut Vec<f64>,
            number: impl Fn([u8; N]) -> f64,
        ) {
            numbers.extend(fields.map(|bytes| number(*bytes.first_chunk().unwrap_or(&[0; N]))));
        }
        match (self.kind, self.size, self.big) {
            (NumberKind::Float, 4, false) => of(fields, numbers, |bytes| f64::from(f32::from_le_bytes(bytes))),
            (NumberKind::Float, 8, false) => of(fields, numbers, f64::from_le_bytes),
            (NumberKind::Unsigned, 1, _) => of(fields, numbers, |[byte]: [u8; 1]| f64::from(byte)),
            (NumberKind::Unsigned, 2, false) => of(fields, numbers, |bytes| f64::from(u16::from_le_bytes(bytes))),
            (NumberKind::Signed, 4, false) => of(fields, numbers, |bytes| f64::from(i32::from_le_bytes(bytes))),
            _ => numbers.extend(fields.map(|bytes| self.number(bytes))),
        }
    }

    /// Decodes [`Scalar::size`] bytes; whole numbers above 2^53 are rounded.
    pub fn number(self, bytes: &[u8]) -> f64 {
        let mut little = [0; 8];
        little[..self.size].copy_from_slice(&bytes[..self.size]);
        if self.big {
            little[..self.size].reverse();
        }
        let whole = u64::from_le_bytes(little);
        let unused = 64 - 8 * self.size as u32;
        match self.kind {
            NumberKind::Bool | NumberKind::Unsigned => whole as f64,
            NumberKind::Signed => ((whole << unused) as i64 >> unused) as f64,
            NumberKind::Float if self.size == 2 => half(whole as u16),
            NumberKind::Float if self.size == 4 => f64::from(f32::from_bits(whole as u32)),
            NumberKind::Float => f64::from_bits(whole),
        }
    }
}

/// The number of these bits of float16 (IEEE 754-2008, binary16: a sign, 5 bits of exponent, 10 of fraction).
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (bits >> 10 & 0x1f, f64::from(bits & 0x3ff) / 1024.0);
    let size = match exponent {
        0 => fraction * 2f64.powi(-14),
        0x1f if fraction == 0.0 => f64::INFINITY,
        0x1f => f64::NAN,
        exponent => (1.0 + fraction) * 2f64.powi(i32::from(exponent) - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
}

/// The three levels of a packed colour, 0xRRGGBB.
pub fn levels(bits: u32) -> [f64; 3] {
    let [_, red, green, blue] = bits.to_be_bytes();
    [red, green, blue].map(f64::from)
}

/// The bits of a packed colour that is written as a number of this type.
pub fn bits(number: f64, of: Scalar) -> u32 {
    if of.is_whole() { number as i64 as u32 } else { (number as f32).to_bits() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some by the tables of the standard, and all by the spacing of their exponent.
    #[test]
    fn halves_are_those_of_ieee_754() {
        for (bits, number) in [
            (0x0000, 0.0),
            (0x0001, 2f64.powi(-24)),
            (0x03ff, 1023.0 * 2f64.powi(-24)),
            (0x0400, 2f64.powi(-14)),
            (0x3555, 0.333_251_953_125),
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x7c00, f64::INFINITY),
            (0xfc00, f64::NEG_INFINITY),
        ] {
            assert_eq!(half(bits), number, "{bits:x}");
        }
        assert!(half(0x7e00).is_nan() && half(0x8000).to_bits() == (-0.0f64).to_bits());
        for bits in 0..0x7bff_u16 {
            let step = 2f64.powi(i32::from((bits >> 10).max(1)) - 25);
            assert_eq!(half(bits + 1) - half(bits), step, "{bits:x}");
        }
        let read = |name: &str, bytes: [u8; 2]| Scalar::of_numpy(name).expect(name).number(&bytes);
        assert_eq!((read("<f2", [0, 0x3c]), read(">f2", [0x3c, 0])), (1.0, 1.0));
    }

    #[test]
    fn numbers_are_read_in_both_byte_orders() {
        for (name, bytes, number) in [
            ("char", vec![0xff], -1.0),
            ("uchar", vec![0xff], 255.0),
            ("short", (-300i16).to_be_bytes().to_vec(), -300.0),
            ("uint16", 65000u16.to_be_bytes().to_vec(), 65000.0),
            ("int", (-70000i32).to_be_bytes().to_vec(), -70000.0),
            ("uint", u32::MAX.to_be_bytes().to_vec(), 4294967295.0),
            ("float", 0.1f32.to_be_bytes().to_vec(), f64::from(0.1f32)),
            ("double", (-1e-300f64).to_be_bytes().to_vec(), -1e-300),
        ] {
            let mut little = bytes.clone();
            little.reverse();
            let read = |big, bytes: &[u8]| Scalar::of_ply(name, big).expect(name).number(bytes);
            assert_eq!((read(true, &bytes), read(false, &little)), (number, number), "{name}");
        }
        for (name, size) in [
            ("<f8", Some(8)),
            (">i2", Some(2)),
            ("|u1", Some(1)),
            ("|b1", Some(1)),
            ("<f2", Some(2)),
            ("<c16", None),
            ("|S4", None),
            ("|f8", None),
            ("<b2", None),
            ("f8", None),
            ("", None),
            ("\u{fc}", None),
        ] {
            let found = Scalar::of_numpy(name);
            assert_eq!(found.map(Scalar::size), size, "{name}");
        }
    }
}
