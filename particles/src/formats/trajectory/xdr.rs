//! Numbers of XDR, the encoding of GROMACS files (RFC 4506): big-endian, in words of four bytes.

use crate::npy::header::Scalar;
use crate::particles::bytes::{BinaryFile, DAMAGED};
use halfline_ground::Cell;
use halfline_ground::error::Result;
use halfline_ground::memory::{check_ids, reserve};

/// Ångström per nanometre.
pub(super) const NANOMETRE: f64 = 10.0;

/// The real numbers of a file.
pub(super) const SINGLE: Scalar = Scalar::float(4, true);
pub(super) const DOUBLE: Scalar = Scalar::float(8, true);

/// A whole number.
pub(super) fn int(file: &mut BinaryFile, field: &str) -> Result<i32> {
    file.bytes(field).map(i32::from_be_bytes)
}

/// A number of atoms.
///
/// # Errors
/// Negative numbers, and more atoms than ids can number.
pub(super) fn atoms(file: &mut BinaryFile) -> Result<u64> {
    let (field, at) = ("number of atoms", file.at());
    let count = int(file, field)?;
    let wrong = || file.fail(at, field, format!("{count} atoms"), DAMAGED);
    let count = u64::try_from(count).map_err(|_| wrong())?;
    check_ids(count)?;
    Ok(count)
}

/// A real number.
pub(super) fn real(file: &mut BinaryFile, of: Scalar, field: &str) -> Result<f64> {
    let mut bytes = [0; 8];
    file.fill(&mut bytes[..of.size()], field)?;
    Ok(of.number(&bytes))
}

/// `count` vectors of three numbers, each multiplied by `unit`.
pub(super) fn vectors(file: &mut BinaryFile, count: u64, of: Scalar, unit: f64, field: &str) -> Result<Vec<[f64; 3]>> {
    let (mut vectors, mut bytes, size) = (Vec::new(), [0; 24], of.size());
    for _ in 0..count {
        file.fill(&mut bytes[..3 * size], field)?;
        reserve(&mut vectors, 1)?;
        vectors.push([0, 1, 2].map(|k| of.number(&bytes[k * size..]) * unit));
    }
    Ok(vectors)
}

/// The box of a frame, three vectors in nanometres; `None` where it is zero.
///
/// # Errors
/// Infinite numbers and NaN.
pub(super) fn cell(file: &mut BinaryFile, of: Scalar) -> Result<Option<Cell>> {
    let at = file.at();
    let edges: [[f64; 3]; 3] = vectors(file, 3, of, NANOMETRE, "box")?.try_into().unwrap_or_default();
    if !edges.iter().flatten().all(|x| x.is_finite()) {
        return Err(file.fail(at, "box", "a number of the box is not finite", DAMAGED));
    }
    let is_some = edges.iter().flatten().any(|x| *x != 0.0);
    Ok(is_some.then_some(Cell { origin: [0.0; 3], edges }))
}
