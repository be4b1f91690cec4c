//! Shading: the colour of a hit. The twin of shade/.

pub(crate) mod cap;
pub(crate) mod optics;

use crate::number::Arithmetic;
use crate::scene::DEFAULT_COLOR;
use crate::view::ViewRecord;
use crate::view::ray::{dot3, positive, times, unit3};
use glam::DVec3;
use halfline_ground::error::named;

/// The shading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Shade {
    /// The colour of the sphere.
    Flat,
    /// The world normal as a colour, (n + 1)/2.
    Normal,
    /// Lambert's law with a light at the eye.
    #[default]
    Headlight,
}

named! { Shade, "shading", Flat "flat" Normal "normal" Headlight "headlight" }

impl Shade {
    /// Whether it uses the spheres' colours.
    #[must_use]
    pub fn needs_colors(self) -> bool {
        self != Self::Normal
    }
}

/// The colour of a sphere, linear RGB.
#[inline(always)]
pub(crate) fn color_of(colors: Option<&[[f32; 3]]>, id: u32) -> [f32; 3] {
    colors.map_or(DEFAULT_COLOR, |colors| colors[id as usize])
}

/// A direction of the canonical camera in world space.
#[inline(always)]
pub(crate) fn to_world<A: Arithmetic>(view: &ViewRecord, a: [A; 3]) -> [A; 3] {
    let component = |k: usize| {
        let [right, up, back] = [A::from_f32(view.right[k]), A::from_f32(view.up[k]), A::from_f32(view.back[k])];
        a[0] * right + a[1] * up + a[2] * back
    };
    [component(0), component(1), component(2)]
}

impl Shade {
    /// Linear RGB of a hit on a sphere of the colour `own`, in f64: of its unit normal in world space, and the cosine between that and the
    /// way back along the ray.
    pub(crate) fn in_world(self, normal: DVec3, cosine: f64, own: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Flat => own,
            Self::Normal => (0.5 * normal + 0.5).as_vec3().to_array(),
            Self::Headlight => own.map(|x| positive(cosine as f32) * x),
        }
    }

    /// Linear RGB of a hit on a sphere of the colour `own`. `direction` and the unit normal are in the canonical camera.
    #[inline(always)]
    pub(crate) fn of<A: Arithmetic>(self, view: &ViewRecord, direction: [A; 3], normal: [A; 3], own: [A; 3]) -> [A; 3] {
        match self {
            Self::Flat => own,
            Self::Normal => {
                let (half, n) = (A::from_f32(0.5), to_world(view, normal));
                [half * n[0] + half, half * n[1] + half, half * n[2] + half]
            }
            Self::Headlight => times(positive(-dot3(normal, unit3(direction))), own),
        }
    }
}
