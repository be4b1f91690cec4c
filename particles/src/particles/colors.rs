//! Colours of a file, from the numbers of their fields to linear light: one rule for all formats. Which levels the numbers are
//! follows from their type and from all of the file, not from a part of it.

use crate::color::{srgb_to_linear, top_level};
use crate::npy::header::{NumberKind, Scalar};
use halfline_ground::parallel;
use halfline_ground::quote::setting::COLOR;

/// The type of the fields of colours, which decides what their numbers can mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum ColorType {
    /// Bytes: levels of sRGB of 8 bits.
    Byte,
    /// Longer integers: levels of 8 bits where none is above 255, else of 16 bits.
    Whole,
    /// Floats and text: linear RGB, or levels as of integers where all are whole and one is above 1.
    #[default]
    Real,
}

impl ColorType {
    /// The type for a field of this scalar type.
    pub(super) fn of(scalar: Scalar) -> Self {
        match (scalar.kind, scalar.size()) {
            (NumberKind::Float | NumberKind::Bool, _) => Self::Real,
            (NumberKind::Unsigned, 1) => Self::Byte,
            _ => Self::Whole,
        }
    }
}

/// A survey of a file's colours: their type, their number and the largest value, from which their scale follows.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ColorSurvey {
    kind: ColorType,
    count: u64,
    most: f32,
    /// Whether some number is no level of up to 16 bits.
    has_fractions: bool,
}

/// The scale of the numbers of a file's colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColorScale {
    /// Integers that are all 0: fields that nobody filled in.
    Empty,
    Linear,
    /// Levels of sRGB up to this one.
    Levels(f32),
}

impl ColorSurvey {
    /// Takes more colours of the file.
    pub fn see(&mut self, kind: ColorType, colors: &[[f32; 3]]) {
        let is_level = |x: f32| x.fract() == 0.0 && (0.0..=65535.0).contains(&x);
        self.kind = kind;
        self.count += colors.len() as u64;
        self.most = parallel::reduce(colors.as_flattened(), self.most, f32::max);
        self.has_fractions = self.has_fractions || !parallel::all(colors.as_flattened(), |x| is_level(*x));
    }

    /// Whether no other colours of the file can change the scale.
    pub fn is_decided(&self) -> bool {
        match self.kind {
            ColorType::Byte => self.most > 0.0,
            ColorType::Whole => self.most > 255.0,
            ColorType::Real => self.has_fractions,
        }
    }

    /// The scale of the colours seen so far.
    pub fn scale(&self) -> ColorScale {
        let is_whole = self.kind != ColorType::Real;
        match () {
            () if is_whole && self.most == 0.0 => ColorScale::Empty,
            // Integers of 32 bits.
            () if is_whole && self.most > 65535.0 => ColorScale::Levels(u32::MAX as f32),
            () if is_whole || self.most > 1.0 && !self.has_fractions => ColorScale::Levels(top_level(self.most)),
            () => ColorScale::Linear,
        }
    }

    /// Makes colours of the file linear light.
    pub(super) fn lighten(&self, colors: &mut Vec<[f32; 3]>) {
        match self.scale() {
            ColorScale::Empty => colors.clear(),
            ColorScale::Linear => {}
            ColorScale::Levels(top) => {
                parallel::each(colors, |_, color| *color = color.map(|level| srgb_to_linear(level, top)));
            }
        }
    }

    /// The warning about an assumed scale, or about colours that are all 0; `None` where nothing is assumed.
    pub fn warning(&self) -> Option<String> {
        let linear = self.kind == ColorType::Real;
        match self.scale() {
            _ if self.count == 0 => None,
            ColorScale::Empty => Some(format!(
                "the colours of the file are integers that are all 0, as where none were measured, so it is taken to have none; \
                 {COLOR} black makes it black"
            )),
            ColorScale::Linear if self.most == 0.0 => {
                Some(format!("all colours of the file are 0, which is black; {COLOR} sets another"))
            }
            ColorScale::Levels(top) if linear => {
                let bits = if top > 255.0 { 16 } else { 8 };
                Some(format!(
                    "the colours are whole numbers up to {top}, so they are read as {bits}-bit sRGB, not as linear RGB"
                ))
            }
            ColorScale::Levels(255.0) if self.kind == ColorType::Whole => {
                Some("no colour is above 255, so colours are read as 8-bit sRGB, not as 16-bit".into())
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::frame::Particles;
    use halfline_ground::srgb::linear;

    fn linearized(color_type: ColorType, colors: &[[f32; 3]]) -> (Vec<[f32; 3]>, usize) {
        let found = Particles { colors: colors.to_vec(), color_type, ..Particles::default() }.linearized();
        (found.colors, found.skipped.assumed.len())
    }

    #[test]
    fn levels_follow_from_the_type_and_from_all_colours() {
        use ColorType::{Byte, Real, Whole};
        let eight = linear([255, 0, 128]);
        let close = |(found, warnings): (Vec<[f32; 3]>, usize), count: usize| {
            let near = found[0].iter().zip(eight).all(|(a, b)| (a - b).abs() < 1e-6);
            assert!(near && warnings == count, "{found:?} {warnings}");
        };
        for (kind, top, warnings) in
            [(Byte, 255.0, 0), (Whole, 255.0, 1), (Real, 255.0, 1), (Whole, 65535.0, 0), (Real, 65535.0, 1)]
        {
            let scale = top / 255.0;
            close(linearized(kind, &[[top, 0.0, 128.0 * scale], [0.0; 3]]), warnings);
        }
        close(linearized(Whole, &[[u32::MAX as f32, 0.0, 128.0 * 16843009.0]]), 0);
        // One of 255 is nearly black, where the type means levels.
        assert_eq!(linearized(Whole, &[[1.0, 0.0, 1.0]]).0, [linear([1, 0, 1])]);
        for real in [[[1.0, 0.0, 1.0]], [[0.5, 2.0, 0.0]], [[256.5, 0.0, 0.0]], [[65536.0, 0.0, 0.0]]] {
            assert_eq!(linearized(Real, &real), (real.to_vec(), 0), "linear, beyond 1 too");
        }
    }

    #[test]
    fn integers_that_are_all_0_are_no_colours() {
        for (kind, colors) in [(ColorType::Byte, 0), (ColorType::Whole, 0), (ColorType::Real, 2)] {
            let (found, warnings) = linearized(kind, &[[0.0; 3]; 2]);
            assert_eq!((found.len(), warnings), (colors, 1), "{kind:?}");
            assert_eq!(linearized(kind, &[]).1, 0);
        }
        assert_eq!(
            linearized(ColorType::Byte, &[[0.0; 3], [0.0, 0.0, 9.0]]).0[0],
            [0.0; 3],
            "one that is not tells of the others"
        );
    }

    /// A scale that a part of a file decides is the scale of the whole file.
    #[test]
    fn a_part_that_decides_has_the_scale_of_the_file() {
        let numbers = [0.0f32, 0.25, 1.0, 7.0, 255.0, 256.0, 40000.0];
        for kind in [ColorType::Byte, ColorType::Whole, ColorType::Real] {
            for first in numbers {
                for second in numbers {
                    if kind != ColorType::Real && [first, second].contains(&0.25)
                        || kind == ColorType::Byte && first.max(second) > 255.0
                    {
                        continue;
                    }
                    let mut survey = ColorSurvey::default();
                    survey.see(kind, &[[first; 3]]);
                    let (decided, scale) = (survey.is_decided(), survey.scale());
                    survey.see(kind, &[[second; 3]]);
                    assert!(!decided || survey.scale() == scale, "{kind:?} {first} {second}");
                }
            }
        }
    }
}
