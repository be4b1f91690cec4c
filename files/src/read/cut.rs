//! Planes that cut the spheres of a frame: given, or through what a selection selects.

use super::sequence::SceneFrame;
use halfline::error::{Error, Place, Result};
use halfline::quote::setting::{CUT, CUT_AT, CUT_COLOR, CUT_ONLY, CUT_SLAB};
use halfline::quote::{count, quote};
use halfline::scene::{CutPlane, Cuts, DEFAULT_COLOR};
use halfline_particles::Selection;

/// The planes that cut spheres, and the spheres that they may cut.
#[derive(Debug, Clone, Default)]
pub struct CutRules {
    /// Planes that are given.
    pub planes: Vec<CutPlane>,
    /// Planes through what is selected.
    pub at: Vec<CutAt>,
    /// The spheres that planes may cut; `None` for all.
    pub only: Option<Selection>,
    /// Linear RGB of all faces; `None` for the colours of their spheres.
    pub color: Option<[f32; 3]>,
    /// Linear RGB of the faces of selected spheres; later entries win.
    pub colors: Vec<(Selection, [f32; 3])>,
}

/// A plane through the mean of the centres of what is selected.
#[derive(Debug, Clone)]
pub struct CutAt {
    /// The spheres.
    pub selection: Selection,
    /// Toward what is removed, of any length but zero; `None` for the way back along the view axis of the camera.
    pub direction: Option<[f64; 3]>,
}

impl SceneFrame {
    /// Cuts the spheres by the planes of its file and by these planes; the camera, the places and the radii are final. Beads of a cell stay whole.
    ///
    /// # Errors
    /// [`Error::Settings`] for columns that the file does not have, and for spheres that may be cut without a plane; [`Error::Scene`] where
    /// nothing is selected for a plane to go through.
    pub fn cut(&mut self, rules: &CutRules) -> Result<()> {
        self.cut_by_planes(rules)?;
        let CutRules { color, colors, .. } = rules;
        if self.scene.spheres.cuts.is_none() || color.is_none() && colors.is_empty() {
            return Ok(());
        }
        let count = self.scene.spheres.len();
        let mut of_faces: Vec<[f32; 3]> = match (color, &self.scene.spheres.colors) {
            (Some(color), _) => vec![*color; count],
            (None, Some(own)) => own.to_vec(),
            (None, None) => vec![DEFAULT_COLOR; count],
        };
        for (selection, color) in colors {
            let (flags, notes) = self.selected(selection)?;
            self.skipped.assumed.extend(notes);
            of_faces.iter_mut().zip(flags).filter(|(_, flag)| *flag).for_each(|(face, _)| *face = *color);
        }
        self.scene.spheres.cuts.iter_mut().for_each(|cuts| cuts.colors = Some(of_faces.clone().into()));
        Ok(())
    }

    /// The same for given rays, which have no view: a plane through what is selected says where its removed side is.
    ///
    /// # Errors
    /// As [`Self::cut`], and [`Error::Settings`] for a plane without a side.
    pub fn cut_for_rays(&mut self, rules: &CutRules) -> Result<()> {
        if let Some(at) = rules.at.iter().find(|at| at.direction.is_none()) {
            let problem = format!("{CUT_AT} {}: given rays have no view", quote(&at.selection.to_string()));
            return Err(Error::settings(problem, format!("give the side to remove: {CUT_AT} EXPR:X,Y,Z")));
        }
        self.cut(rules)
    }

    /// Gives the planes of the file and these to spheres that are still to come.
    ///
    /// # Errors
    /// As [`CutPlane::check`].
    pub fn cut_later(&mut self, rules: &CutRules) -> Result<()> {
        let planes: Vec<CutPlane> = self.cuts.iter().chain(&rules.planes).copied().collect();
        self.scene.spheres.cuts = Cuts::later(planes)?;
        Ok(())
    }

    fn cut_by_planes(&mut self, rules: &CutRules) -> Result<()> {
        let mut planes = self.cuts.clone();
        planes.extend(&rules.planes);
        for at in &rules.at {
            planes.push(self.plane_at(at)?);
        }
        if planes.is_empty() {
            let is_colored = rules.color.is_some() || !rules.colors.is_empty();
            let idle = if rules.only.is_some() { Some(CUT_ONLY) } else { is_colored.then_some(CUT_COLOR) };
            let words = |idle| {
                let problem = format!("{idle} is for planes, and none cuts the spheres");
                Error::settings(problem, format!("give a plane by {CUT}, {CUT_SLAB} or {CUT_AT}, or remove {idle}"))
            };
            return idle.map_or(Ok(()), |idle| Err(words(idle)));
        }
        let Some(only) = &rules.only else {
            let may = self.sphere_flags(vec![true; self.scene.spheres.len()]);
            return self.scene.spheres.cut(&planes, (self.beads > 0).then_some(&may[..]));
        };
        let (may, notes) = self.selected(only)?;
        self.skipped.assumed.extend(notes);
        let may = self.sphere_flags(may);
        self.scene.spheres.cut(&planes, Some(&may))
    }

    /// Flags of all spheres, unset for beads of a cell.
    fn sphere_flags(&self, mut flags: Vec<bool>) -> Vec<bool> {
        let count = self.scene.spheres.len();
        flags.resize(count, false);
        flags[count - self.beads.min(count)..].fill(false);
        flags
    }

    fn plane_at(&mut self, CutAt { selection, direction }: &CutAt) -> Result<CutPlane> {
        let (flags, notes) = self.selected(selection)?;
        let flags = self.sphere_flags(flags);
        let spheres = &self.scene.spheres;
        let (mut sum, mut chosen) = ([0.0; 3], 0_u64);
        for (center, _) in spheres.centers.iter().zip(&flags).filter(|(_, flag)| **flag) {
            (0..3).for_each(|k| sum[k] += center[k]);
            chosen += 1;
        }
        if chosen == 0 {
            let all = count(spheres.len() as u64, "sphere");
            let problem = format!("{CUT_AT} {}: the expression selects none of {all}", quote(&selection.to_string()));
            let mend = match &notes[..] {
                [] => "use another expression; halfline info lists the columns of the file".to_owned(),
                notes => notes.join("; "),
            };
            return Err(Error::scene(Place::field(format!("frame {}", self.number)), problem, mend));
        }
        self.skipped.assumed.extend(notes);
        let normal = match direction {
            Some(direction) => *direction,
            None => self.scene.camera.basis()?.w.to_array(),
        };
        let distance = (0..3).map(|k| normal[k] * (sum[k] / chosen as f64)).sum();
        Ok(CutPlane { normal, distance })
    }
}
