//! Lights and sky at the pixels of a frame: which of them the hit points see, and the colours that follow.

#[cfg(test)]
mod tests;

use super::given_certified::AnyHit;
use super::hidden::LightRay;
use crate::answers::lit::{Chunk, Lit};
use crate::certify::surface::{Own, SurfacePoint};
use crate::exact::{Judge, LightQuestion, Toward};
use crate::scene::{DEFAULT_COLOR, Light, LightSource, Scene, Sky};
use crate::search::tree::Tree;
use crate::search::tree::lanes::{Lanes, TASK, Work, dispatch};
use crate::shade::lit::{Reflected, of_light};
use crate::view::View;
use crate::view::directions::{DiscPoints, PixelSample, SkyDirections};
use crate::view::ray::NONE;
use glam::DVec3;
use rayon::prelude::*;

/// What is computed of lights and sky.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Wanted {
    /// The colour of the picture.
    pub(crate) color: bool,
    /// The share of each light that is hidden.
    pub(crate) shadow: bool,
    /// The share of the sky that is open.
    pub(crate) occlusion: bool,
}

/// A scene set up for its lights.
pub(crate) struct Lighting<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) view: &'a View,
    pub(crate) tree: &'a Tree,
    pub(crate) wanted: Wanted,
    /// Decides what f64 leaves unsure; `None` for answers that are not certified.
    pub(crate) judge: Option<&'a Judge>,
    /// The judge decides every ray.
    pub(crate) exact: bool,
    pub(crate) sky: Option<Sky>,
    pub(crate) directions: &'a SkyDirections,
    pub(crate) disc: &'a DiscPoints,
    pub(crate) seed: u32,
}

impl Wanted {
    /// Whether there is anything to compute.
    pub(crate) fn is_any(self) -> bool {
        self.color || self.shadow || self.occlusion
    }
}

impl Lighting<'_> {
    /// Fills `lit` for the pixels that show these spheres. `go_on` is called before every part of a row with its number
    /// of pixels; after `false` the rest is left unchanged.
    pub(crate) fn fill(&self, ids: &[u32], lit: &mut Lit, go_on: &(dyn Fn(u64) -> bool + Sync)) {
        let lights = self.scene.lighting.lights.len();
        let chunks: Vec<Chunk<'_>> = lit.chunks(ids.len(), TASK, lights).collect();
        let work = |mut chunk: Chunk<'_>| {
            let ids = &ids[chunk.first..chunk.first + chunk.count];
            let mut settled = Vec::new();
            if go_on(ids.len() as u64) {
                dispatch(Task { lighting: self, ids, chunk: &mut chunk, settled: &mut settled });
            }
            settled
        };
        lit.settled = chunks.into_par_iter().flat_map_iter(work).collect();
    }

    /// The hit point of a pixel.
    fn point(&self, pixel: u32, id: u32) -> SurfacePoint {
        let sphere = (id, self.scene.spheres.centers[id as usize], self.scene.spheres.radii[id as usize]);
        let placement = &self.tree.placement;
        let [i, j] = self.position(pixel);
        let point = SurfacePoint::seen(self.view, placement, [i, j], sphere);
        match self.judge {
            None => point.trusted(placement),
            Some(_) if point.is_sharp(placement) => point,
            Some(judge) => match judge.hit_of(i, j, (sphere.1, sphere.2)) {
                Some(truth) => SurfacePoint::judged(placement, &truth, sphere),
                None => point,
            },
        }
    }

    /// Row and column of a pixel's ray, in the finer frame of its samples.
    fn position(&self, pixel: u32) -> [u32; 2] {
        let [row, column] = self.view.record.place(pixel);
        self.view.record.sample_position(row, column)
    }
}

/// Some pixels of one row or more.
struct Task<'a, 'b, 'c> {
    lighting: &'a Lighting<'a>,
    ids: &'a [u32],
    chunk: &'b mut Chunk<'c>,
    settled: &'b mut Vec<u32>,
}

impl Work for Task<'_, '_, '_> {
    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) {
        let Task { lighting, ids, chunk, settled } = self;
        let Wanted { color, shadow, occlusion } = lighting.wanted;
        let scene = lighting.scene;
        let mut pixel = Pixel::new(lighting);
        for (n, &id) in ids.iter().enumerate() {
            let place = (chunk.first + n) as u32;
            if id == NONE {
                if color {
                    chunk.color[3 * n..3 * n + 3].copy_from_slice(&scene.image.background);
                }
                let lights = pixel.lights.len();
                if shadow {
                    chunk.shadow[n * lights..(n + 1) * lights].fill(0.0);
                }
                if occlusion {
                    chunk.occlusion[n] = 1.0;
                }
                continue;
            }
            pixel.see(lanes, place, id);
            if pixel.settle(place) {
                settled.push(place);
            }
            if shadow {
                let lights = pixel.lights.len();
                let shares = pixel.lights.iter().map(LightShare::hidden);
                chunk.shadow[n * lights..(n + 1) * lights].iter_mut().zip(shares).for_each(|(out, x)| *out = x);
            }
            if occlusion {
                chunk.occlusion[n] = pixel.sky.open() as f32;
            }
            if color {
                chunk.color[3 * n..3 * n + 3].copy_from_slice(&pixel.color(id));
            }
        }
    }
}

/// The rays of one light from one point.
#[derive(Debug, Clone, Copy, Default)]
struct LightShare {
    /// Rays, and those of them that are hidden.
    rays: u32,
    hidden: u32,
    /// The sum of the cosines of the others.
    reflected: f64,
    /// The point is on the light.
    shines: bool,
}

impl LightShare {
    fn hidden(&self) -> f32 {
        if self.rays == 0 { 0.0 } else { (f64::from(self.hidden) / f64::from(self.rays)) as f32 }
    }
}

/// The sky's rays from one point: their cosines, all of them and those that are open.
#[derive(Debug, Clone, Copy, Default)]
struct SkyShare {
    all: f64,
    open: f64,
}

impl SkyShare {
    fn open(&self) -> f64 {
        if self.all > 0.0 { self.open / self.all } else { 1.0 }
    }
}

/// What an unsure ray counts for.
#[derive(Debug, Clone, Copy)]
enum Of {
    Light(usize, f64),
    Sky(f64),
}

/// One pixel at work.
struct Pixel<'a> {
    of: &'a Lighting<'a>,
    lights: Vec<LightShare>,
    sky: SkyShare,
    center: [f64; 3],
    radius: f64,
    unsure: Vec<(Of, LightQuestion)>,
    directions: Vec<[f32; 3]>,
    disc: Vec<[f64; 2]>,
}

impl<'a> Pixel<'a> {
    fn new(of: &'a Lighting<'a>) -> Self {
        Self {
            of,
            lights: vec![LightShare::default(); of.scene.lighting.lights.len()],
            sky: SkyShare::default(),
            center: [0.0; 3],
            radius: 0.0,
            unsure: Vec::new(),
            directions: vec![[0.0; 3]; of.directions.len()],
            disc: vec![[0.0; 2]; of.disc.len()],
        }
    }

    /// Asks all lights and the sky at the hit of a sphere.
    #[inline(always)]
    fn see<L: Lanes>(&mut self, lanes: L, place: u32, id: u32) {
        let record = &self.of.view.record;
        let [row, column] = record.place(place);
        let at = PixelSample { row, column, sample: record.sample, seed: self.of.seed };
        let point = self.of.point(place, id);
        (self.center, self.radius) = (point.center, point.radius);
        self.unsure.clear();
        self.sky = SkyShare::default();
        for n in 0..self.lights.len() {
            self.lights[n] = LightShare::default();
            self.light(lanes, &point, n, at);
        }
        if self.of.sky.is_some() {
            self.sky(lanes, &point, at);
        }
    }

    #[inline(always)]
    fn light<L: Lanes>(&mut self, lanes: L, point: &SurfacePoint, n: usize, at: PixelSample) {
        let spheres = &self.of.scene.spheres;
        match self.of.scene.lighting.lights[n].source {
            LightSource::Direction(direction) => {
                self.light_ray(lanes, point, n, &Toward::Direction(direction.to_array()), NONE);
            }
            LightSource::Point(position) => {
                self.light_ray(lanes, point, n, &Toward::Point(position.to_array()), NONE);
            }
            LightSource::Sphere(id) if id == point.id => self.lights[n].shines = true,
            LightSource::Sphere(id) => {
                let ball = (DVec3::from_array(spheres.centers[id as usize]), spheres.radii[id as usize]);
                self.ball(lanes, point, n, ball, id, at);
            }
            LightSource::Ball { center, radius } => self.ball(lanes, point, n, (center, radius), NONE, at),
        }
    }

    /// A light with a size: points of its surface, spread evenly over the solid angle that the point sees.
    #[inline(always)]
    fn ball<L: Lanes>(
        &mut self,
        lanes: L,
        point: &SurfacePoint,
        n: usize,
        (center, radius): (DVec3, f64),
        light: u32,
        at: PixelSample,
    ) {
        let from = point.world();
        self.of.disc.of(at, n as u32, &mut self.disc);
        let Some(cap) = of_light::Cap::new(from, center, radius) else {
            // Inside the light.
            self.lights[n].reflected = 1.0;
            return;
        };
        for k in 0..self.disc.len() {
            let toward = Toward::Point(cap.point(self.disc[k]).to_array());
            self.light_ray(lanes, point, n, &toward, light);
        }
    }

    #[inline(always)]
    fn light_ray<L: Lanes>(&mut self, lanes: L, point: &SurfacePoint, n: usize, toward: &Toward, light: u32) {
        let tree = self.of.tree;
        let ray = point.ray(&tree.placement, toward);
        let cosine = ray.as_ref().map_or(0.0, |ray| point.cosine(ray).0);
        self.lights[n].rays += 1;
        let shadows = self.of.wanted.shadow || self.of.scene.lighting.shadows;
        let answer = match &ray {
            _ if !shadows => AnyHit::Free,
            Some(ray) if !self.of.exact => LightRay { tree, point, ray, light }.answer(lanes),
            _ => AnyHit::Unsure,
        };
        match answer {
            AnyHit::Free => self.lights[n].reflected += cosine.max(0.0),
            AnyHit::Blocked => self.hide(n, cosine.max(0.0)),
            AnyHit::Unsure => {
                // A ray of unknown direction may meet anything.
                let among = match &ray {
                    Some(ray) => LightRay { tree, point, ray, light }.candidates(),
                    None => tree.others(light),
                };
                let question = LightQuestion { toward: *toward, turned: false, among };
                self.unsure.push((Of::Light(n, cosine.max(0.0)), question));
            }
        }
    }

    #[inline(always)]
    fn sky<L: Lanes>(&mut self, lanes: L, point: &SurfacePoint, at: PixelSample) {
        let (tree, reach) = (self.of.tree, self.of.sky.map_or(f64::INFINITY, |sky| sky.reach));
        self.of.directions.of(at, &mut self.directions);
        for k in 0..self.directions.len() {
            let direction = self.directions[k].map(f64::from);
            let toward = |direction: [f64; 3]| match reach {
                f64::INFINITY => Toward::Direction(direction),
                reach => Toward::Within { direction, reach },
            };
            let Some(ray) = point.ray(&tree.placement, &toward(direction)) else { continue };
            let (cosine, side) = point.cosine(&ray);
            let weight = cosine.abs();
            self.sky.all += weight;
            let (toward, ray) = match side {
                Own::Open if !self.of.exact => (toward(direction), ray),
                Own::Hides if !self.of.exact => (toward(direction.map(|x| -x)), ray.turned()),
                _ => {
                    let both =
                        [ray, ray.turned()].map(|ray| LightRay { tree, point, ray: &ray, light: NONE }.candidates());
                    let question = LightQuestion { toward: toward(direction), turned: true, among: both.concat() };
                    self.unsure.push((Of::Sky(weight), question));
                    continue;
                }
            };
            let ray = LightRay { tree, point, ray: &ray, light: NONE };
            // From outside the sphere of the point does not hide what is on the side of its normal.
            match if point.outside { ray.others(lanes) } else { ray.answer(lanes) } {
                AnyHit::Free => self.sky.open += weight,
                AnyHit::Blocked => {}
                AnyHit::Unsure => {
                    let among = ray.candidates();
                    self.unsure.push((Of::Sky(weight), LightQuestion { toward, turned: false, among }));
                }
            }
        }
    }

    /// Counts a ray that is hidden.
    fn hide(&mut self, n: usize, cosine: f64) {
        self.lights[n].hidden += 1;
        if !self.of.scene.lighting.shadows {
            self.lights[n].reflected += cosine;
        }
    }

    /// Lets the judge decide the unsure rays; whether there were any. Without a judge they are hidden.
    fn settle(&mut self, place: u32) -> bool {
        if self.unsure.is_empty() {
            return false;
        }
        let (of, asked): (Vec<Of>, Vec<LightQuestion>) = self.unsure.drain(..).unzip();
        let [i, j] = self.of.position(place);
        let sphere = (self.center, self.radius);
        let answers = self.of.judge.and_then(|judge| judge.ask(i, j, sphere, &asked));
        let answers = answers.unwrap_or_else(|| vec![true; asked.len()]);
        for (of, hidden) in of.into_iter().zip(answers) {
            match (of, hidden) {
                (Of::Light(n, cosine), true) => self.hide(n, cosine),
                (Of::Light(n, cosine), false) => self.lights[n].reflected += cosine,
                (Of::Sky(_), true) => {}
                (Of::Sky(weight), false) => self.sky.open += weight,
            }
        }
        true
    }

    /// The colour that follows.
    fn color(&self, id: u32) -> [f32; 3] {
        let scene = self.of.scene;
        let own = scene.spheres.colors.as_ref().map_or(DEFAULT_COLOR, |colors| colors[id as usize]);
        let mut sum = Reflected::of_sky(scene.lighting.sky.map(|_| self.sky.open()), !self.lights.is_empty());
        for (light, share) in scene.lighting.lights.iter().zip(&self.lights) {
            let Light { color, intensity, .. } = *light;
            sum.add(
                color,
                intensity,
                if share.rays == 0 { share.reflected } else { share.reflected / f64::from(share.rays) },
            );
            if share.shines {
                sum.shine(color, intensity);
            }
        }
        sum.color(own)
    }
}
