//! The options for reading a scene.

use super::style::Style;
use halfline_ground::error::named;
use halfline_particles::select::{Selections, selection::Selection};

/// Options for reading a scene.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// The file's format, and the particles and columns to take.
    pub particles: halfline_particles::ParticleOptions,
    /// The frames that set the default radius and the range of colours of a sequence.
    pub hold: Hold,
    /// Selections of particles that are reported to the caller, such as those that a camera looks at; see
    /// [`SceneFrame::marks`](crate::read::SceneFrame::marks).
    pub marks: Vec<Selection>,
    /// The style of the particles.
    pub style: Style,
}

impl ReadOptions {
    /// The options for the readers of particles, which keep the columns of the style and of all selections.
    pub(super) fn reading(&self) -> halfline_particles::ParticleOptions {
        let mut reading = self.particles.clone();
        reading.columns.extend(self.style.columns().iter().cloned());
        reading.others.extend(self.marks.iter().chain(self.style.selections()).cloned());
        reading
    }

    /// The selections of the options and of the style, by their use.
    pub(super) fn selections(&self) -> Selections<'_> {
        let halfline_particles::ParticleOptions { select, hide, .. } = &self.particles;
        Selections { select, hide, marks: &self.marks, rules: self.style.rules() }
    }
}

/// The frames that set default radii and ranges of colours, so that a film does not flicker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hold {
    /// The first frame of the file that has spheres, selected or not, so a frame read alone is the same as in a film.
    #[default]
    First,
    /// All frames set the camera and the range of colours: the caller has read them before; see
    /// [`Scale::range`](crate::read::style::Scale::range). The first frame sets the radius and the colours of names.
    All,
    /// Each frame sets its own.
    None,
}

named! { Hold, "hold", First "first" All "all" None "none" }
