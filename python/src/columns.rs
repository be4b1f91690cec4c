//! Columns of files as arrays.

use crate::arrays::{owned, shown};
use halfline_command::choices::in_keywords;
use halfline_files::read::{Codes, ColumnValues, Columns};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;

/// The numbers of a column, by the word of a selection; of a column of texts the number of each, and the texts.
///
/// # Errors
/// `KeyError` for a word without a column.
///
/// # Safety
/// `columns` belong to `owner`, which does not change or move them as long as it lives.
#[expect(unsafe_code, reason = "arrays of the memory of the owner")]
pub(crate) unsafe fn column<'py>(
    columns: &Columns,
    word: &str,
    owner: Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyAny>, Option<Vec<String>>)> {
    let (_, values) = columns.get(word).map_err(|error| PyKeyError::new_err(in_keywords(&error.to_string())))?;
    let py = owner.py();
    // SAFETY: the caller's promise.
    let array = unsafe {
        match values {
            ColumnValues::Numbers(values) => shown(values, &[values.len()], owner)?.into_any(),
            ColumnValues::Whole(values) => shown(values, &[values.len()], owner)?.into_any(),
            ColumnValues::Order(count) => owned(py, (0..*count as i32).collect(), &[*count])?.into_any(),
            ColumnValues::Texts(Codes::U8(codes), _) => shown(codes, &[codes.len()], owner)?.into_any(),
            ColumnValues::Texts(Codes::U16(codes), _) => shown(codes, &[codes.len()], owner)?.into_any(),
            ColumnValues::Texts(Codes::U32(codes), _) => shown(codes, &[codes.len()], owner)?.into_any(),
        }
    };
    let texts = if let ColumnValues::Texts(_, texts) = values { Some(texts.clone()) } else { None };
    Ok((array, texts))
}
