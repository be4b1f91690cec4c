//! Materials of spheres.

use super::List;
use halfline_ground::error::{Error, Place, Result, named};
use serde::{Deserialize, Serialize};

/// The reflection and transmission of light by a sphere. The sphere's colour is the colour of its diffuse reflection, and of
/// a metal's mirror image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Material {
    /// Plastic and mirrors as NFF describes them: the shares of light by kind.
    Phong {
        /// Diffuse reflection by Lambert's law, Kd.
        diffuse: f32,
        /// The mirror image of the scene and the highlights of lights, Ks.
        specular: f32,
        /// The exponent of the cosine in a highlight; 0 for no highlights.
        shine: f32,
        /// The share of light that passes through, T.
        transmission: f32,
        /// Index of refraction.
        index: f64,
    },
    /// Diffuse reflection by Lambert's law, with the white highlights of lights on it, and no mirror image.
    Plastic {
        /// The share of a light that its highlight adds, 0 to 1.
        gloss: f32,
        /// The exponent of the cosine in a highlight.
        shine: f32,
    },
    /// Its colour without light and without outlines, as of the edges of a cell.
    Ink,
    /// A mirror that takes the sphere's colour.
    Metal {
        /// Radius of the ball by which reflected directions of length 1 are scattered, 0 to 1.
        fuzz: f32,
    },
    /// Clear glass, which reflects what Fresnel's equations say (in Schlick's approximation) and refracts the rest.
    Glass {
        /// Index of refraction.
        index: f64,
    },
}

/// The name of a material, whose numbers are the usual ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MaterialName {
    /// Diffuse reflection only.
    Matte,
    /// [`Material::Plastic`].
    Plastic,
    /// [`Material::Metal`], without scattering.
    Metal,
    /// [`Material::Glass`].
    Glass,
}

named! { MaterialName, "material", Matte "matte" Plastic "plastic" Metal "metal" Glass "glass" }

impl MaterialName {
    /// The material, with this exponent for highlights of plastic.
    #[must_use]
    pub fn material(self, shine: Option<f32>) -> Material {
        match self {
            Self::Matte => Material::default(),
            Self::Plastic => Material::Plastic { gloss: Material::GLOSS, shine: shine.unwrap_or(Material::SHINE) },
            Self::Metal => Material::Metal { fuzz: 0.0 },
            Self::Glass => Material::Glass { index: Material::INDEX },
        }
    }
}

impl Default for Material {
    /// Diffuse reflection only.
    fn default() -> Self {
        Self::Phong { diffuse: 1.0, specular: 0.0, shine: 0.0, transmission: 0.0, index: 1.0 }
    }
}

impl Material {
    /// The usual gloss and shine of plastic.
    pub const GLOSS: f32 = 0.8;
    /// The usual exponent of highlights.
    pub const SHINE: f32 = 40.0;
    /// The usual index of refraction of glass.
    pub const INDEX: f64 = 1.5;

    /// Whether light passes through it.
    #[must_use]
    pub fn is_clear(&self) -> bool {
        match *self {
            Self::Phong { transmission, .. } => transmission > 0.0,
            Self::Plastic { .. } | Self::Ink | Self::Metal { .. } => false,
            Self::Glass { .. } => true,
        }
    }

    /// Whether a ray goes on from it.
    #[must_use]
    pub fn bounces(&self) -> bool {
        match *self {
            Self::Phong { specular, transmission, .. } => specular > 0.0 || transmission > 0.0,
            Self::Plastic { .. } | Self::Ink => false,
            Self::Metal { .. } | Self::Glass { .. } => true,
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::Scene`] at `place`, with the name of the field appended.
    pub fn check(&self, place: impl Fn(&str) -> Place) -> Result<()> {
        let share = |field: &str, x: f32, most: f32| match x {
            x if (0.0..=most).contains(&x) => Ok(()),
            x => Err(Error::scene(place(field), format!("found {x}"), format!("give a number from 0 to {most}"))),
        };
        let index = |index: f64| match index {
            x if (0.1..=10.0).contains(&x) => Ok(()),
            x => Err(Error::scene(place("index"), format!("found {x}"), "give an index of refraction from 0.1 to 10")),
        };
        match *self {
            Self::Phong { diffuse, specular, shine, transmission, index: n } => {
                share("diffuse", diffuse, 1.0)?;
                share("specular", specular, 1.0)?;
                share("shine", shine, f32::MAX)?;
                share("transmission", transmission, 1.0)?;
                if transmission > 0.0 { index(n) } else { Ok(()) }
            }
            Self::Plastic { gloss, shine } => {
                share("gloss", gloss, 1.0)?;
                share("shine", shine, f32::MAX)
            }
            Self::Ink => Ok(()),
            Self::Metal { fuzz } => share("fuzz", fuzz, 1.0),
            Self::Glass { index: n } => index(n),
        }
    }
}

/// Materials among which [`Materials::push`] looks for an equal one, so that a scene in which all differ takes no longer
/// than in proportion to its spheres.
const MAX_COMPARED_MATERIALS: usize = 256;

/// The materials of a scene's spheres.
#[derive(Debug, Clone, PartialEq)]
pub struct Materials {
    /// Each material, as a rule once.
    pub kinds: Vec<Material>,
    /// For each sphere the index of its material.
    pub of: List<u32>,
}

impl Materials {
    /// The material of a sphere.
    #[must_use]
    pub fn of(&self, id: u32) -> Material {
        self.of.get(id as usize).and_then(|kind| self.kinds.get(*kind as usize)).copied().unwrap_or_default()
    }

    /// Whether a sphere is of [`Material::Ink`].
    pub(crate) fn is_ink(&self, id: u32) -> bool {
        self.of(id) == Material::Ink
    }

    /// Whether a ray goes on from any sphere.
    #[must_use]
    pub fn bounce(&self) -> bool {
        self.of.iter().any(|kind| self.kinds.get(*kind as usize).is_some_and(Material::bounces))
    }

    /// Adds one sphere of this material.
    pub fn push(&mut self, material: Material) {
        let first = self.kinds.len().saturating_sub(MAX_COMPARED_MATERIALS);
        let known = self.kinds[first..].iter().position(|kind| *kind == material);
        let kind = known.map(|place| first + place).unwrap_or_else(|| {
            self.kinds.push(material);
            self.kinds.len() - 1
        });
        self.of.to_mut().push(kind as u32);
    }
}
