//! Compares a frame with exact arithmetic: which pixels are wrong and how, and the errors of the right ones.
//!
//! The reference is the judge of [`halfline::exact`]. Per pixel, t* is the exact number and t the one in the frame (its
//! distance over |d|, so that t/t* is the ratio of the distances):
//!
//! - *false hit*, *false miss*, *wrong sphere*: by id.
//! - *wrong root*: the right id, but the distance is not finite, or it is nearer to the other intersection of the ray's
//!   line with the sphere than to the exact one, and differs by more than an ulp of f32.
//! - *ulp*, *radii*, *normal*: |t - t*| in units of the last place of f32 at t*, |t - t*| |d| / r, and the angle
//!   between the normals in degrees; only where sphere and root are right.
//! - *outline*: the relative change of radius that would make the wrong pixel right. A half-line at distance l_X from
//!   the centre of X hits it where l_X <= r_X, so showing A where nothing is hit costs l_A/r_A - 1, and showing nothing
//!   where B is hit costs 1 - l_B/r_B.
//! - *relative*: d = |t - t*| / t* where the right sphere is shown, even by its other root.
//!
//! A wrong sphere is a wrong outline or a wrong order. With A shown for B and d as above, A in front (t <= t*) is a
//! wrong outline of A if the ray misses A, else a wrong order by d. A behind (t > t*) means that B was missed or
//! ordered behind A: either a wrong outline of B, by its cost, or a wrong order by d. The frame does not show which, so
//! the smaller of both counts, or the one that was predicted ([`Score::given`]); A's outline is wrong in any case if
//! the ray misses it. A prediction {outline, distance} of a method must therefore be at least {outline, the largest
//! relative} of the errors of a score given that prediction.

mod crop;
#[cfg(test)]
mod tests;

use super::record::{Errors, Map, Spread, finite};
use halfline::error::{Error, Result};
use halfline::exact::{Judge, Root};
use halfline::frame::{Aov, Frame};
use halfline::intersect::predict::Prediction;
use halfline::parallel;
use halfline::progress::{Step, Watch};
use halfline::scene::Scene;
use halfline::scene::camera::Lens;

/// Pixels that one job judges.
const PIXELS_PER_JOB: usize = 1 << 8;

/// The most cells along the longer side of a map.
const CELLS: u32 = 160;

/// The exact answer of a pixel.
#[derive(Clone, Copy)]
struct ExactAnswer {
    id: u32,
    t: f64,
    distance: f64,
    /// The distance of the other root, negative behind the eye.
    other: f64,
    normal: [f64; 3],
}

/// The exact answers of all pixels of a scene, computed once for all frames that are compared with them.
pub struct Truths<'a> {
    scene: &'a Scene,
    judge: Judge,
    answers: Vec<Option<ExactAnswer>>,
}

/// The verdict on a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelVerdict {
    /// Sphere and root are right, or both are a miss.
    Right,
    /// A sphere is shown where the ray hits none.
    FalseHit,
    /// None is shown where the ray hits one.
    FalseMiss,
    /// Another sphere than the nearest is shown.
    WrongSphere,
    /// The right sphere, but its other root or no root.
    WrongRoot,
}

impl PixelVerdict {
    /// Its letter in a [`super::record::Crop`].
    #[must_use]
    pub fn letter(self) -> char {
        match self {
            Self::Right => '-',
            Self::FalseHit => 'h',
            Self::FalseMiss => 'm',
            Self::WrongSphere => 's',
            Self::WrongRoot => 'r',
        }
    }
}

/// The errors of one pixel; `None` where an error does not apply.
#[derive(Clone, Copy)]
struct Pixel {
    verdict: PixelVerdict,
    outline: Option<f64>,
    relative: Option<f64>,
    /// Either this outline or this relative error, where the frame does not show which.
    either: Option<[f64; 2]>,
    /// Errors in ulp of f32, radii and degrees.
    fine: Option<[f64; 3]>,
    of_bound: Option<f64>,
}

impl Pixel {
    /// Reduces two explanations to one; `by_order` says whether that is the relative error.
    fn explained(self, by_order: impl Fn([f64; 2]) -> bool) -> Self {
        match self.either {
            None => self,
            Some(either) if by_order(either) => Self { relative: Some(either[1]), either: None, ..self },
            Some([outline, _]) => {
                Self { outline: Some(self.outline.unwrap_or(0.0).max(outline)), either: None, ..self }
            }
        }
    }
}

/// The errors of one frame.
pub struct Score {
    size: [u32; 2],
    pixels: Vec<Pixel>,
}

impl<'a> Truths<'a> {
    /// Computes the exact answer of every pixel of `scene`, rows in parallel.
    ///
    /// # Errors
    /// Errors of [`Judge::new`]; [`Error::Settings`] for an orthographic camera, and for a lens with intrinsics.
    pub fn of(scene: &'a Scene) -> Result<Self> {
        Self::watched(scene, &Watch::default())
    }

    /// The same; `watch` is checked before every row.
    ///
    /// # Errors
    /// [`Error::Interrupted`] after a cancellation, else errors of [`Truths::of`].
    pub fn watched(scene: &'a Scene, watch: &Watch) -> Result<Self> {
        let judge = Judge::new(scene)?;
        let (width, height) = (scene.image.width, scene.image.height);
        let doing = watch.begin(Step::Settle, u64::from(width) * u64::from(height));
        let row = |i: u32| {
            let judge = &judge;
            let columns = if doing.next(u64::from(width)) { 0..width } else { 0..0 };
            columns.map(move |j| answer(judge, i, j))
        };
        let answers = parallel::collect(height as usize, 1, &|rows, out| out.extend(row(rows.start as u32)));
        doing.end()?;
        one_eye(scene)?;
        Ok(Self { scene, judge, answers })
    }

    /// The number of rays that hit.
    #[must_use]
    pub fn hits(&self) -> u64 {
        self.answers.iter().flatten().count() as u64
    }

    /// The errors of a frame of this scene; see [`Truths::score`].
    ///
    /// # Errors
    /// Errors of [`Truths::score`].
    pub fn errors(&self, frame: &Frame) -> Result<Errors> {
        Ok(self.score(frame)?.errors())
    }

    /// Compares a frame of this scene with the exact answers, pixel by pixel.
    ///
    /// # Errors
    /// [`Error::Settings`] for a frame of another size, or without the buffers of distance and normal.
    pub fn score(&self, frame: &Frame) -> Result<Score> {
        let size = [self.scene.image.width, self.scene.image.height];
        if [frame.width, frame.height] != size {
            let problem = format!("a frame of {} x {} is none of this scene", frame.width, frame.height);
            return Err(Error::settings(problem, format!("render it at {} x {}", size[0], size[1])));
        }
        let lacks = |aov: Aov| Error::settings(format!("the frame has no {aov} buffer"), "ask for it to be judged");
        let distances = frame.f64(Aov::Distance).ok_or_else(|| lacks(Aov::Distance))?;
        let normals = frame.f32(Aov::Normal).ok_or_else(|| lacks(Aov::Normal))?;
        let (ids, bounds) = (frame.ids(), frame.f64(Aov::Bound).filter(|_| frame.report.bound.is_some()));
        let pixel = |k: usize| {
            let normal = std::array::from_fn(|c| f64::from(normals[3 * k + c]));
            let mut pixel = self.pixel(k, ids[k], distances[k], normal);
            if let (Some(bounds), Some(truth), PixelVerdict::Right) = (bounds, self.answers[k], pixel.verdict) {
                let off = (distances[k] - truth.distance).abs();
                pixel.of_bound = Some(if off == 0.0 { 0.0 } else { off / bounds[k] });
            }
            pixel
        };
        let pixels = parallel::values(ids.len(), PIXELS_PER_JOB, pixel);
        Ok(Score { size, pixels })
    }

    fn pixel(&self, k: usize, id: i32, distance: f64, normal: [f64; 3]) -> Pixel {
        let none = Pixel {
            verdict: PixelVerdict::Right,
            outline: None,
            relative: None,
            either: None,
            fine: None,
            of_bound: None,
        };
        match (u32::try_from(id).ok(), self.answers[k]) {
            (None, None) => none,
            (Some(a), None) => Pixel { verdict: PixelVerdict::FalseHit, outline: Some(self.grow(k, a)), ..none },
            (None, Some(b)) => Pixel { verdict: PixelVerdict::FalseMiss, outline: Some(self.shrink(k, b.id)), ..none },
            (Some(a), Some(b)) if a == b.id => hit(&b, self.scene.spheres.radii[a as usize], distance, normal),
            (Some(a), Some(b)) => {
                Pixel { verdict: PixelVerdict::WrongSphere, ..self.confusion(none, k, a, b.id, distance, b.distance) }
            }
        }
    }

    /// The errors of a wrong sphere; the module's head derives them.
    fn confusion(&self, none: Pixel, k: usize, a: u32, b: u32, shown: f64, truth: f64) -> Pixel {
        let d = off(shown, truth);
        let grow = self.misses(k, a).then(|| self.grow(k, a));
        if shown <= truth {
            return Pixel { outline: grow, relative: grow.is_none().then_some(d), ..none };
        }
        Pixel { outline: grow, either: Some([self.shrink(k, b), d]), ..none }
    }

    /// Whether the ray misses a sphere exactly: its line does, or the sphere lies behind.
    fn misses(&self, k: usize, id: u32) -> bool {
        let [i, j] = self.place(k);
        self.judge.t(i, j, id, Root::Far).is_none_or(|t| t[0] <= 0.0)
    }

    /// The relative growth at which the ray would hit a sphere.
    fn grow(&self, k: usize, id: u32) -> f64 {
        let [i, j] = self.place(k);
        self.judge.excess(i, j, id).max(0.0)
    }

    /// The relative shrinkage at which the ray would miss it.
    fn shrink(&self, k: usize, id: u32) -> f64 {
        let [i, j] = self.place(k);
        (-self.judge.excess(i, j, id)).max(0.0)
    }

    /// Row and column.
    fn place(&self, k: usize) -> [u32; 2] {
        let width = self.scene.image.width as usize;
        [(k / width) as u32, (k % width) as u32]
    }
}

fn answer(judge: &Judge, i: u32, j: u32) -> Option<ExactAnswer> {
    let truth = judge.pixel(i, j)?;
    let other = if truth.root == Root::Near { Root::Far } else { Root::Near };
    // In units of the exact distance, so that the length of the direction is not needed.
    let ratio = judge.t(i, j, truth.id, other).map_or(1.0, |t| t[0] / truth.t);
    Some(ExactAnswer {
        id: truth.id,
        t: truth.t,
        distance: truth.distance,
        other: ratio * truth.distance,
        normal: truth.normal,
    })
}

/// Returns an error for cameras that the compared methods and the clearance computation do not support.
pub(super) fn one_eye(scene: &Scene) -> Result<()> {
    if scene.camera.lens.is_orthographic() {
        let problem = "the methods that are measured have one eye, and this camera is orthographic";
        return Err(Error::settings(problem, "give the camera a vfov instead of a height"));
    }
    if matches!(scene.camera.lens, Lens::Intrinsics { .. }) {
        let problem = "the clearance of rays is measured for lenses whose principal point is the middle of the image";
        return Err(Error::settings(problem, "give the camera a viewport or a vfov"));
    }
    Ok(())
}

/// The right sphere: its root and its error.
fn hit(truth: &ExactAnswer, radius: f64, distance: f64, normal: [f64; 3]) -> Pixel {
    let relative = off(distance, truth.distance);
    // t* / 2^e is its significand; f32 has 23 bits after the point.
    let ulps = relative * (truth.t / 2f64.powi(halfline::number::exponent(truth.t))) * f64::from(1u32 << 23);
    // Where f32 cannot distinguish the roots, the right one may round towards the other.
    let is_other_root = ulps > 1.0 && (distance - truth.other).abs() < (distance - truth.distance).abs();
    let wrong = !distance.is_finite() || is_other_root;
    let verdict = if wrong { PixelVerdict::WrongRoot } else { PixelVerdict::Right };
    let fine = [ulps, (distance - truth.distance).abs() / radius, degrees(normal, truth.normal)];
    Pixel {
        verdict,
        outline: None,
        relative: Some(relative),
        either: None,
        fine: (!wrong).then_some(fine),
        of_bound: None,
    }
}

/// |a - b| / b, infinite for NaN.
fn off(a: f64, b: f64) -> f64 {
    let off = (a - b).abs() / b;
    if off.is_nan() { f64::INFINITY } else { off }
}

/// The angle between two directions, infinite if one has no direction.
fn degrees(a: [f64; 3], b: [f64; 3]) -> f64 {
    let (a, b) = (glam::DVec3::from_array(a), glam::DVec3::from_array(b));
    let angle = a.cross(b).length().atan2(a.dot(b)).to_degrees();
    if angle.is_nan() || a == glam::DVec3::ZERO { f64::INFINITY } else { angle }
}

impl Score {
    /// Adds the pixels of another picture. The map is the first picture's.
    pub fn add(&mut self, other: Self) {
        self.pixels.extend(other.pixels);
    }

    /// The verdicts of the pixels, row by row.
    pub fn verdicts(&self) -> impl Iterator<Item = PixelVerdict> + '_ {
        self.pixels.iter().map(|pixel| pixel.verdict)
    }

    /// The same given a prediction: of two explanations the one that uses the smaller share of the prediction counts.
    #[must_use]
    pub fn given(self, predicted: &Prediction) -> Self {
        let by_order = |[outline, relative]: [f64; 2]| relative / predicted.distance <= outline / predicted.outline;
        Self { pixels: self.pixels.into_iter().map(|pixel| pixel.explained(by_order)).collect(), ..self }
    }

    /// The summary; of two explanations the smaller one counts.
    #[must_use]
    pub fn errors(&self) -> Errors {
        let by_order = |[outline, relative]: [f64; 2]| relative <= outline;
        let pixels: Vec<Pixel> = self.pixels.iter().map(|pixel| pixel.explained(by_order)).collect();
        let count = |verdict| self.verdicts().filter(|v| *v == verdict).count() as u64;
        let spread = |error: fn(&Pixel) -> Option<f64>| Spread::of(pixels.iter().filter_map(error).collect());
        Errors {
            pixels: self.pixels.len() as u64,
            false_hit: count(PixelVerdict::FalseHit),
            false_miss: count(PixelVerdict::FalseMiss),
            wrong_sphere: count(PixelVerdict::WrongSphere),
            wrong_root: count(PixelVerdict::WrongRoot),
            outline: finite(pixels.iter().filter_map(|pixel| pixel.outline).fold(0.0, f64::max)),
            relative: spread(|pixel| pixel.relative),
            ulp: spread(|pixel| pixel.fine.map(|[ulp, ..]| ulp)),
            radii: spread(|pixel| pixel.fine.map(|[_, radii, _]| radii)),
            normal: spread(|pixel| pixel.fine.map(|[.., degrees]| degrees)),
        }
    }

    /// Largest ratio of a distance error to its bound where the right sphere is shown; `None` for a frame without
    /// proven bounds or without hits.
    #[must_use]
    pub fn of_bound(&self) -> Option<f64> {
        self.pixels.iter().filter_map(|pixel| pixel.of_bound).reduce(f64::max)
    }

    /// A map of the errors of the (first) picture.
    #[must_use]
    pub fn map(&self) -> Map {
        let [width, height] = self.size;
        let pixels = &self.pixels[..(width as usize * height as usize).min(self.pixels.len())];
        let cell = width.max(height).div_ceil(CELLS).max(1);
        let size = self.size.map(|side| side.div_ceil(cell));
        let cells = (size[0] * size[1]) as usize;
        let mut map = Map { cell, size, error: vec![0.0; cells], wrong: vec![0; cells] };
        for (k, pixel) in pixels.iter().enumerate() {
            let [i, j] = [k as u32 / width, k as u32 % width];
            let n = (i / cell * size[0] + j / cell) as usize;
            if pixel.verdict != PixelVerdict::Right {
                map.wrong[n] += 1;
            } else if let Some(relative) = pixel.relative {
                map.error[n] = map.error[n].max(relative as f32);
            }
        }
        // Three digits are more than a picture shows, and make the file a third as large.
        map.error.iter_mut().for_each(|x| *x = format!("{x:.2e}").parse().unwrap_or(*x));
        map
    }
}

impl Spread {
    /// The quantiles of errors, none of them NaN: each number is one of the errors.
    pub(crate) fn of(mut errors: Vec<f64>) -> Self {
        parallel::sort(&mut errors, f64::total_cmp);
        let at = |share: f64| {
            let rank = (share * errors.len() as f64).ceil() as usize;
            errors.get(rank.saturating_sub(1)).map_or(Some(0.0), |x| finite(*x))
        };
        Self { median: at(0.5), p99: at(0.99), max: at(1.0) }
    }
}
