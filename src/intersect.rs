//! THE list of intersection variants: type, files, name on the command line. Each line has one .rs in intersect/, and
//! one .wgsl in shaders/form/, which f64 and double-float have in common; every test and every measurement takes them from here.

pub(crate) mod double_float;
mod geometric;
mod native64;
pub mod predict;
mod roots;
mod stable;
mod textbook;
mod unit;

use crate::error::Error;
use crate::number::vector::Laned;
use crate::number::{Arithmetic, Number};
use crate::view::Sphere;
use crate::view::ray::Ray;
use std::str::FromStr;

/// A form of the ray-sphere intersection: the CPU twin of a file of shaders/form/.
pub trait Intersect {
    /// The arithmetic that the variant runs in.
    type Number: Laned;
    /// The least t > 0 where `ray` meets `s`, in the record's unit; [`Arithmetic::MISS`] if nowhere. A tangent ray hits. Of
    /// numbers or of vectors: without branches, except where no ray of a vector hits.
    fn intersect<R: Arithmetic>(ray: &Ray<R>, s: &Sphere<R>) -> R;
    /// The unit normal at t in the canonical camera, against the ray.
    fn normal_at<R: Number>(ray: &Ray<R>, s: &Sphere<R>, t: R) -> [R; 3];
}

/// Work to be done with the type of a variant: how a [`Method`] becomes static dispatch.
pub(crate) trait Visit {
    /// What the work gives.
    type Output;
    /// The work.
    fn visit<V: Intersect>(self) -> Self::Output;
}

macro_rules! variants {
    ($($name:ident $file:ident $command:literal $form:ident $cost:literal $about:literal)*) => {
        /// The form of the quadratic, by its name on the command line.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Method {
            $(#[doc = $about] $name,)*
        }

        impl Method {
            /// All of them, in the order of the list.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// The name on the command line.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$name => $command,)* }
            }

            /// What it computes, in words.
            #[must_use]
            pub fn about(self) -> &'static str {
                match self { $(Self::$name => $about,)* }
            }

            /// Its discriminant and its roots.
            pub(crate) fn form(self) -> Form {
                match self { $(Self::$name => Form::$form,)* }
            }

            /// What its kernel costs beside that of `stable`.
            pub(crate) fn cost(self) -> f64 {
                match self { $(Self::$name => $cost,)* }
            }

            /// Does `work` with the variant's type.
            pub(crate) fn dispatch<W: Visit>(self, work: W) -> W::Output {
                match self { $(Self::$name => work.visit::<$file::$name>(),)* }
            }
        }
    };
}
// The costs are steady kernel times for balls_s4.nff (7,382 spheres), 256 x 256, ids alone, by the clock of lavapipe
// (Mesa 22.3.6, LLVM 15, 2 cores), least of nine. Other adapters order them alike but for f64, which few do faster.
variants! {
    Textbook textbook "textbook" General 0.75 "the general quadratic with d.d"
    Unit unit "unit" Normalised 0.86 "the quadratic for d of unit length"
    Geometric geometric "geometric" Normalised 0.86 "closest approach t_m, its distance l_m, half the chord delta t"
    Stable stable "stable" Perpendicular 1.0 "the perpendicular form: discriminant from the cross product, power of the eye from the host, root of matched sign"
    Native64 native64 "f64" Perpendicular 3.4 "the perpendicular form in the adapter's f64"
    DoubleFloat double_float "double-float" Perpendicular 24.0 "the perpendicular form in sums of two f32, where the adapter's arithmetic was measured to allow it"
}

/// How a variant makes its discriminant and its roots; what rounding does to them follows from that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// a r^2 - |p x d|^2, roots of matched sign.
    Perpendicular,
    /// b^2 - a c, roots by their signs.
    General,
    /// b^2 - |p|^2 + r^2 for d of unit length.
    Normalised,
}

impl Method {
    /// Whether it computes in more than f32: it reads the low parts of all inputs and gives t in two parts.
    pub(crate) fn is_wide(self) -> bool {
        matches!(self, Self::Native64 | Self::DoubleFloat)
    }
}

impl FromStr for Method {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self, Error> {
        crate::error::by_name("method", name, Self::ALL, |m| m.name())
    }
}
