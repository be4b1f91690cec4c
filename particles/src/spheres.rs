//! Spheres as tables and arrays list them, row by row.

use halfline_ground::error::Result;
use halfline_ground::memory::{entries, extend_to};

/// Centres, radii and colours in the order of the rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SphereRows {
    /// Centres.
    pub centers: Vec<[f64; 3]>,
    /// Radii, one for each centre.
    pub radii: Vec<f64>,
    /// Linear RGB of each row that was read; empty where the rows have no colours.
    pub colors: Vec<[f32; 3]>,
}

impl SphereRows {
    /// The number of spheres.
    #[must_use]
    pub fn len(&self) -> usize {
        self.centers.len()
    }

    /// Whether there are no spheres.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.centers.is_empty()
    }

    /// Reserves capacity for `more` spheres, with or without colours.
    ///
    /// # Errors
    /// [`Error::Limits`](halfline_ground::Error::Limits) where memory is short.
    pub fn grow(&mut self, more: usize, colored: bool) -> Result<()> {
        let fits = |capacity: usize, len: usize| capacity - len >= more;
        let has_room =
            fits(self.centers.capacity(), self.centers.len()) && fits(self.radii.capacity(), self.radii.len());
        if has_room && (!colored || fits(self.colors.capacity(), self.colors.len())) {
            return Ok(());
        }
        let each = size_of::<[f64; 3]>() + size_of::<f64>() + if colored { size_of::<[f32; 3]>() } else { 0 };
        let entries = entries(self.len(), more, each, "spheres")?;
        extend_to(&mut self.centers, entries)?;
        extend_to(&mut self.radii, entries)?;
        if colored { extend_to(&mut self.colors, entries) } else { Ok(()) }
    }

    /// Adds a sphere; either all have a colour or none.
    ///
    /// # Errors
    /// As [`SphereRows::grow`].
    pub fn add(&mut self, center: [f64; 3], radius: f64, color: Option<[f32; 3]>) -> Result<()> {
        self.grow(1, color.is_some())?;
        self.centers.push(center);
        self.radii.push(radius);
        self.colors.extend(color);
        Ok(())
    }

    /// Removes all spheres, and keeps the memory.
    pub fn clear(&mut self) {
        self.centers.clear();
        self.radii.clear();
        self.colors.clear();
    }
}
