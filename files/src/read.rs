//! Readers of scene files. A file is a whole scene (TOML, NFF) or particles, frame by frame, that the style turns into
//! spheres. Given rays are read block by block.

pub mod cameras;
mod clip;
pub mod cut;
mod fixed_camera;
pub mod info;
pub mod mark;
pub mod matte;
mod native;
mod nff;
mod options;
mod paint;
pub mod rays;
mod sequence;
mod sphere_lights;
mod stream;
pub mod style;

use halfline::error::Result;
use std::path::Path;

pub use fixed_camera::FixedCamera;
pub use halfline_particles::input::read_once;
pub use halfline_particles::particles::survey::Survey;
pub use halfline_particles::{
    Altloc, AtomStyle, Codes, ColumnNames, ColumnValue, ColumnValues, Columns, Format, FrameRange, FrameTime, Identity,
    Keep, NamedAtoms, NamedElements, ParticleOptions, Periodic, Selection, Skipped, elements, elements_of_names,
};
pub use info::{info, info_from_reader};
pub use options::{Hold, ReadOptions};
pub use sequence::{Focus, SceneFrame, Sequence, all_clipped};
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
