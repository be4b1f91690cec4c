//! The tone of a picture: how linear light becomes the light of a picture of 8 or 16 bits, which ends at 1.

use halfline_ground::error::{Error, Result, named};
use halfline_ground::parallel;
use serde::Serialize;
use std::borrow::Cow;

/// The curve of light beyond 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// Every component is cut off at 1.
    #[default]
    Linear,
    /// A colour whose greatest component m exceeds 1 becomes whiter as m grows: each component c becomes
    /// 1 - (1 - c/m) / (1 + (m - 1)^2). Colours up to 1 stay as they are.
    Soft,
}

named! { Tone, "tone", Linear "linear" Soft "soft" }

/// Exposure and curve of a picture. Files that hold linear light are not changed by it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Toning {
    /// The curve.
    pub tone: Tone,
    /// Light is multiplied by 2 to the power of this before the curve.
    pub stops: f64,
}

impl Toning {
    /// The most stops, up or down.
    pub const MOST_STOPS: f64 = 32.0;

    /// Checks the stops.
    ///
    /// # Errors
    /// [`Error::Settings`] beyond [`Toning::MOST_STOPS`] and for NaN.
    pub fn check_stops(stops: f64) -> Result<f64> {
        if stops.abs() <= Self::MOST_STOPS {
            return Ok(stops);
        }
        let mend = format!("give a number of stops from -{0} to {0}", Self::MOST_STOPS);
        Err(Error::settings(format!("the exposure is {stops}"), mend))
    }

    /// Whether the picture shows the light as it is, without exposure and curve.
    fn is_plain(self) -> bool {
        self == Self::default()
    }

    /// The light of a pixel in the picture; components beyond 1 are cut off by [`halfline_ground::srgb::level`].
    #[must_use]
    pub fn of(self, rgb: [f32; 3]) -> [f32; 3] {
        if self.is_plain() {
            return rgb;
        }
        let exposed = rgb.map(|c| f64::from(c) * self.stops.exp2());
        // Finite, so that the quotients are numbers.
        let most = exposed.into_iter().fold(0.0, f64::max).min(f64::MAX);
        if self.tone == Tone::Linear || most <= 1.0 {
            return exposed.map(|c| c as f32);
        }
        let kept = 1.0 / (1.0 + (most - 1.0) * (most - 1.0));
        exposed.map(|c| (1.0 - (1.0 - if c > most { 1.0 } else { c / most }) * kept) as f32)
    }

    /// The light of many pixels.
    #[must_use]
    pub fn all(self, linear: &[f32]) -> Cow<'_, [f32]> {
        if self.is_plain() {
            return linear.into();
        }
        let mut toned = linear.to_vec();
        parallel::each(toned.as_chunks_mut().0, |_, rgb| *rgb = self.of(*rgb));
        toned.into()
    }

    /// The keywords of provenance: what differs from linear light without exposure.
    pub fn words(self) -> impl Iterator<Item = (&'static str, String)> {
        let tone = (self.tone != Tone::Linear).then(|| ("halfline:tone", self.tone.name().to_owned()));
        let exposure = (self.stops != 0.0).then(|| ("halfline:exposure", format!("{:?}", self.stops)));
        tone.into_iter().chain(exposure)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline_ground::srgb::level;

    const SOFT: Toning = Toning { tone: Tone::Soft, stops: 0.0 };

    /// Scaled from black to far beyond 1, in steps of 1/256.
    fn ramp(own: [f32; 3]) -> Vec<[f32; 3]> {
        (0..256 * 8).map(|k| own.map(|c| c * (k as f32 / 256.0))).collect()
    }

    #[test]
    fn colours_up_to_one_keep_every_bit() {
        for rgb in [[0.0; 3], [1.0; 3], [1.0, 0.0, 0.3], [0.2, 0.7, 0.999], [0.25; 3]] {
            assert_eq!(SOFT.of(rgb), rgb);
        }
        assert_eq!(SOFT.of([2.0; 3]), [1.0; 3], "white stays white");
        assert_eq!(SOFT.of([f32::INFINITY, 0.0, 0.5]).map(level), [255; 3]);
        assert_eq!(SOFT.of([2.0, f32::NAN, 0.0]).map(level)[1], 0, "as without a curve");
    }

    /// A saturated colour that exceeds 1 keeps its shape: it goes on to change, evenly, with the same hue.
    #[test]
    fn what_exceeds_one_rolls_off_evenly() {
        for own in [[1.0, 0.0, 0.0], [0.0, 0.6, 0.2], [1.0, 0.0, 1.0], [0.9, 0.3, 0.1]] {
            let toned: Vec<[f32; 3]> = ramp(own).into_iter().map(|rgb| SOFT.of(rgb)).collect();
            for (a, b) in toned.iter().zip(&toned[1..]) {
                for (a, b) in a.iter().zip(b) {
                    // No component falls, and none leaps: the curve's slope is below 1 from the knee on (0.65 at most, where
                    // m - 1 = 1/sqrt 3), and below it a component grows by at most 1/256 a step.
                    assert!(*a <= *b && b - a <= 1.01 / 256.0, "{own:?}: {a} {b}");
                }
            }
            // Hue: between least and greatest, the middle component lies where it did.
            let place = |rgb: &[f32; 3]| {
                let (low, high) = (rgb.iter().copied().fold(1.0, f32::min), rgb.iter().copied().fold(0.0, f32::max));
                let middle = rgb.iter().sum::<f32>() - low - high;
                (middle - low) / (high - low)
            };
            // Five numbers of f32 near 1, whose differences are above 0.02 here.
            toned[64..].iter().for_each(|rgb| assert!((place(rgb) - place(&own)).abs() < 3e-5, "{own:?}: {rgb:?}"));
            let greatest = own.into_iter().fold(0.0, f32::max);
            let beyond = |most: f32| SOFT.of(own.map(|c| c * most / greatest)).map(level);
            assert_ne!(beyond(1.3), beyond(1.4), "{own:?} beyond 1 has no flat part");
            assert!(beyond(1.3).iter().all(|level| *level > 0) && beyond(1.3).contains(&255));
        }
    }

    #[test]
    fn exposure_doubles_the_light_for_each_stop() {
        let linear = |stops| Toning { tone: Tone::Linear, stops };
        assert_eq!(linear(1.0).of([0.25, 0.5, 1.0]), [0.5, 1.0, 2.0]);
        assert_eq!(linear(-2.0).of([1.0, 0.5, 0.0]), [0.25, 0.125, 0.0]);
        let soft = Toning { tone: Tone::Soft, stops: 1.0 };
        assert_eq!(soft.of([0.5, 0.25, 0.0]), [1.0, 0.5, 0.0]);
        assert_eq!(soft.of([1.0, 0.5, 0.0]), [1.0, 0.75, 0.5], "m = 2: 1 - (1 - c/2) / 2");
        for bad in [f64::NAN, f64::INFINITY, 33.0, -33.0] {
            Toning::check_stops(bad).expect_err("out of range");
        }
        assert_eq!(Toning::check_stops(-32.0).expect("in range"), -32.0);
    }
}
