//! The buffers of a file.

use halfline::frame::array::Array;

/// A buffer of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedBuffer {
    /// Its name in the file, such as `depth`; `None` where the file has none.
    pub name: Option<String>,
    /// Its values.
    pub array: Array,
}

/// A file's buffers.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameFile {
    /// The file's name, for messages.
    pub name: String,
    /// The buffers in the file's order.
    pub buffers: Vec<NamedBuffer>,
    /// Column and row of the first pixel in the full frame, where the format stores it.
    pub origin: Option<[i32; 2]>,
}
