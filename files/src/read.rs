//! Readers of scene files. A file is a whole scene (TOML, NFF) or particles, frame by frame, that the style turns into
//! spheres. Given rays are read block by block.

pub mod cameras;
mod clip;
mod color;
mod columns;
mod csv;
mod derived;
mod detect;
pub mod elements;
mod fixed_camera;
mod foreign;
mod format;
mod frame_range;
mod gauge;
pub mod info;
mod input;
mod lines;
pub mod mark;
pub mod matte;
mod native;
mod near;
mod nearest;
mod nff;
mod npy;
mod open;
mod options;
mod packed;
mod paint;
mod particles;
pub mod rays;
mod select;
mod sequence;
mod skipped;
mod source;
mod sphere_lights;
mod stream;
pub mod style;

use halfline::error::Result;
use std::path::Path;

pub use columns::{Codes, ColumnValue, ColumnValues, Columns};
pub use fixed_camera::FixedCamera;
pub use format::Format;
pub use frame_range::FrameRange;
pub use info::{info, info_from_reader};
pub use input::read_once;
pub use options::{Hold, Keep, ReadOptions};
pub use particles::column_names::ColumnNames;
pub use particles::data::style::AtomStyle;
pub use particles::frame_time::FrameTime;
pub use particles::identity::Identity;
pub use particles::infer::slices::{NamedAtoms, NamedElements, elements_of_names};
pub use particles::periodic::Periodic;
pub use particles::request::Altloc;
pub use particles::survey::Survey;
pub use select::selection::Selection;
pub use sequence::{Focus, SceneFrame, Sequence, all_clipped};
pub use skipped::Skipped;
pub use stream::SphereBlocks;
pub use style::Style;

/// Reads a scene file, or standard input when `path` is `-`, uncompressed or compressed with gzip, bzip2, xz or Zstandard. The
/// format is detected from the content, then from the name. Of a sequence, the first selected frame is read.
///
/// Ids count the spheres from 0 in the file's order, also in errors. A file without a camera gets one that shows all of
/// it.
///
/// # Errors
/// [`Error::Io`](halfline::Error::Io) for a file that cannot be read, [`Error::Scene`](halfline::Error::Scene) for content that
/// is not a scene, [`Error::Settings`](halfline::Error::Settings) for options that do not apply to it.
pub fn scene(path: &Path, options: &ReadOptions) -> Result<SceneFrame> {
    let mut sequence = Sequence::open(path, options)?;
    sequence.next_scene()?.ok_or_else(|| sequence.nothing())
}
