//! Numbers in binary files: what PLY and NumPy call their types, and how each is read.

use crate::scene::style::linear;
use std::sync::LazyLock;

/// A type of number in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Scalar {
    kind: Kind,
    /// 1, 2, 4 or 8 bytes.
    size: usize,
    big: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Signed,
    Unsigned,
    Float,
}

impl Scalar {
    /// A type of a PLY header.
    pub(crate) fn of_ply(name: &str, big: bool) -> Option<Self> {
        let (kind, size) = match name {
            "char" | "int8" => (Kind::Signed, 1),
            "uchar" | "uint8" => (Kind::Unsigned, 1),
            "short" | "int16" => (Kind::Signed, 2),
            "ushort" | "uint16" => (Kind::Unsigned, 2),
            "int" | "int32" => (Kind::Signed, 4),
            "uint" | "uint32" => (Kind::Unsigned, 4),
            "float" | "float32" => (Kind::Float, 4),
            "double" | "float64" => (Kind::Float, 8),
            _ => return None,
        };
        Some(Self { kind, size, big })
    }

    /// A type string of NumPy, such as `<f8`; `None` for what is not a real number, for halves, and for the long doubles
    /// of some processors.
    pub(crate) fn of_numpy(name: &str) -> Option<Self> {
        let (order, rest) = name.split_at_checked(1)?;
        let (kind, size) = rest.split_at_checked(1)?;
        let kind = match kind {
            "i" => Kind::Signed,
            "u" | "b" => Kind::Unsigned,
            "f" => Kind::Float,
            _ => return None,
        };
        let size = size.parse().ok()?;
        let sizes: &[usize] = if kind == Kind::Float { &[4, 8] } else { &[1, 2, 4, 8] };
        let big = match order {
            "<" => false,
            ">" => true,
            // A single byte has no order.
            "|" if size == 1 => false,
            _ => return None,
        };
        sizes.contains(&size).then_some(Self { kind, size, big })
    }

    /// Bytes of one.
    pub(crate) fn size(self) -> usize {
        self.size
    }

    /// A component of a colour as linear light: bytes are sRGB, other numbers are linear already.
    pub(crate) fn light(self, number: f64) -> f64 {
        // A table once, not a power for every point.
        static LIGHT: LazyLock<Vec<f64>> =
            LazyLock::new(|| (0..=255).map(|level| f64::from(linear([level; 3])[0])).collect());
        if self.kind == Kind::Unsigned && self.size == 1 { LIGHT[number as usize & 255] } else { number }
    }

    /// Whether it has no fractions.
    pub(crate) fn is_whole(self) -> bool {
        self.kind != Kind::Float
    }

    /// The number in these bytes, of which there are [`Scalar::size`]; whole numbers beyond 2^53 are rounded.
    pub(crate) fn number(self, bytes: &[u8]) -> f64 {
        let mut little = [0; 8];
        little[..self.size].copy_from_slice(&bytes[..self.size]);
        if self.big {
            little[..self.size].reverse();
        }
        let whole = u64::from_le_bytes(little);
        let unused = 64 - 8 * self.size as u32;
        match self.kind {
            Kind::Unsigned => whole as f64,
            Kind::Signed => ((whole << unused) as i64 >> unused) as f64,
            Kind::Float if self.size == 4 => f64::from(f32::from_bits(whole as u32)),
            Kind::Float => f64::from_bits(whole),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            ("<f2", None),
            ("<c16", None),
            ("|S4", None),
            ("|f8", None),
            ("f8", None),
            ("", None),
            ("\u{fc}", None),
        ] {
            let found = Scalar::of_numpy(name);
            assert_eq!(found.map(Scalar::size), size, "{name}");
        }
    }
}
