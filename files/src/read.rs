//! Readers of scene files. A file is a whole scene (TOML, NFF) or particles, frame by frame, that the style turns into
//! spheres. Given rays are read block by block.

pub mod cameras;
mod columns;
mod csv;
mod detect;
mod foreign;
mod format;
mod held;
pub mod info;
mod input;
mod lines;
mod native;
mod nff;
mod npy;
mod options;
mod particles;
pub mod rays;
mod select;
mod sequence;
mod source;
mod stream;
pub mod style;

use crate::error::Result;
use crate::scene::Scene;
use std::path::Path;

pub use columns::{Codes, ColumnValues, Columns};
pub use format::Format;
pub use held::HeldCamera;
pub use info::info;
pub use options::{Altloc, ColumnNames, FrameRange, Hold, Keep, ReadOptions};
pub use particles::{FrameTime, NamedAtoms, NamedElements, Periodic, Survey, elements_of_names};
pub use select::selection::Selection;
pub use sequence::{Mark, SceneFrame, Sequence};
pub use stream::SphereBlocks;
pub use style::Style;

/// Reads a scene file, or standard input when `path` is `-`, uncompressed or compressed with gzip or bzip2. The
/// format is detected from the content, then from the name. Of a sequence, the first selected frame is read.
///
/// Ids count the spheres from 0 in the file's order, also in errors. A file without a camera gets one that shows
/// all of it.
///
/// # Errors
/// [`Error::Io`](crate::Error::Io) for a file that cannot be read, [`Error::Scene`](crate::Error::Scene) for content that is not a scene,
/// [`Error::Settings`](crate::Error::Settings) for options that do not apply to it.
pub fn scene(path: &Path, options: &ReadOptions) -> Result<Scene> {
    let mut sequence = Sequence::open(path, options)?;
    let first = sequence.next_scene()?;
    first.map(|frame| frame.scene).ok_or_else(|| sequence.nothing())
}
