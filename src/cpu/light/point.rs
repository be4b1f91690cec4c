//! Light that reaches one point from lights and sky.

use super::super::hidden::{LightRay, all_but};
use super::lighting::LightingContext;
use super::surface::Surface;
use crate::answers::open_sky::{SkyAtHit, SkySums};
use crate::certify::cut::PointPlanes;
use crate::certify::given::{AnyHit, CertifiedRay};
use crate::certify::surface::SurfacePoint;
use crate::exact::{LightQuestion, Toward};
use crate::scene::{Ball, LightSource, Material, Sky};
use crate::shade::cap::Cap;
use crate::shade::optics::reflected;
use crate::view::directions::PixelSample;
use crate::view::ray::dot3;
use glam::{DVec3, Vec3};

/// The rays of one light from one point.
#[derive(Debug, Clone, Copy, Default)]
struct LightShare {
    /// Number of rays to the light.
    rays: u32,
    /// Number of them that are hidden.
    hidden: u32,
    /// The sum of the cosines of the rays whose light counts.
    reflected: f64,
    /// The sum of their highlights.
    gloss: f64,
    /// Whether a point of the rim is hidden, and whether one is open.
    rim: [bool; 2],
    /// The point is on the light.
    shines: bool,
    /// The point is in the light, or on it: lit from all sides.
    inside: bool,
}

/// The share that is hidden, or seen, where only points of a light's rim are: so small that it changes no mean.
const NEARLY: f32 = 1.0 / (1u32 << 16) as f32;

impl LightShare {
    /// Adds the cosine and the highlight of a ray whose light counts.
    fn add(&mut self, [cosine, gloss]: [f64; 2]) {
        self.reflected += cosine;
        self.gloss += gloss;
    }

    /// The part of the light that the point reflects, and its highlight.
    fn response(&self) -> [f64; 2] {
        let rays = f64::from(self.rays.max(1));
        if self.inside { [1.0, 0.0] } else { [self.reflected / rays, self.gloss / rays] }
    }

    /// The share that is hidden. Where the rim differs from all points within, it is nearly 0 or 1: the light is neither
    /// wholly hidden nor wholly seen.
    fn hidden(&self) -> f32 {
        let [some_hidden, some_open] = self.rim;
        match (self.hidden, self.rays) {
            _ if self.inside => 0.0,
            (_, 0) => 0.0,
            (0, _) if some_hidden => NEARLY,
            (hidden, rays) if hidden == rays && some_open => 1.0 - NEARLY,
            (hidden, rays) => (f64::from(hidden) / f64::from(rays)) as f32,
        }
    }
}

/// The sky's rays from one point: the sum of all cosines, that over open rays, and the sums for pictures.
#[derive(Debug, Clone, Copy, Default)]
struct SkyShare {
    all: f64,
    open: f64,
    sums: SkySums,
}

/// The sum that an undecided ray will be added to.
#[derive(Debug, Clone, Copy)]
enum PendingRay {
    Light(usize, [f64; 2]),
    Rim(usize),
    /// A light that is infinitely far.
    Far(usize),
    /// With its cosine and the direction on the side of the normal.
    Sky(f64, [f64; 3]),
    Inside(usize),
}

/// The light from all lights and the sky at one point; one value serves point after point.
pub(super) struct PointLight<'a> {
    pub(super) lighting: &'a LightingContext<'a>,
    /// Toward each light that is infinitely far, of length 1.
    far: Vec<Option<DVec3>>,
    lights: Vec<LightShare>,
    sky: SkyShare,
    /// The direction in which a mirror would reflect the ray, and the exponent of highlights; 0 for none.
    mirrored: DVec3,
    shine: f32,
    unsure: Vec<(PendingRay, LightQuestion)>,
    disc: Vec<[f64; 2]>,
    /// The planes that cut spheres, as the point sees them.
    planes: PointPlanes,
}

impl<'a> PointLight<'a> {
    pub(super) fn new(lighting: &'a LightingContext<'a>) -> Self {
        let lights = &lighting.scene.lighting.lights;
        Self {
            lighting,
            far: lights.iter().map(|light| light.source.far()).collect(),
            lights: vec![LightShare::default(); lights.len()],
            sky: SkyShare::default(),
            mirrored: DVec3::ZERO,
            shine: 0.0,
            unsure: Vec::new(),
            disc: vec![[0.0; 2]; lighting.disc.len()],
            planes: PointPlanes::default(),
        }
    }

    /// Begins the surface that a ray in the unit direction `along` meets, and forgets the one before. `sky` is the
    /// sums over the rays toward the sky there. Infinitely far lights are added at once, without rays, as if nothing hid them.
    pub(super) fn begin(&mut self, surface: &Surface, along: DVec3, sky: SkySums) {
        self.unsure.clear();
        self.sky = SkyShare { sums: sky, ..SkyShare::default() };
        self.mirrored = reflected(along, surface.normal);
        self.shine = match self.lighting.material(surface.id) {
            Material::Phong { specular, shine, .. } if specular > 0.0 && shine > 0.0 => shine,
            Material::Plastic { shine, .. } => shine,
            _ => 0.0,
        };
        for n in 0..self.lights.len() {
            self.lights[n] = LightShare::default();
            if let Some(direction) = self.far[n] {
                let cosine = surface.normal.dot(direction).max(0.0);
                let highlight = if cosine > 0.0 { self.highlight(self.mirrored.dot(direction)) } else { 0.0 };
                self.lights[n].rays = 1;
                self.lights[n].add([cosine, highlight]);
            }
        }
    }

    /// Traces rays to all lights for which [`Self::begin`] does not suffice.
    pub(super) fn trace_lights(&mut self, point: &SurfacePoint, at: PixelSample) {
        self.see_planes(point);
        for n in 0..self.lights.len() {
            self.light(point, n, at);
        }
    }

    fn see_planes(&mut self, point: &SurfacePoint) {
        if let Some(cuts) = &self.lighting.cuts {
            let is_kept = !cuts.cuts.is_spared(point.id);
            self.planes.begin(&cuts.planes, &self.lighting.tree.placement, point, is_kept);
        }
    }

    /// The ray from the point to a light among the spheres that may hide it.
    fn light_ray_of<'r>(&'r self, point: &'r SurfacePoint, ray: &'r CertifiedRay, light: Option<Ball>) -> LightRay<'r> {
        let whole = LightRay::new(self.lighting.blockers, point, ray, light);
        match &self.lighting.cuts {
            Some(cuts) => whole.cut_by(cuts, &self.planes),
            None => whole,
        }
    }

    /// Applies a device's answers for the lights; none has a size. `is_open` tells for each whether nothing
    /// hides it.
    pub(super) fn apply_traced_lights<'p>(
        &mut self,
        point: impl Fn() -> &'p SurfacePoint,
        is_open: impl Fn(usize) -> bool,
    ) {
        for n in 0..self.lights.len() {
            let hidden = !is_open(n);
            match self.lighting.scene.lighting.lights[n].source {
                LightSource::Point(position) => {
                    // What it would give needs the point, for the colour alone.
                    let toward = Toward::Point(position.to_array());
                    let response = || {
                        let point = point();
                        self.response(point, point.aim(&self.lighting.tree.placement, &toward).as_ref())
                    };
                    let response = if self.lighting.outputs.color { response() } else { [0.0; 2] };
                    self.lights[n].rays += 1;
                    if hidden { self.hide(n, response) } else { self.lights[n].add(response) }
                }
                _ if hidden => self.hide_far(n),
                _ => {}
            }
        }
    }

    /// The cosine and the highlight of a ray to a light.
    #[inline(always)]
    fn response(&self, point: &SurfacePoint, ray: Option<&CertifiedRay>) -> [f64; 2] {
        let cosine = ray.map_or(0.0, |ray| point.cosine(ray).0.max(0.0));
        let highlight =
            |ray: &CertifiedRay| self.highlight(dot3(self.mirrored.to_array(), ray.direction) / ray.a.sqrt());
        [cosine, ray.filter(|_| cosine > 0.0).map_or(0.0, highlight)]
    }

    /// Sums the sky's rays, whose answers are known. `is_open` tells for each whether nothing hides the sky there.
    pub(super) fn open_sky(&mut self, surface: &Surface, at: PixelSample, is_open: impl Fn(usize) -> bool) {
        self.sky = SkyShare::default();
        let directions = self.lighting.directions.of(at, 0);
        if self.lighting.outputs.occlusion {
            // The same sums without branches.
            let (mut all, mut open) = (0.0, 0.0);
            for (k, direction) in directions.iter().enumerate() {
                let weight = surface.normal.dot(direction.map(f64::from).into()).abs();
                all += weight;
                open += if is_open(k) { weight } else { 0.0 };
            }
            (self.sky.all, self.sky.open) = (all, open);
            return;
        }
        for (k, direction) in directions.iter().enumerate() {
            let (weight, outward) = self.weigh(surface, direction.map(f64::from));
            if is_open(k) {
                self.see_sky(weight, outward);
            }
        }
    }

    /// Share of each light that is hidden.
    pub(super) fn hidden(&self) -> impl Iterator<Item = f32> {
        self.lights.iter().map(LightShare::hidden)
    }

    /// Share of the sky that is open.
    pub(super) fn open(&self) -> f64 {
        if self.sky.all > 0.0 { self.sky.open / self.sky.all } else { 1.0 }
    }

    /// The rays toward the sky from this surface.
    pub(super) fn sky_at(&self, surface: &Surface) -> SkyAtHit {
        SkyAtHit { normal: surface.normal, sums: self.sky.sums }
    }

    /// Counts a ray of the sky that is open.
    fn see_sky(&mut self, weight: f64, direction: [f64; 3]) {
        self.sky.open += weight;
        self.sky.sums.add_open(direction.into(), self.lighting.colors.as_ref());
    }

    /// Counts an infinitely far light as hidden, and with shadows takes its light away.
    fn hide_far(&mut self, n: usize) {
        self.lights[n].hidden = 1;
        if self.lighting.scene.lighting.shadows {
            (self.lights[n].reflected, self.lights[n].gloss) = (0.0, 0.0);
        }
    }

    fn light(&mut self, point: &SurfacePoint, n: usize, at: PixelSample) {
        let spheres = &self.lighting.scene.spheres;
        match self.lighting.scene.lighting.lights[n].source {
            LightSource::Direction(direction) if self.casts_shadows() => {
                let toward = Toward::Direction(direction.to_array());
                let ray = point.aim(&self.lighting.tree.placement, &toward);
                match self.ask(point, &toward, ray.as_ref(), None) {
                    (_, Some(question)) => self.unsure.push((PendingRay::Far(n), question)),
                    (AnyHit::Blocked, None) => self.hide_far(n),
                    _ => {}
                }
            }
            LightSource::Direction(_) => {}
            LightSource::Point(position) => {
                self.light_ray(point, n, &Toward::Point(position.to_array()), None);
            }
            LightSource::Sphere(id) => {
                let ball = spheres.ball(id);
                match ball == point.ball {
                    true => self.lights[n].shines = true,
                    false => self.ball(point, n, ball, at),
                }
            }
            LightSource::Ball { center, radius } => self.ball(point, n, Ball { center: center.to_array(), radius }, at),
        }
    }

    /// A light with a size: points of its surface, spread evenly over the solid angle that the point sees.
    fn ball(&mut self, point: &SurfacePoint, n: usize, ball: Ball, at: PixelSample) {
        let Ball { center, radius } = ball;
        let shining = point.shining(&self.lighting.tree.placement, ball);
        match shining.inside {
            Some(true) => {
                self.lights[n].inside = true;
                return;
            }
            Some(false) if !self.lighting.exact => {}
            _ => self.unsure.push((PendingRay::Inside(n), LightQuestion::Outside(ball))),
        }
        let cap = Cap::new(shining.away, shining.radius);
        let offset_of = |place| (cap.outward(place) * radius).to_array();
        self.lighting.disc.of(at, n as u32, &mut self.disc);
        for k in 0..self.disc.len() {
            let toward = Toward::OffsetPoint { center, offset: offset_of(self.disc[k]) };
            self.light_ray(point, n, &toward, Some(ball));
        }
        if !self.casts_shadows() {
            return;
        }
        let disc = self.lighting.disc;
        for place in disc.rim(at, n as u32) {
            let toward = Toward::OffsetPoint { center, offset: offset_of(place) };
            let ray = point.ray(&self.lighting.tree.placement, &toward);
            let (answer, question) = self.ask(point, &toward, ray.as_ref(), Some(ball));
            match question {
                Some(question) => self.unsure.push((PendingRay::Rim(n), question)),
                None => self.lights[n].rim[usize::from(answer != AnyHit::Blocked)] = true,
            }
        }
    }

    fn casts_shadows(&self) -> bool {
        self.lighting.outputs.casts_shadows(&self.lighting.scene.lighting)
    }

    fn light_ray(&mut self, point: &SurfacePoint, n: usize, toward: &Toward, light: Option<Ball>) {
        let ray = point.aim(&self.lighting.tree.placement, toward);
        let response = self.response(point, ray.as_ref());
        self.lights[n].rays += 1;
        if !self.casts_shadows() {
            return self.lights[n].add(response);
        }
        match self.ask(point, toward, ray.as_ref().filter(|ray| SurfacePoint::is_known(ray)), light) {
            (_, Some(question)) => self.unsure.push((PendingRay::Light(n, response), question)),
            (AnyHit::Blocked, None) => self.hide(n, response),
            _ => self.lights[n].add(response),
        }
    }

    /// Whether the light at the end of this ray, which is `None` if its direction is not known, is hidden; if that is unsure,
    /// the question for the judge.
    fn ask(
        &self,
        point: &SurfacePoint,
        toward: &Toward,
        ray: Option<&CertifiedRay>,
        light: Option<Ball>,
    ) -> (AnyHit, Option<LightQuestion>) {
        let question = |among| Some(LightQuestion::Hidden { toward: *toward, turned: false, among });
        let Some(ray) = ray else {
            // A ray of unknown direction may meet anything.
            let LightingContext { blockers, cuts, .. } = self.lighting;
            return (AnyHit::Unsure, question(all_but(light, blockers, cuts.as_ref())));
        };
        let ray = self.light_ray_of(point, ray, light);
        match if self.lighting.exact { AnyHit::Unsure } else { ray.answer() } {
            AnyHit::Unsure => (AnyHit::Unsure, question(ray.candidates())),
            answer => (answer, None),
        }
    }

    /// Counts a ray of the sky among all; its weight, and its direction on the side of the normal.
    #[inline(always)]
    fn weigh(&mut self, surface: &Surface, direction: [f64; 3]) -> (f64, [f64; 3]) {
        let cosine = surface.normal.dot(direction.into());
        let (weight, outward) = (cosine.abs(), if cosine < 0.0 { direction.map(|x| -x) } else { direction });
        self.sky.all += weight;
        self.sky.sums.add(outward.into(), self.lighting.colors.as_ref());
        (weight, outward)
    }

    /// Traces rays to the sky, if there is one.
    pub(super) fn trace_sky(&mut self, point: &SurfacePoint, surface: &Surface, at: PixelSample) {
        let Some(Sky { reach, .. }) = self.lighting.sky else { return };
        self.see_planes(point);
        self.sky = SkyShare::default();
        for direction in self.lighting.directions.of(at, 0) {
            let direction = direction.map(f64::from);
            let toward = |direction: [f64; 3]| match reach {
                f64::INFINITY => Toward::Direction(direction),
                reach => Toward::Within { direction, reach },
            };
            let Some(ray) = point.ray(&self.lighting.tree.placement, &toward(direction)) else { continue };
            let (weight, outward) = self.weigh(surface, direction);
            let pending = PendingRay::Sky(weight, outward);
            let side = if self.lighting.exact { AnyHit::Unsure } else { point.cosine(&ray).1 };
            let (toward, ray) = match side {
                AnyHit::Free => (toward(direction), ray),
                AnyHit::Blocked => (toward(direction.map(|x| -x)), ray.turned()),
                AnyHit::Unsure => {
                    let both = [ray, ray.turned()].map(|ray| self.light_ray_of(point, &ray, None).candidates());
                    let question =
                        LightQuestion::Hidden { toward: toward(direction), turned: true, among: both.concat() };
                    self.unsure.push((pending, question));
                    continue;
                }
            };
            let ray = self.light_ray_of(point, &ray, None);
            // From outside the sphere of the point does not hide what is on the side of its normal.
            let answer = if point.outside { ray.others() } else { ray.answer() };
            let among = if answer == AnyHit::Unsure { ray.candidates() } else { Vec::new() };
            match answer {
                AnyHit::Free => self.see_sky(weight, outward),
                AnyHit::Blocked => {}
                AnyHit::Unsure => {
                    self.unsure.push((pending, LightQuestion::Hidden { toward, turned: false, among }));
                }
            }
        }
    }

    /// Counts a ray to light `n` as hidden. Without shadows its light counts all the same.
    fn hide(&mut self, n: usize, response: [f64; 2]) {
        self.lights[n].hidden += 1;
        if !self.lighting.scene.lighting.shadows {
            self.lights[n].add(response);
        }
    }

    /// The highlight of a light at this cosine from the mirrored ray, by Phong's law.
    fn highlight(&self, cosine: f64) -> f64 {
        if self.shine > 0.0 && cosine > 0.0 { cosine.powf(f64::from(self.shine)) } else { 0.0 }
    }

    /// Lets the judge decide the unsure rays of the viewing ray at this row and column; whether there were any. Without a
    /// judge they are hidden.
    pub(super) fn settle(&mut self, point: &SurfacePoint, [i, j]: [u32; 2]) -> bool {
        if self.unsure.is_empty() {
            return false;
        }
        let (rays, questions): (Vec<PendingRay>, Vec<LightQuestion>) = self.unsure.drain(..).unzip();
        let solid = self.lighting.scene.spheres.solid(point.id);
        let answers = self.lighting.judge.and_then(|judge| judge.ask(i, j, solid, &questions));
        let answers = answers.unwrap_or_else(|| vec![true; questions.len()]);
        rays.into_iter().zip(answers).for_each(|(ray, hidden)| self.count(ray, hidden));
        true
    }

    /// Treats undecided rays as blocked; whether there were any.
    pub(super) fn assume_blocked(&mut self) -> bool {
        let unsure = std::mem::take(&mut self.unsure);
        unsure.iter().for_each(|(ray, _)| self.count(*ray, true));
        !unsure.is_empty()
    }

    fn count(&mut self, ray: PendingRay, hidden: bool) {
        match (ray, hidden) {
            (PendingRay::Light(n, response), true) => self.hide(n, response),
            (PendingRay::Light(n, response), false) => self.lights[n].add(response),
            (PendingRay::Far(n), true) => self.hide_far(n),
            (PendingRay::Far(_), false) => {}
            (PendingRay::Rim(n), hidden) => self.lights[n].rim[usize::from(!hidden)] = true,
            (PendingRay::Inside(n), outside) => self.lights[n].inside = !outside,
            (PendingRay::Sky(..), true) => {}
            (PendingRay::Sky(weight, outward), false) => self.see_sky(weight, outward),
        }
    }

    /// The colour of the surface for a ray in the unit direction `along`: the light of lights and sky that it reflects
    /// back along the ray, and the light that it shines with.
    pub(super) fn color(&self, surface: &Surface, along: DVec3) -> DVec3 {
        let scene = self.lighting.scene;
        // Light passes through the far side of a clear sphere.
        if !surface.outside && self.lighting.bounces > 0 && self.lighting.material(surface.id).is_clear() {
            return DVec3::ZERO;
        }
        let own = self.lighting.own_color(surface.id, surface.is_face).as_dvec3();
        let lights = &scene.lighting.lights;
        let (diffuse, specular) = match self.lighting.material(surface.id) {
            Material::Phong { diffuse, specular, .. } => (diffuse, specular),
            Material::Plastic { gloss, .. } => (1.0, gloss),
            Material::Ink => return own,
            // Without bounces mirrors and glass are like any other sphere.
            Material::Metal { .. } | Material::Glass { .. } if self.lighting.bounces == 0 => (1.0, 0.0),
            Material::Metal { .. } | Material::Glass { .. } => (0.0, 0.0),
        };
        let mut white = match scene.lighting.sky {
            Some(sky) => self.sky.sums.light(surface.normal, self.lighting.colors.as_ref()) * f64::from(sky.share),
            None if lights.is_empty() => DVec3::splat((-along.dot(surface.normal)).max(0.0)),
            None => DVec3::ZERO,
        };
        let (mut gloss, mut shine) = (DVec3::ZERO, DVec3::ZERO);
        for (light, share) in lights.iter().zip(&self.lights) {
            let color = Vec3::from_array(light.color).as_dvec3() * f64::from(light.intensity);
            let [reflected, highlight] = share.response();
            white += color * reflected;
            gloss += color * highlight;
            if share.shines {
                shine += color;
            }
        }
        own * white * f64::from(diffuse) + gloss * f64::from(specular) + shine
    }
}
