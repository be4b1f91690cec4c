//! A frame of a trajectory, and the trait of its decoders.

use crate::particles::frame_time::FrameTime;
use halfline_ground::Cell;
use halfline_ground::error::Result;

/// A frame of a trajectory.
#[derive(Debug, Default)]
pub(super) struct Moment {
    /// Positions, ångström.
    pub(super) positions: Vec<[f64; 3]>,
    /// Whether the file has velocities.
    pub(super) has_velocities: bool,
    /// Velocities in the unit of the file; empty where they are not read.
    pub(super) velocities: Vec<[f64; 3]>,
    pub(super) cell: Option<Cell>,
    /// Picoseconds, and the step.
    pub(super) when: FrameTime,
}

/// A decoder of trajectories.
pub(super) trait Moments: Send {
    /// The next frame with positions; `None` after the last.
    ///
    /// # Errors
    /// [`Error::Scene`] with the byte, [`Error::Limits`], [`Error::Io`].
    fn next(&mut self) -> Result<Option<Moment>>;

    /// Skips the next frame with positions, undecoded; returns `false` after the last.
    ///
    /// # Errors
    /// As [`Moments::next`].
    fn skip(&mut self) -> Result<bool>;
}
