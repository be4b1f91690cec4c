//! Provenance: everything that a file's bytes depend on, as keywords and texts written into it. It contains no time,
//! path or machine name, so that the same command writes the same bytes.

use super::outline::Outline;
use super::report::{CPU_DRIVER, Report};
use super::{Aov, MOST_LIGHTS};
use crate::scene::camera::CameraRecord;
use crate::window::Window;
use halfline_ground::memory::ids_fit;
use halfline_ground::trailer;
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde::ser::{Serialize, Serializer};
use std::fmt::{self, Write};

const FRAME: &str = "halfline:frame";
const CAMERA: &str = "halfline:camera";
const WINDOW: &str = "halfline:window";
const BUFFERS: &str = "halfline:buffers";
const LIGHTS: &str = "halfline:lights";
const IDS: &str = "halfline:ids";
const PIXELS: &str = "halfline:pixels";

/// The keywords that differ between parts of one rendering.
const OF_THE_PART: [&str; 2] = [WINDOW, PIXELS];

/// The longest provenance; longer claims of a damaged file are rejected.
const MAX_PROVENANCE_BYTES: usize = 1 << 16;

/// The rendering that files come from; made by [`crate::render::origin`].
#[derive(Debug, Clone)]
pub struct Origin<'a> {
    /// [`crate::Scene::fingerprint`].
    pub fingerprint: String,
    /// The promised relative error of certified answers.
    pub tolerance: f64,
    /// Seed of the sample positions.
    pub seed: u32,
    /// The machine and method that compute it; [`crate::Renderer::dry_run`] reports them without rendering.
    pub report: &'a Report,
    /// The window in the full frame.
    pub window: Window,
    /// W and H of the full frame, pixels.
    pub full: [u32; 2],
}

/// Keywords and their texts, in the order they were written. Files of equal renderings have equal ones.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub struct Provenance(Vec<(String, String)>);

impl Provenance {
    /// The provenance of a file with these buffers, without what its format adds.
    pub fn new(origin: &Origin<'_>, aovs: &[Aov]) -> Self {
        let Origin { fingerprint, tolerance, seed, report, window, full: [width, height] } = origin;
        let mut words = Self::default();
        words.set("Software", format!("halfline {}", report.halfline));
        words.set("halfline:scene", fingerprint);
        if let Some(camera) = report.camera.as_ref().and_then(|camera| serde_json::to_string(camera).ok()) {
            words.set(CAMERA, camera);
        }
        words.set("halfline:adapter", &report.adapter);
        // The answers do not depend on the number of threads.
        words.set("halfline:driver", if report.backend == "cpu" { CPU_DRIVER } else { &report.driver });
        words.set("halfline:method", report.method);
        words.set("halfline:accuracy", report.accuracy);
        if report.accuracy == "certified" {
            words.set("halfline:tolerance", format!("{tolerance:e}"));
        }
        if let (Some(shade), true) = (report.shade, aovs.contains(&Aov::Color)) {
            words.set("halfline:shade", shade);
        }
        if aovs.contains(&Aov::Color) {
            // Lights and sky are part of the scene.
            let drawn = [(report.silhouette, "halfline:silhouette"), (report.depth_cue, "halfline:depth-cue")];
            drawn.iter().filter(|(drawn, _)| *drawn).for_each(|(_, key)| words.set(key, "true"));
            if let Some(strength) = report.depth_cue_strength {
                words.set("halfline:depth-cue", format!("strength {strength}"));
            }
            if let Some(Outline { width, color }) = report.outline.filter(|outline| *outline != Outline::default()) {
                words.set("halfline:outline", format!("{width} pixels, {color:?}"));
            }
        }
        if let (Some(layers), true) = (report.layers, aovs.iter().any(|aov| matches!(aov, Aov::Color | Aov::Alpha))) {
            words.set("halfline:layers", layers);
            if report.opacity_shadows {
                words.set("halfline:opacity-shadows", "true");
            }
            if report.ghost_rim {
                words.set("halfline:ghost-rim", "true");
            }
        }
        if aovs.contains(&Aov::Shadow) {
            words.set(LIGHTS, report.lights);
        }
        if let (Some(sky), true) = (report.occlusion, aovs.contains(&Aov::Occlusion)) {
            // Not part of a scene that the sky does not light.
            words.set("halfline:occlusion", format!("{} rays, reach {:?}", sky.rays, sky.reach));
        }
        let sampled = report.samples > 1 && aovs.iter().any(|aov| matches!(aov, Aov::Color | Aov::Alpha));
        if sampled {
            words.set("halfline:samples", report.samples);
        }
        // Rays to the sky, to lights that have a size and from fuzzy metal are drawn by the seed, also for one sample.
        let drawn = |aov: &Aov| {
            matches!(aov, Aov::Shadow | Aov::Occlusion) || *aov == Aov::Color && report.shade == Some("lights")
        };
        if sampled || aovs.iter().any(drawn) {
            words.set("halfline:seed", seed);
        }
        if aovs.contains(&Aov::Id) && !ids_fit(report.spheres) {
            words.set(IDS, "int64");
        }
        words.set(FRAME, format!("{width}x{height}"));
        words.set(WINDOW, window.to_string());
        words.set(BUFFERS, aovs.iter().map(|aov| aov.name()).collect::<Vec<_>>().join(","));
        words
    }

    /// Every keyword and its text.
    pub fn words(&self) -> &[(String, String)] {
        &self.0
    }

    /// The text of a keyword.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(found, _)| found == key).map(|(_, text)| text.as_str())
    }

    /// Sets a keyword's text, in place or at the end.
    pub fn set(&mut self, key: &str, text: impl ToString) {
        match self.0.iter_mut().find(|(found, _)| found == key) {
            Some((_, old)) => *old = text.to_string(),
            None => self.0.push((key.to_owned(), text.to_string())),
        }
    }

    /// W and H of the full frame.
    pub fn full(&self) -> Option<[u32; 2]> {
        let (width, height) = self.get(FRAME)?.split_once('x')?;
        Some([width.parse().ok()?, height.parse().ok()?])
    }

    /// The window in the full frame, if it lies within it.
    pub fn window(&self) -> Option<Window> {
        let [width, height] = self.full()?;
        let ends: Vec<u32> = self.get(WINDOW)?.split(',').map(|end| end.parse().ok()).collect::<Option<_>>()?;
        let [x0, y0, x1, y1] = ends.try_into().ok()?;
        Window { x0, y0, x1, y1 }.within(width, height).ok()
    }

    /// The camera.
    pub fn camera(&self) -> Option<CameraRecord> {
        serde_json::from_str(self.get(CAMERA)?).ok()
    }

    /// The buffers in the file.
    pub fn buffers(&self) -> Option<Vec<Aov>> {
        self.get(BUFFERS)?.split(',').map(|name| name.parse().ok()).collect()
    }

    /// The number of lights of a `shadow` buffer; 0 where there is none, or more than such a buffer holds.
    pub fn lights(&self) -> usize {
        let lights = self.get(LIGHTS).and_then(|lights| lights.parse().ok());
        lights.filter(|lights| *lights <= MOST_LIGHTS).unwrap_or(0)
    }

    /// Whether ids are 64-bit integers.
    pub fn has_wide_ids(&self) -> bool {
        self.get(IDS) == Some("int64")
    }

    /// The hash of the samples; `None` in files of earlier versions.
    pub fn pixels(&self) -> Option<&str> {
        self.get(PIXELS)
    }

    /// The provenance with the hash of the samples.
    #[must_use]
    pub fn with_pixels(mut self, hash: &str) -> Self {
        self.set(PIXELS, hash);
        self
    }

    /// The provenance of the rendering alone: without window and hash.
    #[must_use]
    pub fn rendering(&self) -> Self {
        self.0.iter().filter(|(key, _)| !OF_THE_PART.contains(&key.as_str())).cloned().collect()
    }

    /// The provenance without the hash of the samples.
    #[must_use]
    pub fn without_pixels(&self) -> Self {
        self.0.iter().filter(|(key, _)| key != PIXELS).cloned().collect()
    }

    /// The same with another window.
    #[must_use]
    pub fn of_window(mut self, window: Window) -> Self {
        self.set(WINDOW, window);
        self
    }

    /// The first keyword that differs, apart from the window and the hash of the samples, and its two texts.
    pub fn foreign(&self, other: &Self) -> Option<[String; 3]> {
        let keys = self.0.iter().chain(&other.0).map(|(key, _)| key);
        let keys = keys.filter(|key| !OF_THE_PART.contains(&key.as_str()));
        let text = |words: &Self, key: &str| words.get(key).unwrap_or("nothing").to_owned();
        let mut differing = keys.map(|key| [key.clone(), text(self, key), text(other, key)]).filter(|[_, a, b]| a != b);
        differing.next()
    }

    /// One JSON object on one line, in ASCII, in the order of the keywords.
    pub fn to_json(&self) -> String {
        let json = serde_json::to_string(self).unwrap_or_default();
        let mut ascii = String::with_capacity(json.len());
        for c in json.chars() {
            if c.is_ascii() {
                ascii.push(c);
            } else {
                // Writing to a String does not fail.
                c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| _ = write!(ascii, "\\u{unit:04x}"));
            }
        }
        ascii
    }

    /// Parses the output of [`Provenance::to_json`]; `None` for anything else.
    pub fn from_json(json: &[u8]) -> Option<Self> {
        if json.len() > MAX_PROVENANCE_BYTES { None } else { serde_json::from_slice(json).ok() }
    }

    /// The block after the last number, for formats whose headers cannot hold metadata.
    pub fn trailer(&self) -> String {
        trailer::of(&self.to_json())
    }

    /// Whether these bytes have the form of a trailer.
    #[must_use]
    pub fn is_trailer(bytes: &[u8]) -> bool {
        trailer::json(bytes).is_some()
    }

    /// Parses the output of [`Provenance::trailer`]; `None` for anything else.
    pub fn from_trailer(bytes: &[u8]) -> Option<Self> {
        let words = Self::from_json(trailer::json(bytes)?);
        words.filter(|words| words.trailer().as_bytes() == bytes)
    }
}

impl FromIterator<(String, String)> for Provenance {
    fn from_iter<T: IntoIterator<Item = (String, String)>>(words: T) -> Self {
        Self(words.into_iter().collect())
    }
}

impl Serialize for Provenance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(key, text)| (key, text)))
    }
}

impl<'de> Deserialize<'de> for Provenance {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct KeywordVisitor;
        impl<'de> Visitor<'de> for KeywordVisitor {
            type Value = Provenance;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object whose values are strings")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Provenance, A::Error> {
                let mut words = Vec::new();
                while let Some(word) = map.next_entry()? {
                    words.push(word);
                }
                Ok(Provenance(words))
            }
        }
        deserializer.deserialize_map(KeywordVisitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words() -> Provenance {
        let words = [
            ("Software", "halfline"),
            ("driver", "Ω \"5\"\n球"),
            (FRAME, "30x20"),
            (WINDOW, "1,2,30,20"),
            (BUFFERS, "id,mask"),
        ];
        words.into_iter().map(|(key, text)| (key.to_owned(), text.to_owned())).collect()
    }

    #[test]
    fn provenance_survives_json_and_trailer_in_order() {
        let json = words().to_json();
        assert!(json.is_ascii() && !json.contains('\n'), "{json}");
        assert_eq!(Provenance::from_json(json.as_bytes()), Some(words()));
        let trailer = words().trailer();
        assert_eq!(Provenance::from_trailer(trailer.as_bytes()), Some(words()));
        for n in 0..trailer.len() {
            assert_eq!(Provenance::from_trailer(&trailer.as_bytes()[..n]), None, "cut after {n}");
        }
        assert_eq!(Provenance::from_trailer(format!("{trailer}\n").as_bytes()), None);
    }

    #[test]
    fn an_invalid_window_is_not_read() {
        assert_eq!(words().full(), Some([30, 20]));
        assert_eq!(words().window(), Some(Window { x0: 1, y0: 2, x1: 30, y1: 20 }));
        assert_eq!(words().buffers(), Some(vec![Aov::Id, Aov::Mask]));
        for bad in ["1,2,31,20", "1,2,1,20", "1,2,3", "1,2,3,4,5", "a,2,3,4", "-1,2,3,4", ""] {
            let mut crooked = words();
            crooked.set(WINDOW, bad);
            assert_eq!(crooked.window(), None, "{bad}");
        }
    }

    #[test]
    fn the_difference_is_named() {
        let whole = words().of_window(Window::full(30, 20));
        assert_eq!(words().foreign(&whole), None, "another window is the same rendering");
        let mut other = whole.clone();
        other.set("driver", "6");
        assert_eq!(words().foreign(&other).map(|[key, ..]| key), Some("driver".into()));
        let mut more = whole;
        more.set("halfline:bits", 16);
        assert_eq!(words().foreign(&more), Some(["halfline:bits", "nothing", "16"].map(String::from)));
    }
}
