//! How a frame stands against the truth: which pixels are wrong and in what way, and how far off the right ones are.
//!
//! The gold standard is the judge of [`crate::exact`]. Per pixel, with t* the real number and t what the frame shows
//! (its distance over |d|, so that t/t* is the ratio of the distances):
//!
//! - *false hit*, *false miss*, *wrong sphere*: by id.
//! - *wrong root*: the right id, but the distance shown is no finite number, or nearer to where the ray's line meets
//!   the sphere the other time than to the truth, and off by more than an ulp of f32.
//! - *ulp*, *radii*, *normal*: |t - t*| in units of the last place of f32 at t*, |t - t*| |d| / r, and the angle
//!   between the normals in degrees; only where sphere and root are right.
//! - *outline*: the change of radius, relative to it, that would make the wrong pixel right. A half-line at l_X from
//!   the centre of X hits it where l_X <= r_X, so showing A where the truth is nothing costs l_A/r_A - 1, and showing
//!   nothing where the truth is B costs 1 - l_B/r_B.
//! - *relative*: d = |t - t*| / t* where the right sphere is shown, even by its other root.
//!
//! A wrong sphere is a wrong outline or a wrong order. With A shown for B and d as above, A in front (t <= t*) is a
//! wrong outline of A if the ray misses A, else a wrong order by d. A behind (t > t*) means that B was missed or put
//! behind A: either a wrong outline of B, by what that would cost, or a wrong order by d. Nothing tells which, so the
//! smaller of both counts, or the one that was predicted ([`Score::given`]); A's outline is wrong in any case if
//! the ray misses it. So whatever is predicted of a method as {outline, distance} must be at least {outline, the largest
//! relative} of the errors of a score given that prediction.

mod clearance;
mod crop;
#[cfg(test)]
mod tests;

use super::record::{Errors, Map, Spread, finite};
use crate::error::{Error, Result};
use crate::exact::{Judge, Root};
use crate::frame::{Aov, Frame};
use crate::predict::Prediction;
use crate::progress::{Step, Watch};
use crate::scene::Scene;
use clearance::Sight;
use rayon::prelude::*;

/// Cells along the longer side of a map, at most.
const CELLS: u32 = 160;

/// What one pixel really shows.
#[derive(Clone, Copy)]
struct Answer {
    id: u32,
    t: f64,
    distance: f64,
    /// The distance of the other root, negative behind the eye.
    other: f64,
    normal: [f64; 3],
}

/// The judge's answer for every pixel of a scene, made once for all the frames to be held against it.
pub struct Truths<'a> {
    scene: &'a Scene,
    judge: Judge,
    sight: Sight,
    answers: Vec<Option<Answer>>,
}

/// Refuses what the forms that are compared cannot render, and what tells how closely a ray passes a sphere does not know.
pub(super) fn one_eye(scene: &Scene) -> Result<()> {
    if scene.camera.lens.is_orthographic() {
        let problem = "the methods that are measured have one eye, and this camera is orthographic";
        return Err(Error::settings(problem, "give the camera a vfov instead of a height"));
    }
    Ok(())
}

/// How a pixel stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Sphere and root are right, or there is none.
    Right,
    /// A sphere is shown where the ray hits none.
    FalseHit,
    /// None is shown where the ray hits one.
    FalseMiss,
    /// Another sphere than the nearest is shown.
    WrongSphere,
    /// The right sphere, but its other root, or no root at all.
    WrongRoot,
}

impl Verdict {
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

/// One pixel against the truth; `None` where an error does not apply.
#[derive(Clone, Copy)]
struct Pixel {
    verdict: Verdict,
    outline: Option<f64>,
    relative: Option<f64>,
    /// Either this outline or this relative error, where nothing tells which.
    either: Option<[f64; 2]>,
    /// Ulp of f32, radii and degrees.
    fine: Option<[f64; 3]>,
    of_bound: Option<f64>,
}

impl Pixel {
    /// One explanation instead of two; `by_order` says whether that is the relative error.
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

/// One frame against the truth.
pub struct Score {
    size: [u32; 2],
    pixels: Vec<Pixel>,
}

impl<'a> Truths<'a> {
    /// Judges every pixel of `scene`, rows in parallel.
    ///
    /// # Errors
    /// Those of [`Judge::new`].
    pub fn of(scene: &'a Scene) -> Result<Self> {
        Self::watched(scene, &Watch::default())
    }

    /// The same; `watch` is asked before every row.
    ///
    /// # Errors
    /// [`Error::Interrupted`] when it says no, else as [`Truths::of`].
    pub fn watched(scene: &'a Scene, watch: &Watch) -> Result<Self> {
        let judge = Judge::new(scene)?;
        let (width, height) = (scene.image.width, scene.image.height);
        let doing = watch.begin(Step::Settle, u64::from(width) * u64::from(height));
        let row = |i: u32| {
            let judge = &judge;
            let columns = if doing.next(u64::from(width)) { 0..width } else { 0..0 };
            columns.map(move |j| answer(judge, i, j))
        };
        let answers: Vec<_> = (0..height).into_par_iter().flat_map_iter(row).collect();
        doing.end()?;
        let sight = Sight::of(scene)?;
        Ok(Self { scene, judge, sight, answers })
    }

    /// Rays that hit something.
    #[must_use]
    pub fn hits(&self) -> u64 {
        self.answers.iter().flatten().count() as u64
    }

    /// The errors of a frame of this scene; see [`Truths::score`].
    ///
    /// # Errors
    /// Those of [`Truths::score`].
    pub fn errors(&self, frame: &Frame) -> Result<Errors> {
        Ok(self.score(frame)?.errors())
    }

    /// Holds a frame of this scene against the truth, pixel by pixel.
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
            if let (Some(bounds), Some(truth), Verdict::Right) = (bounds, self.answers[k], pixel.verdict) {
                let off = (distances[k] - truth.distance).abs();
                pixel.of_bound = Some(if off == 0.0 { 0.0 } else { off / bounds[k] });
            }
            pixel
        };
        let pixels = (0..ids.len()).into_par_iter().map(pixel).collect();
        Ok(Score { size, pixels })
    }

    fn pixel(&self, k: usize, id: i32, distance: f64, normal: [f64; 3]) -> Pixel {
        let none =
            Pixel { verdict: Verdict::Right, outline: None, relative: None, either: None, fine: None, of_bound: None };
        match (u32::try_from(id).ok(), self.answers[k]) {
            (None, None) => none,
            (Some(a), None) => Pixel { verdict: Verdict::FalseHit, outline: Some(self.grow(k, a)), ..none },
            (None, Some(b)) => Pixel { verdict: Verdict::FalseMiss, outline: Some(self.shrink(k, b.id)), ..none },
            (Some(a), Some(b)) if a == b.id => hit(&b, self.scene.spheres.radii[a as usize], distance, normal),
            (Some(a), Some(b)) => {
                Pixel { verdict: Verdict::WrongSphere, ..self.confusion(none, k, a, b.id, distance, b.distance) }
            }
        }
    }

    /// What a wrong sphere says of outlines and of distances; the module's head derives it.
    fn confusion(&self, none: Pixel, k: usize, a: u32, b: u32, shown: f64, truth: f64) -> Pixel {
        let d = off(shown, truth);
        let grow = self.misses(k, a).then(|| self.grow(k, a));
        if shown <= truth {
            return Pixel { outline: grow, relative: grow.is_none().then_some(d), ..none };
        }
        Pixel { outline: grow, either: Some([self.shrink(k, b), d]), ..none }
    }

    /// Whether the ray really misses a sphere: its line does, or the sphere lies behind.
    fn misses(&self, k: usize, id: u32) -> bool {
        let [i, j] = self.place(k);
        self.judge.t(i, j, id, Root::Far).is_none_or(|t| t[0] <= 0.0)
    }

    /// How much larger a sphere would have to be for the ray to hit it.
    fn grow(&self, k: usize, id: u32) -> f64 {
        let [i, j] = self.place(k);
        self.sight.excess(self.scene, i, j, id).max(0.0)
    }

    /// How much smaller it would have to be for the ray to miss it.
    fn shrink(&self, k: usize, id: u32) -> f64 {
        let [i, j] = self.place(k);
        (-self.sight.excess(self.scene, i, j, id)).max(0.0)
    }

    /// Row and column.
    fn place(&self, k: usize) -> [u32; 2] {
        let width = self.scene.image.width as usize;
        [(k / width) as u32, (k % width) as u32]
    }
}

fn answer(judge: &Judge, i: u32, j: u32) -> Option<Answer> {
    let truth = judge.pixel(i, j)?;
    let other = if truth.root == Root::Near { Root::Far } else { Root::Near };
    // In units of the true distance, so that the length of the direction is not needed.
    let ratio = judge.t(i, j, truth.id, other).map_or(1.0, |t| t[0] / truth.t);
    Some(Answer {
        id: truth.id,
        t: truth.t,
        distance: truth.distance,
        other: ratio * truth.distance,
        normal: truth.normal,
    })
}

/// The right sphere: its root and how far off it is.
fn hit(truth: &Answer, radius: f64, distance: f64, normal: [f64; 3]) -> Pixel {
    let relative = off(distance, truth.distance);
    // t* / 2^e is its significand, of which f32 keeps 23 bits after the point.
    let ulps = relative * (truth.t / 2f64.powi(crate::dd::exponent(truth.t))) * f64::from(1u32 << 23);
    // Where f32 cannot tell the roots apart, the right one rounded may well be nearer to the other.
    let aside = ulps > 1.0 && (distance - truth.other).abs() < (distance - truth.distance).abs();
    let wrong = !distance.is_finite() || aside;
    let verdict = if wrong { Verdict::WrongRoot } else { Verdict::Right };
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

/// |a - b| / b, infinite for what is no number.
fn off(a: f64, b: f64) -> f64 {
    let off = (a - b).abs() / b;
    if off.is_nan() { f64::INFINITY } else { off }
}

/// The angle between two directions, infinite for what is none.
fn degrees(a: [f64; 3], b: [f64; 3]) -> f64 {
    let (a, b) = (glam::DVec3::from_array(a), glam::DVec3::from_array(b));
    let angle = a.cross(b).length().atan2(a.dot(b)).to_degrees();
    if angle.is_nan() || a == glam::DVec3::ZERO { f64::INFINITY } else { angle }
}

impl Score {
    /// Counts the pixels of another picture as well. A map is of the first one alone.
    pub fn add(&mut self, other: Self) {
        self.pixels.extend(other.pixels);
    }

    /// How each pixel stands, row by row.
    pub fn verdicts(&self) -> impl Iterator<Item = Verdict> + '_ {
        self.pixels.iter().map(|pixel| pixel.verdict)
    }

    /// The same beside a prediction: of two explanations the one that takes less of what was predicted.
    #[must_use]
    pub fn given(self, predicted: &Prediction) -> Self {
        let by_order = |[outline, relative]: [f64; 2]| relative / predicted.distance <= outline / predicted.outline;
        Self { pixels: self.pixels.into_iter().map(|pixel| pixel.explained(by_order)).collect(), ..self }
    }

    /// All of it in one set of numbers; of two explanations the smaller one counts.
    #[must_use]
    pub fn errors(&self) -> Errors {
        let by_order = |[outline, relative]: [f64; 2]| relative <= outline;
        let pixels: Vec<Pixel> = self.pixels.iter().map(|pixel| pixel.explained(by_order)).collect();
        let count = |verdict| self.verdicts().filter(|v| *v == verdict).count() as u64;
        let spread = |error: fn(&Pixel) -> Option<f64>| Spread::of(pixels.iter().filter_map(error).collect());
        Errors {
            pixels: self.pixels.len() as u64,
            false_hit: count(Verdict::FalseHit),
            false_miss: count(Verdict::FalseMiss),
            wrong_sphere: count(Verdict::WrongSphere),
            wrong_root: count(Verdict::WrongRoot),
            outline: finite(pixels.iter().filter_map(|pixel| pixel.outline).fold(0.0, f64::max)),
            relative: spread(|pixel| pixel.relative),
            ulp: spread(|pixel| pixel.fine.map(|[ulp, ..]| ulp)),
            radii: spread(|pixel| pixel.fine.map(|[_, radii, _]| radii)),
            normal: spread(|pixel| pixel.fine.map(|[.., degrees]| degrees)),
        }
    }

    /// Largest share that an error of the distance took of its bound where the right sphere is shown; `None` for a
    /// frame without proven bounds or without hits.
    #[must_use]
    pub fn of_bound(&self) -> Option<f64> {
        self.pixels.iter().filter_map(|pixel| pixel.of_bound).reduce(f64::max)
    }

    /// Where the (first) picture is wrong, in as many cells as a person can see.
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
            if pixel.verdict != Verdict::Right {
                map.wrong[n] += 1;
            } else if let Some(relative) = pixel.relative {
                map.error[n] = map.error[n].max(relative as f32);
            }
        }
        // Three digits are more than a picture shows, and a third of the file.
        map.error.iter_mut().for_each(|x| *x = format!("{x:.2e}").parse().unwrap_or(*x));
        map
    }
}

impl Spread {
    /// Of errors, none of them NaN: each number is one of them, the smallest that enough of them do not exceed.
    pub(crate) fn of(mut errors: Vec<f64>) -> Self {
        errors.par_sort_unstable_by(f64::total_cmp);
        let at = |share: f64| {
            let rank = (share * errors.len() as f64).ceil() as usize;
            errors.get(rank.saturating_sub(1)).map_or(Some(0.0), |x| finite(*x))
        };
        Self { median: at(0.5), p99: at(0.99), max: at(1.0) }
    }
}
