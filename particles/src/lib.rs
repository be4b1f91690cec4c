#![doc = include_str!("../README.md")]
#![cfg_attr(
    not(feature = "formats"),
    expect(dead_code, reason = "the readers that are left out use some of what all share")
)]

#[doc(hidden)]
pub mod blocks;
#[doc(hidden)]
pub mod color;
mod columns;
#[doc(hidden)]
pub mod csv;
#[doc(hidden)]
pub mod derived;
#[doc(hidden)]
pub mod detect;
pub mod elements;
mod foreign;
mod format;
#[doc(hidden)]
pub mod formats;
mod frame_range;
mod frames;
mod gauge;
#[doc(hidden)]
pub mod input;
#[doc(hidden)]
pub mod lines;
mod near;
#[doc(hidden)]
pub mod nearest;
#[doc(hidden)]
pub mod npy;
#[doc(hidden)]
pub mod open;
#[doc(hidden)]
pub mod opened;
mod options;
#[doc(hidden)]
pub mod packed;
#[doc(hidden)]
pub mod particles;
#[doc(hidden)]
pub mod select;
mod signs;
mod skipped;
#[doc(hidden)]
pub mod source;
#[doc(hidden)]
pub mod spheres;

pub use columns::{Codes, ColumnValue, ColumnValues, Columns};
pub use format::Format;
#[doc(hidden)]
pub use format::ending;
pub use formats::data::style::AtomStyle;
pub use frame_range::FrameRange;
pub use frames::Frames;
pub use halfline_ground::{Cancel, Cell, Error, Operator, Result, Watch};
pub use options::{Keep, ParticleOptions};
pub use particles::column_names::ColumnNames;
pub use particles::frame::{Column, Particles};
pub use particles::frame_time::FrameTime;
pub use particles::identity::Identity;
pub use particles::infer::slices::{NamedAtoms, NamedElements, elements_of_names};
pub use particles::periodic::Periodic;
pub use particles::placed::PlacedPart;
pub use particles::request::Altloc;
pub use select::selection::Selection;
pub use skipped::Skipped;
