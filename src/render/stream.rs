//! Frames of more spheres than fit in memory. The spheres arrive in blocks. Each block is projected and compared with the
//! depths that earlier blocks certainly cover, and what no ray of the frame can hit first is forgotten. The frame of what
//! remains has the bits of the frame of all spheres: docs/certificate.md, section 11.

mod digests;
mod instances;
mod kept;
mod left;
mod part;
mod pieces;
mod witness;

pub use part::{Part, PartView};

use crate::answers::silhouette::Line;
use crate::certify::sieve::{Sieve, Sifted, sift};
use crate::double_double::exponent;
use crate::frame::report::Report;
use crate::frame::{Aov, Data, Frame};
use crate::scene::instances::NumberedSpheres;
use crate::scene::{CutPlane, List, Scene, Spheres, removes_all};
use crate::settings::{Accuracy, Settings};
use crate::view::raster::Raster;
use crate::view::{middle, unit};
use digests::Digests;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::{check_wide_ids, ids_fit};
use halfline_ground::parallel;
use halfline_ground::quote::setting::{ACCURACY, AOV, APERTURE, LAYERS, LOOK, METHOD, OCCLUSION, SHADOWS, STREAM, SUN};
use left::{Left, left};
use witness::Witnesses;

/// The number of spheres after which the sieves take over the depths that these cover: often enough to hide spheres,
/// and seldom enough to cost little.
const REFRESH_SPHERES: usize = 1 << 18;

/// Candidates collected before they are culled again.
const CULL_MIN_SPHERES: usize = 1 << 22;

/// The spheres of a frame, block by block.
///
/// ```
/// use halfline::render::stream::Stream;
/// use halfline::{Accuracy, Settings};
/// # use halfline::{Camera, ImagePlane, Scene, Spheres};
/// # let image = ImagePlane { width: 32, height: 32, ..Default::default() };
/// # let spheres = Spheres { centers: vec![[0.0, 0.0, -3.0]].into(), radii: vec![1.0].into(), ..Spheres::default() };
/// # let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() };
///
/// let settings = Settings { accuracy: Accuracy::Certified, ..Settings::default() };
/// let mut stream = Stream::new(&scene, &settings)?;
/// for n in 0..3 {
///     let centers = vec![[0.0, 0.0, -3.0 - 4.0 * f64::from(n)]];
///     stream.add(&Spheres { centers: centers.into(), radii: vec![1.0].into(), ..Spheres::default() })?;
/// }
/// let visible = stream.finish()?;
/// let mut frame = halfline::render(&visible.scene, &settings)?;
/// visible.ids.restore(&mut frame);
/// assert_eq!(frame.report.spheres, 3);
/// # Ok::<(), halfline::Error>(())
/// ```
pub struct Stream {
    settings: Settings,
    /// The scene without spheres.
    scene: Scene,
    rasters: Vec<Raster>,
    /// One for the rays of each raster, from the first block on; none where the field of view has no bounds, so that all
    /// spheres are kept.
    sieves: Vec<Sieve>,
    /// The id of the stream's first sphere.
    first: u64,
    /// The numbers of spheres so far, and since the last refresh.
    count: u64,
    fresh: usize,
    kept: NumberedSpheres,
    /// The number of kept spheres at which hidden ones among them are removed again.
    limit: usize,
    witnesses: Witnesses,
    digests: Digests,
    /// The stream of the opaque spheres alone, where some may be translucent: a picture shows what these hide.
    opaque: Option<Box<Self>>,
    /// The spheres so far that planes cut, and those that they remove.
    changed: [u64; 2],
}

/// The remains of a stream: every sphere that some ray of the frame hits first.
#[derive(Debug)]
pub struct Visible {
    /// The scene with these spheres alone. Its fingerprint covers all spheres.
    pub scene: Scene,
    /// Their ids in the stream.
    pub ids: StreamIds,
}

/// The ids in a stream of the spheres that are left of it.
#[derive(Debug)]
pub struct StreamIds {
    /// By the index of the sphere, in increasing order.
    pub ids: Vec<u64>,
    /// The number of all spheres of the stream.
    pub count: u64,
    /// The spheres of the stream that planes cut, and those that they remove; `None` where parts that overlap do not tell.
    pub changed: Option<[u64; 2]>,
}

impl Stream {
    /// A frame of `scene`, whose own spheres are not used; the planes of their cuts cut the spheres of the stream.
    ///
    /// # Errors
    /// [`Error::Settings`] for what needs all spheres at once: lights and a sky, and answers without a certificate;
    /// errors of the camera and the image.
    pub fn new(scene: &Scene, settings: &Settings) -> Result<Self> {
        let scene = Scene { lighting: scene.lighting.clone(), ..scene.bare() };
        scene.check()?;
        let mend = format!("use such a camera, or render all spheres at once, without {STREAM}");
        scene.camera.lens.check_flat("a part or a stream", &mend)?;
        check(&scene, settings)?;
        let window = settings.window_of(&scene)?;
        let (width, height) = (scene.image.width, scene.image.height);
        // Lines along edges are drawn from the pixels around.
        let around =
            window.grown(if settings.silhouette { Line::new(settings.outline).margin() } else { 0 }, width, height);
        let samples = Raster::samples(around, settings.samples, settings.seed, &scene.image)?;
        let rasters = [Raster::centres(around)].into_iter().chain(samples).collect();
        let witnesses = Witnesses::new(scene.camera.basis()?);
        let (settings, kept, digests) = (settings.clone(), NumberedSpheres::default(), Digests::default());
        let sieves = Vec::new();
        Ok(Self {
            settings,
            scene,
            rasters,
            sieves,
            first: 0,
            count: 0,
            fresh: 0,
            kept,
            limit: CULL_MIN_SPHERES,
            witnesses,
            digests,
            opaque: None,
            changed: [0; 2],
        })
    }

    /// Adds the next spheres. Blocks of some 10^5 are fast. Blocks of
    /// `halfline_files::read::SphereBlocks` were checked by their reader, and others are checked here.
    ///
    /// # Errors
    /// [`Error::Scene`] for spheres that cannot be rendered, and for colours, opacities or materials that only some have;
    /// [`Error::Limits`] for more spheres than ids can number, and where memory is short.
    pub fn add(&mut self, block: &Spheres) -> Result<()> {
        if block.is_empty() {
            return Ok(());
        }
        block.check()?;
        let (first, size) = (self.first + self.count, block.len());
        check_wide_ids(first.saturating_add(size as u64))?;
        let mut digests = std::mem::take(&mut self.digests);
        // Places are new, so bytes cannot differ.
        let (added, _) = parallel::join(|| self.add_block(block, &|n| first + n as u64), || digests.add(first, block));
        self.digests = digests;
        self.count += size as u64;
        added
    }

    /// The planes that cut spheres.
    fn planes(&self) -> &[CutPlane] {
        self.scene.spheres.cuts.as_ref().map_or(&[], |cuts| &cuts.planes)
    }

    /// Adds the spheres of a block, whose numbers `number` gives, without a fingerprint.
    fn add_block(&mut self, block: &Spheres, number: &(impl Fn(usize) -> u64 + Sync)) -> Result<()> {
        if block.cuts.is_some() {
            let problem = "planes cut the spheres of a block, and the planes of a stream belong to its scene";
            return Err(Error::scene(Place::field("spheres"), problem, "give them to the scene"));
        }
        let Some(Left { spheres, places, changed }) = left(block, self.planes())? else {
            return self.add_left(block, number);
        };
        self.changed.iter_mut().zip(changed).for_each(|(sum, own)| *sum += own);
        if spheres.is_empty() { Ok(()) } else { self.add_left(&spheres, &|n| number(places[n])) }
    }

    /// Adds the spheres that planes leave of a block.
    fn add_left(&mut self, block: &Spheres, number: &(impl Fn(usize) -> u64 + Sync)) -> Result<()> {
        let is_first = self.kept.numbers.is_empty() && self.sieves.is_empty();
        let unlike = self.kept.spheres.carried() != block.carried();
        if block.materials.is_some() || !is_first && unlike {
            let problem = "some spheres have colours, opacities or materials and others do not";
            return Err(Error::scene(Place::field("spheres"), problem, "use the same for all, without materials"));
        }
        if is_first {
            self.make_sieves(unit(self.scene.camera.basis()?.e, &block.centers, &block.radii)?)?;
        }
        self.add_opaque(block, number)?;
        self.witnesses.add_first(block, number);
        self.witnesses.see(block, number);
        self.keep_open(block, number)?;
        self.fresh += block.len();
        if self.fresh >= REFRESH_SPHERES {
            self.refresh();
        }
        Ok(())
    }

    /// Adds the opaque spheres of a block to the stream of these alone, where the spheres have opacities.
    fn add_opaque(&mut self, block: &Spheres, number: &(impl Fn(usize) -> u64 + Sync)) -> Result<()> {
        let Some(opacities) = &block.opacities else { return Ok(()) };
        let flags = parallel::map(opacities, |opacity| *opacity == 1.0);
        let mut alone = Spheres { opacities: None, cuts: None, ..block.clone() };
        alone.keep(&flags);
        let opaque = match self.opaque.take() {
            Some(opaque) => opaque,
            None => Box::new(Self::new(&self.scene, &self.settings)?),
        };
        let opaque = self.opaque.insert(opaque);
        let numbers: Vec<u64> = (0..block.len()).filter(|n| flags[*n]).map(number).collect();
        if alone.is_empty() { Ok(()) } else { opaque.add_numbered(&alone, &numbers) }
    }

    /// Adds spheres with these numbers, without a fingerprint.
    fn add_numbered(&mut self, block: &Spheres, numbers: &[u64]) -> Result<()> {
        self.add_block(block, &|n| numbers[n])
    }

    /// Keeps the spheres of a block that some ray may hit first, and those that the frame takes numbers from. Cut spheres hide nothing.
    fn keep_open(&mut self, block: &Spheres, number: &impl Fn(usize) -> u64) -> Result<()> {
        let Some(cuts) = &block.cuts else { return self.keep_some(block, number, true) };
        for is_cut in [false, true] {
            let some: Vec<u32> = (0..block.len() as u32).filter(|n| cuts.is_cut(*n) == is_cut).collect();
            let mut chosen = block.clone();
            chosen.choose(&some);
            self.keep_some(&chosen, &|n| number(some[n] as usize), !is_cut)?;
        }
        Ok(())
    }

    /// The same for spheres that all hide others, if they `cover`; else none of them does.
    fn keep_some(&mut self, block: &Spheres, number: &impl Fn(usize) -> u64, cover: bool) -> Result<()> {
        if block.is_empty() {
            return Ok(());
        }
        let Sifted { kept, marks } = sift(&self.sieves, block, cover);
        let indices: Vec<u32> = (0..kept.len() as u32).filter(|n| kept[*n as usize]).collect();
        self.kept.add(block, number, &indices)?;
        self.witnesses.mark(block, number, &marks, self.unit());
        if self.kept.numbers.len() > self.limit {
            self.forget();
        }
        Ok(())
    }

    /// The exponent of the unit of the sieves' depths.
    fn unit(&self) -> i32 {
        self.sieves.first().map_or(0, Sieve::unit)
    }

    /// Adds the depths that spheres have covered since the last refresh to the sieves.
    fn refresh(&mut self) {
        self.fresh = 0;
        self.sieves.iter_mut().for_each(Sieve::refresh);
    }

    /// The spheres that the frame needs.
    ///
    /// # Errors
    /// [`Error::Limits`] where memory is short.
    pub fn finish(mut self) -> Result<Visible> {
        let kept = self.rest()?;
        let ids = StreamIds { ids: kept.numbers, count: self.count, changed: Some(self.changed) };
        visible(self.scene, kept.spheres, ids, &self.digests)
    }

    /// The spheres that are kept, in order.
    fn rest(&mut self) -> Result<NumberedSpheres> {
        self.refresh();
        self.forget();
        self.check_unit()?;
        drop(std::mem::take(&mut self.sieves));
        let kept = std::mem::take(&mut self.kept).with(self.witnesses.all())?;
        let Some(mut opaque) = self.opaque.take() else { return Ok(kept) };
        let mut behind = opaque.rest()?;
        behind.spheres.opacities = Some(vec![1.0; behind.numbers.len()].into());
        kept.united(&behind)
    }

    /// Makes the sieves in the unit 2^`unit`.
    fn make_sieves(&mut self, unit: i32) -> Result<()> {
        let tolerance = self.settings.promise().relative();
        let made = self.rasters.iter().map(|raster| Sieve::new(&self.scene, *raster, unit, tolerance));
        self.sieves = made.collect::<Result<Option<Vec<_>>>>()?.unwrap_or_default();
        Ok(())
    }

    /// Refuses spheres so far apart that some that are forgotten would be general in the unit of all.
    fn check_unit(&self) -> Result<()> {
        let sizes = [-self.witnesses.score(1), self.witnesses.score(0)].map(exponent);
        let is_in_range = |(n, sieve): (usize, &Sieve)| {
            let [least, most] = [0, 1].map(|end| self.witnesses.end(n, end));
            !most.is_finite() || [-least, most].into_iter().all(|depth| sieve.holds(depth, middle(sizes)))
        };
        if self.sieves.iter().enumerate().all(is_in_range) {
            return Ok(());
        }
        let [least, most] = sizes;
        let problem =
            format!("sizes and distances from 2^{least} to 2^{most} are too far apart to forget hidden spheres");
        Err(Error::scene(Place::field("spheres"), problem, format!("render them in memory, without {STREAM}")))
    }

    /// Forgets spheres that are hidden by now.
    fn forget(&mut self) {
        self.kept.keep(&sift(&self.sieves, &self.kept.spheres, false).kept);
        self.limit = CULL_MIN_SPHERES.max(2 * self.kept.numbers.len());
    }
}

/// Refuses settings that need all spheres at once or are uncertified.
fn check(scene: &Scene, settings: &Settings) -> Result<()> {
    let has_lights = scene.lighting.has_light();
    let (problem, mend) = if settings.method.is_some() || settings.accuracy == Accuracy::Fast {
        (
            "answers of a stream are certified or exact",
            format!("remove {METHOD}, and use {ACCURACY} certified or exact"),
        )
    } else if settings.asks(&[Aov::Shadow, Aov::Occlusion]) || has_lights && settings.asks(&[Aov::Color]) {
        (
            "lights and a sky need all spheres in memory",
            format!(
                "use {LOOK} plain, without {SUN}, {SHADOWS}, {OCCLUSION}, {AOV} shadow and occlusion, and lights of the scene"
            ),
        )
    } else if settings.layers > 1 {
        let problem = "more than one layer of translucent spheres needs all spheres in memory";
        return Err(Error::settings(problem, format!("remove {LAYERS}, or {STREAM}")));
    } else if settings.aperture.is_some() {
        ("a lens with a size sees spheres that a stream has forgotten", format!("remove {APERTURE}, or {STREAM}"))
    } else {
        return Ok(());
    };
    Err(Error::settings(problem, mend))
}

/// A scene of these spheres with the fingerprint of all.
///
/// # Errors
/// As [`Spheres::cut`].
fn visible(scene: Scene, spheres: Spheres, ids: StreamIds, digests: &Digests) -> Result<Visible> {
    let cuts = scene.spheres.cuts.as_ref();
    let cuts =
        cuts.filter(|_| ids.changed != Some([0; 2])).map(|cuts| spheres.cuts_by(&cuts.planes, None)).transpose()?;
    let [centers, radii, colors, opacities] = digests.all();
    let spheres = Spheres {
        centers: List::part_of(spheres.centers.into_vec(), centers),
        radii: List::part_of(spheres.radii.into_vec(), radii),
        colors: spheres.colors.map(|values| List::part_of(values.into_vec(), colors)),
        materials: None,
        opacities: spheres.opacities.map(|values| List::part_of(values.into_vec(), opacities)),
        cuts,
    };
    Ok(Visible { scene: Scene { spheres, ..scene }, ids })
}

impl StreamIds {
    /// Whether ids need 64 bits.
    #[must_use]
    pub fn are_wide(&self) -> bool {
        !ids_fit(self.count)
    }

    /// Puts the ids of the stream into a frame of [`Visible::scene`], and the number of its spheres into the report. Ids
    /// that do not fit into 32 bits make the buffer one of 64-bit numbers.
    pub fn restore(&self, frame: &mut Frame) {
        let Report { spheres, spheres_cut, spheres_removed, warnings, .. } = &mut frame.report;
        ([*spheres_cut, *spheres_removed], *spheres) = ([0, 1].map(|n| Some(self.changed?[n])), self.count);
        if let Some([_, removed]) = self.changed.filter(|[_, removed]| *removed > 0) {
            warnings.extend(removes_all(removed, self.count));
        }
        for buffer in frame.buffers.iter_mut().filter(|buffer| buffer.aov == Aov::Id) {
            let Data::I32(ids) = &mut buffer.data else { continue };
            let of_stream = |id: i32| usize::try_from(id).ok().and_then(|n| self.ids.get(n)).copied();
            if self.are_wide() {
                buffer.data = Data::I64(parallel::map(ids, |id| of_stream(*id).map_or(i64::from(*id), |id| id as i64)));
            } else {
                parallel::each(ids, |_, id| *id = of_stream(*id).map_or(*id, |id| id as i32));
            }
        }
    }
}
