//! The style of particles whose copies are operators: radii and colours per particle, and colours by copy per operator.

use super::{Coloring, Style};
use halfline::error::{Error, Place, Result};
use halfline::frame::legend::Legend;
use halfline::quote::setting::{MATERIAL, MOVE, OPACITY, RADIUS, STREAM};
use halfline::scene::Spheres;
use halfline::scene::instances::Instances;
use halfline_particles::Skipped;
use halfline_particles::particles::frame::{Column, Particles};
use std::ops::Range;

impl Style {
    /// Turns particles with copies into spheres with copies, as [`Style::to_spheres`] does with all copies.
    ///
    /// # Errors
    /// As [`Style::to_spheres`]; [`Error::Settings`] where radii or colours depend on the places of copies.
    pub(in crate::read) fn to_instances(
        &self,
        mut particles: Particles,
        spaced: Option<f64>,
        file: &Place,
    ) -> Result<(Instances, Skipped, Option<Legend>)> {
        let placed = std::mem::take(&mut particles.placed);
        self.check_placed(&particles, spaced)?;
        let by_copy = self.columns().iter().any(|name| name.eq_ignore_ascii_case("copy"));
        let (mut tints, mut legend) = (None, None);
        let style = match &self.coloring {
            Coloring::Column(scale) if by_copy => {
                // One particle for every copy has the colours, and the legend, of all.
                let values: Vec<f64> = placed.iter().flat_map(|part| part.copies.iter().copied()).collect();
                let columns = vec![Column { name: "copy".into(), values }];
                let positions = vec![[0.0; 3]; columns[0].values.len()];
                let one = Particles { positions, columns, has: particles.has.clone(), ..Particles::default() };
                let (colors, found) = scale.apply(&one, &mut particles.skipped)?;
                (tints, legend) = (Some(colors), found);
                Self { coloring: Coloring::One([0.0; 3]), ..self.clone() }
            }
            _ => self.clone(),
        };
        let (spheres, skipped, other) = style.to_spheres(particles, spaced, file)?;
        let (mut sets, mut first, mut copy) = (Vec::new(), 0, 0);
        for part in placed {
            let (range, copies) = (first..first + part.count, copy..copy + part.operators.len());
            (first, copy) = (range.end, copies.end);
            let tints = tints.as_ref().map(|tints| tints[copies].to_vec());
            sets.push((part_of(&spheres, range, tints.is_none()), part.operators, tints));
        }
        Ok((Instances::by_operators(sets)?, skipped, legend.or(other)))
    }

    /// Refuses what depends on the places of copies.
    fn check_placed(&self, particles: &Particles, spaced: Option<f64>) -> Result<()> {
        let is = |names: &[&str]| {
            self.columns().iter().any(|column| names.iter().any(|name| column.eq_ignore_ascii_case(name)))
        };
        let has = |name: &str| particles.has.iter().any(|known| known.eq_ignore_ascii_case(name));
        let (problem, mend) = if self.default_radius.is_none() && spaced.is_some() {
            (
                "the file has no radii, and half the mean spacing needs all copies",
                format!("add {RADIUS}, or remove {STREAM}"),
            )
        } else if ["x", "y", "z"].iter().any(|axis| is(&[axis]) && !has(axis)) {
            (
                "colours by coordinates need all copies in memory",
                format!("colour by another column, or remove {STREAM}"),
            )
        } else if is(&["copy"]) && self.columns().len() > 1 {
            (
                "colours by the copy and other columns need all copies in memory",
                format!("use one column, or remove {STREAM}"),
            )
        } else if self.has_materials() {
            ("materials need all copies in memory", format!("remove {MATERIAL}, or {STREAM}"))
        } else if self.opacity.is_some() || !self.fades.is_empty() {
            ("opacities need all copies in memory", format!("remove {OPACITY}, or {STREAM}"))
        } else if !self.moves.is_empty() {
            ("moved particles need all copies in memory", format!("remove {MOVE}, or {STREAM}"))
        } else {
            return Ok(());
        };
        Err(Error::settings(format!("{STREAM}: {problem}"), mend))
    }
}

/// Some of the spheres, with their colours or without, and with their opacities.
fn part_of(spheres: &Spheres, range: Range<usize>, colored: bool) -> Spheres {
    let colors = spheres.colors.as_ref().filter(|_| colored).map(|colors| colors[range.clone()].to_vec().into());
    let opacities = spheres.opacities.as_ref().map(|opacities| opacities[range.clone()].to_vec().into());
    Spheres {
        centers: spheres.centers[range.clone()].to_vec().into(),
        radii: spheres.radii[range].to_vec().into(),
        colors,
        materials: None,
        opacities,
        cuts: None,
    }
}
