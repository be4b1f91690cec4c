//! A scene set up for its lights.

use super::super::hidden::HitCuts;
use super::surface::Surface;
use crate::answers::light::Traced;
use crate::answers::open_sky::OpenSky;
use crate::certify::cut::CutRay;
use crate::certify::surface::SurfacePoint;
use crate::exact::Judge;
use crate::scene::{Lighting, Material, NumberedBall, Scene, Sky, SkyLight};
use crate::search::tree::Tree;
use crate::view::View;
use crate::view::backdrop::Backdrop;
use crate::view::directions::{DiscPoints, SkyDirections};
use crate::view::picture_rays::PictureRays;
use glam::{DVec3, Vec3};

/// The outputs of lights and sky that are requested.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct LightOutputs {
    /// The colour of the picture.
    pub(crate) color: bool,
    /// The share of each light that is hidden.
    pub(crate) shadow: bool,
    /// The share of the sky that is open.
    pub(crate) occlusion: bool,
    /// The rays toward the sky.
    pub(crate) sky: bool,
    /// The depths of the hits, for what is drawn over the colours.
    pub(crate) depth: bool,
}

/// A scene set up for its lights.
pub(crate) struct LightingContext<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) view: &'a View,
    pub(crate) tree: &'a Tree,
    /// The spheres that block rays to lights and sky, in the placement of `tree`; in a scene with cuts without those that planes spare.
    pub(crate) blockers: &'a Tree,
    pub(crate) cuts: Option<HitCuts<'a>>,
    pub(crate) outputs: LightOutputs,
    /// Decides the answers that f64 leaves unsure; `None` for answers that are not certified.
    pub(crate) judge: Option<&'a Judge>,
    /// The judge decides every ray.
    pub(crate) exact: bool,
    pub(crate) sky: Option<Sky>,
    /// The light of the sky's colours; `None` for a white sky.
    pub(crate) colors: Option<SkyLight>,
    /// The background, for rays that hit nothing.
    pub(crate) backdrop: Backdrop<'a>,
    pub(crate) directions: &'a SkyDirections,
    /// Directions in which rough metal scatters rays.
    pub(crate) scattered: &'a SkyDirections,
    pub(crate) disc: &'a DiscPoints,
    pub(crate) seed: u32,
    /// The rays toward the sky from the hits of viewing rays, if they were traced before.
    pub(crate) open: Option<&'a OpenSky>,
    /// The hits are the first among the spheres that block rays, up to translucent ones that do not.
    pub(crate) from_first: bool,
    /// A device's answers to the rays from the hits of viewing rays; `None` if it traced none.
    pub(crate) traced: Option<Traced<'a>>,
    /// Most rays that follow each other from mirrors and through glass; 0 if no material asks for any.
    pub(crate) bounces: u32,
}

impl LightOutputs {
    /// Whether there is anything to compute.
    pub(crate) fn is_any(self) -> bool {
        self.color || self.shadow || self.occlusion || self.sky
    }

    /// Whether lights are traced for the shadows that they cast.
    pub(crate) fn casts_shadows(self, lighting: &Lighting) -> bool {
        self.shadow || self.color && lighting.shadows
    }

    /// Whether only rays toward the sky are requested.
    pub(crate) fn is_sky_alone(self) -> bool {
        self.sky && !self.color && !self.shadow && !self.occlusion && !self.depth
    }
}

impl LightingContext<'_> {
    /// The viewing rays, among the planes that cut spheres.
    pub(super) fn picture_rays(&self) -> PictureRays<'_> {
        PictureRays::among(self.view, self.cuts.as_ref().map(|cuts| cuts.planes.clone()))
    }

    /// The hit point of the viewing ray of row `i` and column `j`, in the finer frame of its samples.
    pub(super) fn point(&self, [i, j]: [u32; 2], id: u32) -> SurfacePoint {
        let sphere = NumberedBall { id, ball: self.scene.spheres.ball(id) };
        let placement = &self.tree.placement;
        let whole = || SurfacePoint::of_pixel(self.view, placement, [i, j], sphere);
        let cuts = self.cuts.as_ref().filter(|cuts| cuts.cuts.is_cut(id));
        let of_cut = |cuts: &HitCuts<'_>| {
            let is_along = |plane| self.judge.is_some_and(|judge| judge.is_along([i, j], plane));
            let ray = CutRay::of_pixel(&cuts.planes, self.view, placement, ([i, j], &is_along))?;
            Some(ray.point(&cuts.planes, sphere, ray.hit(sphere, true)?))
        };
        let point = cuts.map_or_else(|| Some(whole()), of_cut);
        match (self.judge, point) {
            (None, point) => point.unwrap_or_else(whole).trusted(placement),
            (Some(_), Some(point)) if point.is_sharp(placement) => point,
            (Some(judge), point) => match judge.hit_of(i, j, self.scene.spheres.solid(id)) {
                Some(truth) => SurfacePoint::judged(placement, &truth, sphere),
                None => point.unwrap_or_else(whole),
            },
        }
    }

    /// Whether colours need no rays: there are only lights infinitely far that cast no shadows, the sky is known, and
    /// nothing is mirrored.
    pub(super) fn is_rayless(&self) -> bool {
        let Scene { lighting, .. } = self.scene;
        let far = lighting.lights.iter().all(|light| light.source.far().is_some());
        far && !lighting.shadows && (lighting.sky.is_none() || self.open.is_some()) && self.bounces == 0
    }

    /// The surface at the hit of the viewing ray of a pixel on a sphere, the direction of the ray, of length 1, and whether the normal is known
    /// to 2^-29. `point` gives the hit where f64 alone does not know its normal.
    pub(super) fn surface<'p>(
        &self,
        rays: &PictureRays<'_>,
        pixel: u32,
        id: u32,
        point: impl FnOnce() -> &'p SurfacePoint,
    ) -> (Surface, DVec3, bool) {
        let spheres = &self.scene.spheres;
        let hit = rays.hit(pixel, spheres.ball(id), spheres.is_cut(id));
        if hit.near {
            return (Surface { id, outside: hit.outside, is_face: hit.face, normal: hit.normal }, hit.along, hit.sharp);
        }
        (Surface::from(point()), hit.along, true)
    }

    pub(super) fn material(&self, id: u32) -> Material {
        self.scene.spheres.materials.as_ref().map_or(Material::default(), |materials| materials.of(id))
    }

    #[inline(always)]
    pub(super) fn own_color(&self, id: u32, is_face: bool) -> Vec3 {
        Vec3::from_array(self.scene.spheres.color(id, is_face))
    }

    /// The unit direction of a viewing ray.
    pub(super) fn direction(&self, [i, j]: [u32; 2]) -> DVec3 {
        self.view.to_world(self.view.direction(i, j)).normalize()
    }

    /// Whether rays to lights are needed: for shadows, and for lights that are not infinitely far.
    pub(super) fn asks_lights(&self) -> bool {
        let (Scene { lighting, .. }, LightOutputs { color, .. }) = (self.scene, self.outputs);
        let shadows = self.outputs.casts_shadows(lighting);
        lighting.lights.iter().any(|light| shadows || color && light.source.far().is_none())
    }
}
