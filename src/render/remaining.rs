//! The spheres of a scene that its planes leave, kept from frame to frame: a frame is made of them alone, and has the ids of all.

use crate::frame::{Aov, Data, Frame};
use crate::scene::{CUT, Cuts, Light, LightSource, Lighting, REMOVED, Scene, Spheres};
use halfline_ground::Shared;
use halfline_ground::error::Result;
use halfline_ground::memory::check;
use halfline_ground::parallel::{self, CHEAP};
use std::sync::Arc;

/// The spheres that planes leave.
pub(super) struct Remaining {
    /// The spheres that they were chosen from.
    all: Spheres,
    spheres: Spheres,
    /// Their ids in the scene.
    ids: Vec<u32>,
}

impl Remaining {
    fn of(all: &Spheres, cuts: &Cuts) -> Result<Self> {
        let count = all.len() as u64;
        check(96 * count, || format!("the ones of {count} spheres that planes leave"))?;
        let ids: Vec<u32> = parallel::collect(all.len(), CHEAP, &|range, ids| {
            ids.extend(range.map(|n| n as u32).filter(|id| !cuts.is_removed(*id)));
        });
        let mut spheres = all.clone();
        spheres.choose(&ids);
        spheres.cuts = spheres.cuts.filter(|cuts| cuts.count(CUT) > 0);
        spheres.share();
        Ok(Self { all: all.clone(), spheres, ids })
    }

    /// A light that is a sphere shines as a whole, also where planes remove it.
    fn light(&self, light: Light) -> Light {
        let source = match light.source {
            LightSource::Sphere(id) => match self.ids.binary_search(&id) {
                Ok(id) => LightSource::Sphere(id as u32),
                Err(_) => {
                    let ball = self.all.ball(id);
                    LightSource::Ball { center: ball.center.into(), radius: ball.radius }
                }
            },
            source => source,
        };
        Light { source, ..light }
    }

    /// The scene of these spheres alone.
    pub(super) fn scene(&self, of: &Scene) -> Scene {
        let lights = of.lighting.lights.iter().map(|light| self.light(*light)).collect();
        let lighting = Lighting { lights, ..of.lighting.clone() };
        Scene { camera: of.camera, image: of.image, spheres: self.spheres.clone(), lighting }
    }

    /// Gives the spheres of a frame the ids that they have in the whole scene.
    pub(super) fn rename(&self, frame: &mut Frame) {
        for buffer in frame.buffers.iter_mut().filter(|buffer| buffer.aov == Aov::Id) {
            if let Data::I32(ids) = &mut buffer.data {
                parallel::each(ids, |_, id| *id = usize::try_from(*id).map_or(*id, |n| self.ids[n] as i32));
            }
        }
        let covers = frame.coverage.iter_mut().flat_map(|coverage| coverage.rows.iter_mut().flatten());
        covers.for_each(|cover| cover.id = self.ids[cover.id as usize]);
    }
}

/// The spheres that the planes of the scene of the last frame left.
#[derive(Default)]
pub(super) struct LastRemaining(Option<Arc<Remaining>>, Shared<Remaining>);

impl LastRemaining {
    /// The spheres that planes leave; `None` where they remove none.
    ///
    /// # Errors
    /// [`crate::Error::Limits`] where memory is short.
    pub(super) fn of(&mut self, spheres: &Spheres) -> Result<Option<Arc<Remaining>>> {
        let Some(cuts) = spheres.cuts.as_ref().filter(|cuts| cuts.count(REMOVED) > 0) else { return Ok(None) };
        let serves = |known: &Remaining| known.all.is_same(spheres) && known.all.cuts == spheres.cuts;
        let known = self.0.take().filter(|known| serves(known));
        let remaining = known.map_or_else(|| self.1.or_make(serves, || Remaining::of(spheres, cuts)), Ok)?;
        Ok(Some(Arc::clone(self.0.insert(remaining))))
    }

    /// The same for another renderer.
    pub(super) fn another(&self) -> Self {
        Self(None, self.1.clone())
    }
}
