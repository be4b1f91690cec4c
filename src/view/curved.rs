//! The viewing rays of a curved lens: the rays of a window, computed once for each sample.

use super::records::ViewRecord;
use crate::scene::camera::CurvedFrame;
use halfline_ground::parallel;

/// The viewing rays of a curved lens.
#[derive(Debug, Clone)]
pub(crate) struct CurvedView {
    pub(super) frame: CurvedFrame,
    /// The direction of each pixel's ray in the canonical camera, for the record's sample; zero where there is none.
    directions: Vec<[f64; 3]>,
}

impl CurvedView {
    pub(super) fn new(frame: CurvedFrame, record: &ViewRecord) -> Self {
        let direction = |pixel: usize| frame.direction(record.position(pixel as u32));
        Self { frame, directions: parallel::from_fn(record.pixels(), direction) }
    }

    /// The direction of the ray of a row and a column of the record's frame, the place of a sample of a pixel of the window.
    pub(super) fn direction(&self, record: &ViewRecord, place: [u32; 2]) -> [f64; 3] {
        let [row, column] = record.pixel_of(place);
        let pixel = (row - record.first_row) * record.columns + column - record.first_column;
        self.directions[pixel as usize]
    }

    /// The number of pixels without a ray.
    pub(crate) fn without_ray(&self) -> usize {
        self.directions.iter().filter(|direction| **direction == [0.0; 3]).count()
    }

    /// The direction of each pixel's ray in the canonical camera.
    pub(crate) fn directions(&self) -> &[[f64; 3]] {
        &self.directions
    }
}
