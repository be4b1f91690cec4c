//! Parts of a scene that other processes or machines made: of each the spheres that some ray of the frame may hit first. What is
//! left of several parts together gives the frame of all their spheres, bit for bit, in whatever order and however often
//! they are combined: docs/certificate.md, section 11.

use super::digests::{Digests, MAX_SPHERES};
use super::{CULL_MIN_SPHERES, Stream, StreamIds, Visible, check, visible};
use crate::scene::camera::Camera;
use crate::scene::instances::NumberedSpheres;
use crate::scene::{CutPlane, Cuts, ImagePlane, Lighting, List, Scene, Spheres};
use crate::settings::{Accuracy, Outline, Settings, Tolerance};
use crate::window::Window;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::parallel;
use halfline_ground::quote::setting::{FIRST_ID, TOLERANCE};
use halfline_ground::quote::{count, quote};
use serde::{Deserialize, Serialize};
use std::borrow::Borrow;
use std::fmt;

/// The rays of the frame that a part is made for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartView {
    /// The version of halfline that made the part.
    pub version: String,
    /// The camera.
    pub camera: Camera,
    /// Columns and rows of the frame.
    pub size: [u32; 2],
    /// The window of the frame.
    pub window: Window,
    /// Samples per pixel, at least 1.
    pub samples: u32,
    /// The seed of their positions; 0 for one sample.
    pub seed: u32,
    /// The promised relative error of certified answers.
    pub tolerance: f64,
    /// The width of outlines, pixels: so many pixels around the window they look at.
    pub outline: f64,
    /// The planes that cut spheres.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub planes: Vec<CutPlane>,
}

/// The spheres of a part of a scene that a frame needs.
#[derive(Clone)]
pub struct Part {
    /// Its name in errors: the file, or its ids.
    pub name: String,
    view: PartView,
    kept: NumberedSpheres,
    digests: Digests,
    counts: Vec<CutCounts>,
}

/// The numbers of spheres that planes cut and remove among ids.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CutCounts {
    /// The first id, and one past the last.
    ids: [u64; 2],
    /// Spheres that planes cut, and that they remove; `None` where parts that overlap do not tell.
    counts: Option<[u64; 2]>,
}

/// The header of a part, beside its arrays.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PartHeader {
    halfline: String,
    #[serde(rename = "seen")]
    view: PartView,
    digests: Digests,
    /// BLAKE3 of the arrays of the part.
    arrays: String,
    /// The spheres that planes cut and remove, where there are planes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    cut_counts: Vec<CutCounts>,
}

/// The text of [`PartHeader::halfline`].
const KIND: &str = "visible spheres of a part, 1";

/// The remedy for parts that are not alike.
const ALIKE: &str = "sift all parts with the same camera, size, window, samples, seed, tolerance, width of outlines, planes and version of halfline";

impl PartView {
    /// The rays of a frame of `scene`.
    ///
    /// # Errors
    /// As [`Settings::window_of`].
    pub fn new(scene: &Scene, settings: &Settings) -> Result<Self> {
        let samples = settings.samples.max(1);
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").into(),
            camera: scene.camera,
            size: [scene.image.width, scene.image.height],
            window: settings.window_of(scene)?,
            samples,
            seed: if samples > 1 { settings.seed } else { 0 },
            tolerance: settings.promise().relative(),
            outline: settings.outline.width,
            planes: scene.spheres.cuts.as_ref().map_or_else(Vec::new, |cuts| cuts.planes.clone()),
        })
    }

    /// A scene with this camera, image and planes, without spheres.
    #[must_use]
    pub fn scene(&self) -> Scene {
        let [width, height] = self.size;
        let image = ImagePlane { width, height, ..ImagePlane::default() };
        let cuts = Cuts { planes: self.planes.clone(), of: List::default(), colors: None };
        let spheres = Spheres { cuts: Some(cuts).filter(|cuts| !cuts.planes.is_empty()), ..Spheres::default() };
        Scene { camera: self.camera, image, spheres, lighting: Lighting::default() }
    }

    /// Settings of certified answers for these rays, and for silhouettes, whose lines look at pixels around the window.
    ///
    /// # Errors
    /// As [`Tolerance::new`] and [`Outline::check`].
    fn settings(&self) -> Result<Settings> {
        let outline = Outline { width: self.outline, ..Outline::default() };
        outline.check()?;
        Ok(Settings {
            accuracy: Accuracy::Certified,
            samples: self.samples,
            seed: self.seed,
            window: Some(self.window),
            tolerance: Some(Tolerance::new(self.tolerance)?),
            silhouette: true,
            outline,
            ..Settings::default()
        })
    }

    /// The first thing in which the rays of two frames differ, and its two values.
    fn difference(&self, other: &Self) -> Option<(&'static str, [String; 2])> {
        fn pair<T: PartialEq>(a: &T, b: &T, shown: impl Fn(&T) -> String) -> Option<[String; 2]> {
            (a != b).then(|| [shown(a), shown(b)])
        }
        let size = |[width, height]: &[u32; 2]| format!("{width}x{height}");
        let numbers = |CutPlane { normal: [x, y, z], distance }: &CutPlane| format!("{x},{y},{z},{distance}");
        let planes = |planes: &Vec<CutPlane>| match &planes[..] {
            [] => "empty".to_owned(),
            planes => planes.iter().map(numbers).collect::<Vec<_>>().join(" and "),
        };
        let found = [
            ("version of halfline", pair(&self.version, &other.version, String::clone)),
            ("camera", pair(&self.camera, &other.camera, |camera| format!("{camera:?}"))),
            ("size", pair(&self.size, &other.size, size)),
            ("window", pair(&self.window, &other.window, Window::to_string)),
            ("number of samples", pair(&self.samples, &other.samples, u32::to_string)),
            ("seed", pair(&self.seed, &other.seed, u32::to_string)),
            ("width of outlines", pair(&self.outline, &other.outline, f64::to_string)),
            ("tolerance", pair(&self.tolerance, &other.tolerance, f64::to_string)),
            ("list of planes", pair(&self.planes, &other.planes, planes)),
        ];
        found.into_iter().find_map(|(what, pair)| Some((what, pair?)))
    }
}

impl Stream {
    /// The spheres of a part of a scene: those that are added next have the ids from `first_id` on. The frame is one of a scene like
    /// `scene`, whose own spheres are not used, with the window, samples, seed, tolerance and width of outlines of `settings`.
    ///
    /// # Errors
    /// Errors of [`Stream::new`] and [`Outline::check`]; [`Error::Limits`] for ids from 2^55 on.
    pub fn of_part(scene: &Scene, settings: &Settings, first_id: u64) -> Result<Self> {
        let view = PartView::new(scene, settings)?;
        check_id(first_id)?;
        Ok(Self { first: first_id, ..Self::new(&view.scene(), &view.settings()?)? })
    }

    /// The spheres that a frame needs of those that were added, for [`Part::combine`] or [`Part::visible`].
    ///
    /// # Errors
    /// [`Error::Limits`] where memory is short, and for ids from 2^55 on.
    pub fn part(mut self) -> Result<Part> {
        check_id(self.first + self.count)?;
        let view = PartView::new(&self.scene, &self.settings)?;
        let name = format!("the part of ids from {}", self.first);
        let counts = CutCounts { ids: [self.first, self.first + self.count], counts: Some(self.changed) };
        let counts = Some(counts).filter(|counts| !view.planes.is_empty() && counts.ids[0] < counts.ids[1]);
        let counts = counts.into_iter().collect();
        Ok(Part { name, view, kept: self.rest()?, digests: self.digests, counts })
    }
}

/// Adds counts of other ids; of the same ids they are the same.
fn add_counts(all: &mut Vec<CutCounts>, other: &CutCounts) {
    if all.contains(other) {
        return;
    }
    let [mut first, mut end] = other.ids;
    let mut counts = other.counts;
    all.retain(|own| {
        let is_apart = own.ids[1] <= first || end <= own.ids[0];
        if !is_apart {
            (first, end, counts) = (first.min(own.ids[0]), end.max(own.ids[1]), None);
        }
        is_apart
    });
    all.push(CutCounts { ids: [first, end], counts });
    all.sort_by_key(|counts| counts.ids);
}

impl Part {
    /// A part of the arrays that [`Part::about`] belongs to: spheres and their ids in increasing order.
    ///
    /// # Errors
    /// [`Error::Scene`] for a part that is damaged, or of another version.
    pub fn new(name: String, about: &[u8], ids: Vec<u64>, spheres: Spheres) -> Result<Self> {
        let fail = |problem: String| {
            Error::scene(Place::file(&name), problem, "make the part again with halfline sift of this version")
        };
        let damaged = |error: &dyn fmt::Display| fail(format!("the part is damaged: {error}"));
        let header: PartHeader = serde_json::from_slice(about).map_err(|error| damaged(&error))?;
        if header.halfline != KIND {
            return Err(fail(format!("this is {} and not {}", quote(&header.halfline), quote(KIND))));
        }
        let are_alike = spheres.have_lengths(ids.len());
        let kept = NumberedSpheres { numbers: ids, spheres };
        if !are_alike || header.arrays != kept.digest() {
            return Err(damaged(&"its arrays are not those that were written"));
        }
        let known = header.digests.ids();
        let is_known = |id: u64| known.iter().any(|[first, end]| (*first..*end).contains(&id));
        if !kept.numbers.is_sorted_by(|a, b| a < b) || !kept.numbers.iter().all(|id| is_known(*id)) {
            return Err(damaged(&"its ids do not match its digests"));
        }
        kept.spheres.check()?;
        let scene = header.view.scene();
        let settings = scene.check().and_then(|()| header.view.settings());
        settings.and_then(|settings| settings.window_of(&scene)).map_err(|error| damaged(&error))?;
        Cuts::later(header.view.planes.clone()).map_err(|error| damaged(&error))?;
        Ok(Self { name, view: header.view, kept, digests: header.digests, counts: header.cut_counts })
    }

    /// JSON of the rays that the part was made for and of the spheres it was made from, for [`Part::new`].
    #[must_use]
    pub fn about(&self) -> String {
        let (view, digests) = (self.view.clone(), self.digests.clone());
        let (arrays, cut_counts) = (self.kept.digest(), self.counts.clone());
        let header = PartHeader { halfline: KIND.into(), view, digests, arrays, cut_counts };
        // Numbers, texts and lists are always JSON.
        serde_json::to_string(&header).unwrap_or_default()
    }

    /// The rays of the frame.
    #[must_use]
    pub fn view(&self) -> &PartView {
        &self.view
    }

    /// The ids of the spheres, in increasing order.
    #[must_use]
    pub fn ids(&self) -> &[u64] {
        &self.kept.numbers
    }

    /// The spheres that some ray may hit first.
    #[must_use]
    pub fn spheres(&self) -> &Spheres {
        &self.kept.spheres
    }

    /// The ids of all spheres that the part was made of, as intervals in order.
    #[must_use]
    pub fn all_ids(&self) -> Vec<[u64; 2]> {
        self.digests.ids()
    }

    /// The number of these ids.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.all_ids().iter().map(|[first, end]| end - first).sum()
    }

    /// The part of all spheres of two parts, which may have spheres in common. Whatever the order of several parts, the frame
    /// is the same.
    ///
    /// # Errors
    /// [`Error::Settings`] for parts of frames that differ, [`Error::Scene`] where an id has two spheres, [`Error::Limits`]
    /// where memory is short.
    pub fn combine(self, other: &Self) -> Result<Self> {
        self.combine_from(CULL_MIN_SPHERES, [Ok(other)])
    }

    /// The part of all spheres of this part and of others, which are taken one by one: they are sifted together whenever twice as many
    /// spheres are in memory as the last time.
    ///
    /// # Errors
    /// The first error of the other parts; errors of [`Part::combine`].
    pub fn combine_all(self, others: impl IntoIterator<Item = Result<Self>>) -> Result<Self> {
        self.combine_from(CULL_MIN_SPHERES, others)
    }

    /// The same, where spheres are not sifted before the end while there are at most `least`. Checks nothing itself.
    fn combine_from(
        mut self,
        least: usize,
        others: impl IntoIterator<Item = Result<impl Borrow<Self>>>,
    ) -> Result<Self> {
        let limit = |whole: &Self| least.max(2 * whole.kept.numbers.len());
        let (mut most, mut is_sifted) = (limit(&self), true);
        for part in others {
            is_sifted &= !self.append(part?.borrow())?;
            if self.kept.numbers.len() > most {
                self = self.sifted()?;
                (most, is_sifted) = (limit(&self), true);
            }
        }
        if is_sifted { Ok(self) } else { self.sifted() }
    }

    /// Adds the spheres of another part; others may hide some of them. Checks that both parts are of one frame, that no id has two
    /// spheres, and that both have the same lists of values. Returns whether there are new spheres.
    fn append(&mut self, other: &Self) -> Result<bool> {
        if let Some((what, [own, others])) = self.view.difference(&other.view) {
            let problem = format!(
                "{} and {} are parts of different frames: the {what} is {own}, and {others}",
                self.name, other.name
            );
            return Err(Error::settings(problem, ALIKE));
        }
        let mut digests = self.digests.clone();
        digests.join(&other.digests).map_err(|_| self.differ(other, "an id that both have".into()))?;
        let new = self.new_ones(other)?;
        let both = self.kept.spheres.carried().into_iter().zip(other.kept.spheres.carried());
        let unlike = both.map(|(own, others)| (own.0, own == others)).find(|(_, is_alike)| !is_alike);
        if let (Some((what, _)), false) = (unlike, self.kept.numbers.is_empty() || new.is_empty()) {
            let problem = format!("only one of {} and {} has {what}", self.name, other.name);
            return Err(Error::settings(problem, format!("give all parts {what}, or none")));
        }
        self.digests = digests;
        other.counts.iter().for_each(|counts| add_counts(&mut self.counts, counts));
        self.kept.add(&other.kept.spheres, &|n| other.kept.numbers[n], &new)?;
        self.kept.sort()?;
        Ok(!new.is_empty())
    }

    /// The same without spheres that others hide.
    fn sifted(self) -> Result<Self> {
        let mut stream = Stream::new(&self.view.scene(), &self.view.settings()?)?;
        stream.add_block(&self.kept.spheres, &|n| self.kept.numbers[n])?;
        Ok(Self { kept: stream.rest()?, ..self })
    }

    /// The spheres that a frame of `scene` needs, whose own spheres are not used; its fingerprint covers all spheres of the part.
    ///
    /// # Errors
    /// [`Error::Settings`] for a frame that the part is not made for.
    pub fn visible(self, scene: &Scene, settings: &Settings) -> Result<Visible> {
        check(scene, settings)?;
        let frame = PartView::new(scene, settings)?;
        if frame.tolerance > self.view.tolerance {
            let problem = format!("{} is made for a tolerance of {}", self.name, self.view.tolerance);
            return Err(Error::settings(problem, format!("use at most that as {TOLERANCE}")));
        }
        // A smaller tolerance sees no more, and one sample is the pixel's centre, which every part is made for.
        let mut own = PartView { tolerance: frame.tolerance, ..self.view.clone() };
        if frame.samples == 1 {
            (own.samples, own.seed) = (frame.samples, frame.seed);
        }
        if let Some((what, [own, given])) = own.difference(&frame) {
            let problem = format!("{} is made for another frame: its {what} is {own}, and not {given}", self.name);
            return Err(Error::settings(problem, "leave that to the parts, or sift again"));
        }
        let count = self.all_ids().last().map_or(0, |[_, end]| *end);
        let sum = |[cut, removed]: [u64; 2], [a, b]: [u64; 2]| [cut + a, removed + b];
        let changed = self.counts.iter().try_fold([0; 2], |all, own| Some(sum(all, own.counts?)));
        let ids = StreamIds { ids: self.kept.numbers, count, changed };
        let scene = Scene { lighting: scene.lighting.clone(), ..scene.bare() };
        scene.check()?;
        visible(scene, self.kept.spheres, ids, &self.digests)
    }

    /// Words about ids between 0 and the largest that no part has.
    #[must_use]
    pub fn gaps(&self) -> Option<String> {
        let known = self.all_ids();
        let starts = known.iter().map(|[first, _]| *first);
        let gaps: Vec<_> = [0]
            .into_iter()
            .chain(known.iter().map(|[_, end]| *end))
            .zip(starts)
            .filter(|(end, first)| end < first)
            .collect();
        let missing = gaps.iter().map(|(end, first)| first - end).sum::<u64>();
        let words = |(end, first): &(u64, u64)| format!("{end} to {}", first - 1);
        let first = words(gaps.first()?);
        let more = if gaps.len() > 1 { format!(", and {} more gaps", gaps.len() - 1) } else { String::new() };
        Some(format!("no part has the {} with ids {first}{more}", count(missing, "sphere")))
    }

    fn differ(&self, other: &Self, what: String) -> Error {
        let problem = format!("{} and {} have different spheres for {what}", self.name, other.name);
        Error::scene(
            Place::file(&other.name),
            problem,
            format!("give every sphere of the whole an id of its own with {FIRST_ID}"),
        )
    }

    /// The indices of the spheres of another part whose ids are new.
    ///
    /// # Errors
    /// [`Error::Scene`] for spheres with the same id and different numbers.
    fn new_ones(&self, other: &Self) -> Result<Vec<u32>> {
        let (mut new, mut own) = (Vec::new(), 0);
        for (n, id) in other.kept.numbers.iter().enumerate() {
            own += self.kept.numbers[own..].iter().take_while(|known| *known < id).count();
            if self.kept.numbers.get(own) != Some(id) {
                new.push(n as u32);
            } else if !self.kept.spheres.is_alike(own, &other.kept.spheres, n) {
                return Err(self.differ(other, format!("id {id}")));
            }
        }
        Ok(new)
    }
}

impl NumberedSpheres {
    /// BLAKE3 of all numbers.
    fn digest(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        parallel::hash(&mut hasher, bytemuck::cast_slice(&self.numbers));
        self.spheres.hash_to(&mut hasher);
        hasher.finalize().to_hex().to_string()
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ids =
            self.all_ids().iter().map(|[first, end]| format!("{first} to {}", end - 1)).collect::<Vec<_>>().join(", ");
        let kept = count(self.kept.numbers.len() as u64, "sphere");
        write!(f, "{kept} of {} may be hit first (ids {})", self.count(), if ids.is_empty() { "none" } else { &ids })
    }
}

impl fmt::Debug for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {self}", self.name)
    }
}

fn check_id(id: u64) -> Result<()> {
    if id <= MAX_SPHERES {
        return Ok(());
    }
    let problem = format!("an id of a part is {id} or more");
    Err(Error::Limits { problem, mend: format!("use ids below {MAX_SPHERES}") })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Aov, Frame};
    use crate::render::Renderer;
    use crate::scene::camera::{Lens, Look};
    use crate::settings::Backend;
    use crate::testing::Rng;
    use glam::DVec3;

    #[test]
    fn when_parts_are_sifted_changes_no_bit() {
        let plane = |normal: [f64; 3], distance| CutPlane { normal, distance };
        let planes = [vec![], vec![plane([0.3, 0.2, 1.0], 0.5), plane([1.0, 0.0, 0.0], 0.25)]];
        planes.iter().for_each(|planes| combined_in_every_way(planes));
    }

    fn combined_in_every_way(planes: &[CutPlane]) {
        let mut rng = Rng(7);
        let mut spheres = Spheres::default();
        for _ in 0..9000 {
            spheres.push([0; 3].map(|_| rng.between(-1.0, 1.0)), rng.between(0.02, 0.1), None);
        }
        let lens = Lens::Vfov { degrees: 40.0, distance: 1.0 };
        let camera = Camera { eye: DVec3::new(1.0, 2.0, 4.0), look: Look::At(DVec3::ZERO), up: DVec3::Y, lens };
        let image = ImagePlane { width: 60, height: 44, ..ImagePlane::default() };
        let mut scene = Scene { camera, image, spheres, lighting: Lighting::default() };
        scene.spheres.cut(planes, None).expect("planes");
        let aovs = vec![Aov::Color, Aov::Id, Aov::Distance, Aov::Normal, Aov::Certainty];
        let settings = Settings { backend: Backend::Cpu, aovs, ..Settings::default() };
        let part = |first: usize| {
            let mut stream = Stream::of_part(&scene, &settings, first as u64).expect("a stream");
            let mut block = Spheres::default();
            for n in first..first + 1500 {
                block.push(scene.spheres.centers[n], scene.spheres.radii[n], None);
            }
            stream.add(&block).and_then(|()| stream.part()).expect("a part")
        };
        let parts = [3000, 0, 7500, 1500, 6000, 3000, 4500].map(part);
        let (first, others) = parts.split_first().expect("a part");
        let all = parts.iter().map(|part| part.ids().len()).sum::<usize>();
        let mut renderer = Renderer::new(&settings).expect("the CPU path");
        let whole = renderer.render(&scene, &settings).expect("a frame");
        for least in [0, 2000, usize::MAX] {
            let part = first.clone().combine_from(least, others.iter().cloned().map(Ok)).expect("one frame");
            let kept = part.ids().len();
            assert!(2 * kept < all || !planes.is_empty(), "{least}: {kept} of {all}");
            let Visible { scene, ids } = part.visible(&scene, &settings).expect("the same frame");
            let mut frame = renderer.render(&scene, &settings).expect("a frame");
            ids.restore(&mut frame);
            assert!(whole.buffers == frame.buffers, "{least}");
            let counts = |frame: &Frame| [frame.report.spheres_cut, frame.report.spheres_removed];
            assert_eq!(counts(&whole), counts(&frame));
        }
        let [Some(cut), Some(removed)] = [whole.report.spheres_cut, whole.report.spheres_removed] else { panic!() };
        assert!(planes.is_empty() || cut > 100 && removed > 1000, "{cut}, {removed}");
    }

    /// Spheres of parts that overlap are counted once where both parts have the same ids, and else not at all.
    #[test]
    fn counts_of_parts_that_overlap_are_right_or_none() {
        let of = |first: u64, end: u64, counts| CutCounts { ids: [first, end], counts: Some(counts) };
        let mut all = Vec::new();
        for part in [of(100, 200, [3, 50]), of(0, 100, [1, 20]), of(100, 200, [3, 50])] {
            add_counts(&mut all, &part);
        }
        assert_eq!(all, [of(0, 100, [1, 20]), of(100, 200, [3, 50])]);
        add_counts(&mut all, &of(150, 250, [2, 30]));
        assert_eq!(all, [of(0, 100, [1, 20]), CutCounts { ids: [100, 250], counts: None }]);
    }
}
