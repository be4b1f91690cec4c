//! Arrays of NumPy as slices of the library, and buffers of the library as arrays, both without a copy.

use halfline::scene::List;
use numpy::ndarray::{ArrayView, IxDyn};
use numpy::{Element, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::prelude::*;
use std::sync::Arc;

/// The values of an array that belongs to Python, which lives as long as this.
struct Foreign<T> {
    values: *const T,
    count: usize,
    _owner: Py<PyAny>,
}

#[expect(unsafe_code, reason = "a pointer to numbers that nobody moves")]
// SAFETY: it gives shared access to plain numbers only, and Py may be dropped by any thread. Python code must not write to
// the array while a rendering reads it, as the documentation of Scene says.
unsafe impl<T: Sync> Send for Foreign<T> {}

#[expect(unsafe_code, reason = "a pointer to numbers that nobody moves")]
// SAFETY: as above.
unsafe impl<T: Sync> Sync for Foreign<T> {}

impl<T> AsRef<[T]> for Foreign<T> {
    fn as_ref(&self) -> &[T] {
        #[expect(unsafe_code, reason = "the memory belongs to NumPy")]
        // SAFETY: `list` checked pointer, alignment and length; the owner keeps the memory, and an array that is
        // referenced elsewhere refuses to be resized.
        unsafe {
            std::slice::from_raw_parts(self.values, self.count)
        }
    }
}

/// Plain numbers that consist of `N` values of an array.
pub(crate) trait Plain<E, const N: usize>: Sync + 'static {}
impl Plain<f64, 3> for [f64; 3] {}
impl Plain<f32, 3> for [f32; 3] {}
impl Plain<f64, 1> for f64 {}
impl Plain<f32, 1> for f32 {}
impl Plain<i32, 1> for i32 {}
impl Plain<u8, 1> for u8 {}

/// The rows of a contiguous array as a list that shares its memory.
///
/// # Errors
/// `ValueError` for an array that the package has not made contiguous.
pub(crate) fn list<E: Element, T: Plain<E, N> + Clone, const N: usize>(
    array: &PyReadonlyArrayDyn<'_, E>,
) -> PyResult<List<T>> {
    let (values, count) = (array.data().cast::<T>(), array.len() / N);
    if !array.is_c_contiguous() || !values.is_aligned() || count * N != array.len() {
        return Err(PyValueError::new_err("the array is not contiguous"));
    }
    if count == 0 {
        return Ok(List::default());
    }
    let owner = array.as_any().clone().unbind();
    Ok(List::shared(Arc::new(Foreign { values, count, _owner: owner })))
}

/// A read-only array of the memory of `owner`, which it keeps alive.
///
/// # Safety
/// `values` belong to `owner`, which does not change or move them as long as it lives.
#[expect(unsafe_code, reason = "borrow_from_array cannot check that the values belong to the owner")]
pub(crate) unsafe fn shown<'py, T: Element>(
    values: &[T],
    shape: &[usize],
    owner: Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let view = ArrayView::from_shape(IxDyn(shape), values).map_err(|e| PyMemoryError::new_err(e.to_string()))?;
    // SAFETY: the caller's promise.
    let array = unsafe { PyArrayDyn::borrow_from_array(&view, owner) };
    // The flag cannot be set again from Python, because the array does not own its memory.
    array.readwrite().make_nonwriteable();
    Ok(array)
}

/// An array that takes the memory of a vector.
pub(crate) fn owned<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    numpy::PyArray1::from_vec(py, values).reshape(shape)
}
