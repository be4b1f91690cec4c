#![doc = include_str!("../README.md")]

mod cell;
pub mod check;
pub mod error;
pub mod memory;
mod operator;
pub mod parallel;
pub mod progress;
pub mod quote;
mod shared;
pub mod srgb;
pub mod trailer;

pub use cell::Cell;
pub use error::{Error, Result};
pub use operator::Operator;
pub use progress::{Cancel, Progress, Step, Watch};
pub use shared::Shared;
