//! Clip planes for a frame that was read before.

use super::sequence::{SceneFrame, all_clipped};
use super::sphere_lights::SphereLights;
use halfline::error::Result;
use halfline::progress::Watch;
use halfline::scene::arrange::Arrangement;

impl SceneFrame {
    /// Leaves out the spheres that these planes cut off, as [`Arrangement::clip`] has them, with their columns. Beads of a cell stay. Says
    /// so where no sphere is left.
    ///
    /// # Errors
    /// As [`Arrangement::apply`].
    pub fn clip(&mut self, planes: Vec<[f64; 4]>, watch: &Watch) -> Result<()> {
        if planes.is_empty() {
            return Ok(());
        }
        let lights = SphereLights::of(&self.scene);
        let spheres = &mut self.scene.spheres;
        let clip = Arrangement { clip: planes, ..Arrangement::default() };
        let count = spheres.len() - self.beads;
        let mut rows = clip.rows(spheres, None, watch)?;
        rows.retain(|row| (*row as usize) < count);
        if rows.is_empty() && count > 0 {
            self.skipped.assumed.push(all_clipped(count as u64));
        }
        let mut kept = vec![false; count];
        rows.iter().for_each(|row| kept[*row as usize] = true);
        kept.resize(spheres.len(), true);
        spheres.keep(&kept);
        lights.follow(&mut self.scene);
        if !self.columns.is_empty() {
            self.columns = self.columns.rearranged(&rows, self.beads)?.into();
        }
        self.marks.iter_mut().try_for_each(|mark| clip.apply(&mut mark.spheres, None, watch))
    }
}
