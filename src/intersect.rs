//! THE list of intersection variants: form, arithmetic, name on the command line. Each form has one .rs in intersect/, and each
//! f32 variant one .wgsl in shaders/form/, with another for f64 and double-float; every test and every measurement takes them from here.

pub(crate) mod double_float;
mod geometric;
pub mod predict;
mod roots;
mod stable;
mod textbook;
mod unit;

use crate::number::vector::Laned;
use crate::number::{Arithmetic, Number};
use crate::view::Sphere;
use crate::view::ray::{Ray, center, dot3, minus, negated, times, unit3};
use halfline_ground::error::Error;
use std::str::FromStr;

/// A form of the ray-sphere intersection: the CPU twin of a file of shaders/form/.
pub trait Intersect {
    /// The least t > 0 where `ray` meets `s`, in the record's unit; [`Arithmetic::MISS`] if nowhere. A tangent ray hits. Of
    /// numbers or of vectors: without branches, except where no ray of a vector hits.
    fn intersect<R: Arithmetic>(ray: &Ray<R>, s: &Sphere<R>) -> R;
    /// The unit normal at t in the canonical camera, against the ray: of hit point minus centre.
    fn normal_at<R: Number>(ray: &Ray<R>, s: &Sphere<R>, t: R) -> [R; 3] {
        let n = unit3(minus(times(t, ray.d), center(s)));
        if dot3(n, ray.d) > R::ZERO { negated(n) } else { n }
    }
}

/// Work to be done with the form and the arithmetic of a variant: how a [`Method`] becomes static dispatch.
pub(crate) trait Visit {
    /// The result of the work.
    type Output;
    /// The work.
    fn visit<V: Intersect, N: Laned>(self) -> Self::Output;
}

macro_rules! variants {
    ($($name:ident $file:ident $code:ident $number:ty, $command:literal $form:ident $cost:literal $about:literal)*) => {
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

            /// Its discriminant and its roots.
            pub(crate) fn form(self) -> Form {
                match self { $(Self::$name => Form::$form,)* }
            }

            /// Cost of its kernel, as a multiple of the cost of `stable`.
            pub(crate) fn cost(self) -> f64 {
                match self { $(Self::$name => $cost,)* }
            }

            /// Does `work` with the variant's types.
            pub(crate) fn dispatch<W: Visit>(self, work: W) -> W::Output {
                match self { $(Self::$name => work.visit::<$file::$code, $number>(),)* }
            }
        }
    };
}
// The costs are steady kernel times for balls_s4.nff (7,382 spheres), 256 x 256, ids alone, by the clock of lavapipe
// (Mesa 22.3.6, LLVM 15, 2 cores), least of nine. Other adapters order them alike but for f64, which few do faster.
variants! {
    Textbook textbook Textbook f32, "textbook" General 0.75 "the general quadratic with d.d"
    Unit unit Unit f32, "unit" Normalised 0.86 "the quadratic for d of unit length"
    Geometric geometric Geometric f32, "geometric" Normalised 0.86 "closest approach t_m, its distance l_m, half the chord delta t"
    Stable stable Stable f32, "stable" Perpendicular 1.0 "the perpendicular form: discriminant from the cross product, power of the eye from the host, root of matched sign"
    Native64 stable Stable f64, "f64" Perpendicular 3.4 "the perpendicular form in the adapter's f64"
    DoubleFloat stable Stable double_float::Pair<f32>, "double-float" Perpendicular 24.0 "the perpendicular form in sums of two f32, where the adapter's arithmetic was measured to allow it"
}

/// The formulas of discriminant and roots of a variant, from which the bounds of its rounding errors follow.
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
        halfline_ground::error::by_name("method", name, Self::ALL, |m| m.name())
    }
}
