//! The style of particles: how their radii and colours are chosen when they become spheres.

mod categories;
mod coloring;
mod confidence;
mod map_file;
mod numbers;
pub(super) mod paint;
mod placed;
mod scale;

pub use coloring::Coloring;
pub use halfline_particles::color::color;
pub use map_file::color_map;
pub use paint::Paint;
pub use scale::{GatheredValues, RangeEnd, Scale};

pub(super) use categories::joined_categories;
use halfline::error::{Error, Place, Result, named};
use halfline::frame::legend::Legend;
use halfline::memory::check_spheres;
use halfline::parallel::{self, CHEAP};
use halfline::quote::setting::{COLOR_BY, RADIUS};
use halfline::quote::{number, quote};
use halfline::scene::{DEFAULT_COLOR, Material, Materials, Spheres, check_sphere, is_center, is_radius};
use halfline_particles::particles::frame::{Particles, RuleTarget};
use halfline_particles::{Selection, Skipped};

use halfline_particles::color::of_hex;
use halfline_particles::elements::{Element, element};

/// The style of particles.
#[derive(Debug, Clone, PartialEq)]
pub struct Style {
    /// The kind of element radius, where the file has no radii.
    pub radii: Radii,
    /// One radius for all, overriding the file.
    pub radius: Option<f64>,
    /// Multiplies every radius.
    pub radius_scale: f64,
    /// The source of the colours.
    pub coloring: Coloring,
    /// Colours of selected particles; later ones win.
    pub paints: Vec<(Selection, Paint)>,
    /// The radius of particles without radii and elements, before it is scaled; `None` takes half their mean spacing.
    pub default_radius: Option<f64>,
    /// Radii of selected particles, before they are scaled; later ones win.
    pub sizes: Vec<(Selection, f64)>,
    /// One opacity for all, overriding the file.
    pub opacity: Option<f32>,
    /// Opacities of selected particles; later ones win.
    pub fades: Vec<(Selection, f32)>,
    /// One material for all, overriding the file.
    pub material: Option<Material>,
    /// Materials of selected particles; later ones win.
    pub matters: Vec<(Selection, Material)>,
    /// Distances that selected particles are moved by, after their colours are chosen; later ones win.
    pub moves: Vec<(Selection, [f64; 3])>,
    /// The title of the legend in place of the name of what is coloured.
    pub legend_title: Option<String>,
}

impl Default for Style {
    /// The file's own radii and colours, or the elements' radii and colours.
    fn default() -> Self {
        Self {
            radii: Radii::Vdw,
            radius: None,
            radius_scale: 1.0,
            coloring: Coloring::File,
            default_radius: None,
            paints: Vec::new(),
            sizes: Vec::new(),
            opacity: None,
            fades: Vec::new(),
            material: None,
            matters: Vec::new(),
            moves: Vec::new(),
            legend_title: None,
        }
    }
}

/// Radii of elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Radii {
    /// Van der Waals: space-filling.
    #[default]
    Vdw,
    /// Covalent: bound atoms touch.
    Covalent,
}

named! { Radii, "kind of radii", Vdw "vdw" Covalent "covalent" }

impl Radii {
    /// The radius of an element by its atomic number, ångström; the radius of unknown elements where there is none.
    #[must_use]
    pub fn radius(self, number: u8) -> f64 {
        element(number).and_then(|element| self.of(element)).unwrap_or(UNKNOWN_RADIUS)
    }

    fn of(self, element: &Element) -> Option<f64> {
        match self {
            Self::Vdw => element.vdw,
            Self::Covalent => element.covalent,
        }
    }
}

/// Linear RGB of each particle.
type Colors = Vec<[f32; 3]>;

/// Linear light of the grey by which legends show an opacity.
const VEILED_GREY: f32 = 0.2;

/// Radius of an atom of an unknown element, ångström: between the radii of carbon and nitrogen.
const UNKNOWN_RADIUS: f64 = 1.6;

/// Linear RGB of an element by its atomic number; deep pink if it is unknown.
#[must_use]
pub fn color_of_element(number: u8) -> [f32; 3] {
    of_hex(categories::of_element(number))
}

impl Style {
    /// The columns that the reader must keep.
    #[must_use]
    pub fn columns(&self) -> &[String] {
        match &self.coloring {
            Coloring::Column(scale) => &scale.columns,
            _ => &[],
        }
    }

    /// The selections of its rules, by [`RuleTarget`].
    pub(super) fn rules(&self) -> [Vec<&Selection>; RuleTarget::COUNT] {
        fn of<T>(rules: &[(Selection, T)]) -> Vec<&Selection> {
            rules.iter().map(|(selection, _)| selection).collect()
        }
        [of(&self.paints), of(&self.sizes), of(&self.fades), of(&self.matters), of(&self.moves)]
    }

    /// The selections of all its rules.
    pub(super) fn selections(&self) -> impl Iterator<Item = &Selection> {
        self.rules().into_iter().flatten()
    }

    /// Applies the style to spheres that already have radii.
    ///
    /// # Errors
    /// [`Error::Settings`] where a column gives the colours or selections do: such scenes have no columns.
    pub(super) fn restyle(&self, spheres: &mut Spheres) -> Result<()> {
        if self.selections().next().is_some() {
            return Err(no_selections());
        }
        if let Some(opacity) = self.opacity {
            spheres.opacities = Some(vec![opacity; spheres.len()].into());
        }
        if let Some(material) = self.material {
            spheres.materials = Some(Materials { kinds: vec![material], of: vec![0; spheres.len()].into() });
        }
        let scale = self.radius_scale;
        parallel::each(spheres.radii.to_mut(), |_, radius| *radius = self.radius.unwrap_or(*radius) * scale);
        match &self.coloring {
            Coloring::File => Ok(()),
            Coloring::One(color) => {
                spheres.colors = Some(vec![*color; spheres.len()].into());
                Ok(())
            }
            Coloring::Element => Err(Error::settings("this scene has no elements", format!("remove {COLOR_BY}"))),
            Coloring::Column(_) => {
                Err(Error::settings("this scene has no columns to colour by", "use a particle file"))
            }
        }
    }

    /// Makes the colours of the file linear light, where the style takes them; before any selection.
    pub(super) fn settle(&self, particles: &mut Particles) {
        if self.coloring == Coloring::File {
            particles.lighten();
        }
    }

    /// Turns particles into spheres. Assumptions are added to what was skipped. `spaced` is [`Self::spaced`] of all
    /// particles of the frame.
    ///
    /// # Errors
    /// [`Error::Scene`] for an invalid sphere, [`Error::Settings`] for a missing column, [`Error::Limits`].
    pub(super) fn to_spheres(
        &self,
        particles: Particles,
        spaced: Option<f64>,
        file: &Place,
    ) -> Result<(Spheres, Skipped, Option<Legend>)> {
        let painted = self.painted(&particles);
        let (spheres, skipped, legend) = self.part_to_spheres(particles, spaced, file)?;
        Ok((spheres, skipped, self.with_overrides(legend, &painted)))
    }

    /// The same for a part of the particles: the legend has no rows for rules; see [`Self::with_overrides`].
    ///
    /// # Errors
    /// As [`Self::to_spheres`].
    pub(super) fn part_to_spheres(
        &self,
        mut particles: Particles,
        spaced: Option<f64>,
        file: &Place,
    ) -> Result<(Spheres, Skipped, Option<Legend>)> {
        check_spheres(particles.positions.len() as u64, true)?;
        let mut skipped = std::mem::take(&mut particles.skipped);
        let (mut colors, legend) = self.colors(&mut particles, &mut skipped)?;
        let mut radii = self.radii_of(&particles, spaced, &mut skipped);
        self.apply_rules(&particles, &mut colors, &mut radii)?;
        self.shift(&mut particles);
        let opacities = self.opacities(&particles).map(Into::into);
        let materials = self.materials(&particles);
        let are_checked = particles.checked && self.keeps_radii(&particles);
        let (centers, colors) = (std::mem::take(&mut particles.positions).into(), colors.map(Into::into));
        let spheres = Spheres { centers, radii: radii.into(), colors, materials, opacities, cuts: None };
        let is_invalid = |n: &usize| !(is_center(&spheres.centers[*n]) & is_radius(&spheres.radii[*n]));
        let count = if are_checked { 0 } else { spheres.len() };
        let invalid = parallel::blocks(0..count, CHEAP, &|_, mut spheres| spheres.find(is_invalid));
        if let Some(n) = invalid.into_iter().flatten().next() {
            let place = || particles.place(n, file);
            check_sphere(spheres.centers[n], spheres.radii[n], place)?;
        }
        Ok((spheres, skipped, legend))
    }

    /// Whether the radii of the spheres are the file's.
    fn keeps_radii(&self, particles: &Particles) -> bool {
        self.radius.is_none()
            && self.radius_scale == 1.0
            && !particles.radii.is_empty()
            && !particles.has_rules(RuleTarget::Radius)
    }

    /// The radius before it is scaled, where the file has neither radii nor elements. It is of all particles of a frame, before some are
    /// selected, so that the spheres that are drawn do not depend on which others are.
    pub(super) fn spaced(&self, particles: &Particles) -> Option<f64> {
        let has_elements = particles.elements.iter().any(|number| *number != 0);
        let is_spaced = self.radius.is_none() && particles.radii.is_empty() && !has_elements;
        is_spaced.then(|| self.default_radius.unwrap_or_else(|| spacing(&particles.positions) / 2.0))
    }

    /// Takes the names and, if `ranges`, the range of colours of this frame for the following ones.
    pub(super) fn hold(&mut self, legend: Option<&Legend>, ranges: bool) {
        let (Coloring::Column(scale), Some(legend)) = (&mut self.coloring, legend) else { return };
        if scale.names.is_empty() {
            scale.names.clone_from(&legend.names);
        }
        if ranges && legend.is_scale() {
            scale.range = Some(legend.range.map(RangeEnd::Value));
        }
    }

    /// Applies the colours and radii of selected particles.
    ///
    /// # Errors
    /// [`Error::Settings`] for the colours of elements where the file has none.
    fn apply_rules(&self, particles: &Particles, colors: &mut Option<Colors>, radii: &mut [f64]) -> Result<()> {
        if particles.has_rules(RuleTarget::Color) {
            paint::check(&self.paints, &particles.elements)?;
            let element = |n: usize| particles.elements.get(n).copied().unwrap_or(0);
            let colors = colors.get_or_insert_with(|| vec![DEFAULT_COLOR; radii.len()]);
            parallel::each(colors, |n, color| {
                let paint = particles.rule(RuleTarget::Color, n).map(|rule| self.paints[rule].1);
                *color = paint.map_or(*color, |paint| paint.color(element(n)));
            });
        }
        if particles.has_rules(RuleTarget::Radius) {
            parallel::each(radii, |n, radius| {
                let own = |rule: usize| self.sizes[rule].1 * self.radius_scale;
                *radius = particles.rule(RuleTarget::Radius, n).map_or(*radius, own);
            });
        }
        Ok(())
    }

    /// Moves the particles that a rule moves.
    fn shift(&self, particles: &mut Particles) {
        if !particles.has_rules(RuleTarget::Place) {
            return;
        }
        let mut positions = std::mem::take(&mut particles.positions);
        parallel::each(&mut positions, |n, position| {
            if let Some(rule) = particles.rule(RuleTarget::Place, n) {
                position.iter_mut().zip(self.moves[rule].1).for_each(|(x, by)| *x += by);
            }
        });
        particles.positions = positions;
        particles.checked = false;
    }

    /// The opacities, where the style has any, so that all parts of a file have them or none.
    fn opacities(&self, particles: &Particles) -> Option<Vec<f32>> {
        if self.opacity.is_none() && self.fades.is_empty() {
            return None;
        }
        let of_all = self.opacity.unwrap_or(1.0);
        let of = |n: usize| particles.rule(RuleTarget::Opacity, n).map_or(of_all, |rule| self.fades[rule].1);
        Some(parallel::from_fn(particles.positions.len(), of))
    }

    /// Whether it gives spheres materials.
    pub(super) fn has_materials(&self) -> bool {
        self.material.is_some() || !self.matters.is_empty()
    }

    /// The materials, where the style has any.
    fn materials(&self, particles: &Particles) -> Option<Materials> {
        if !self.has_materials() {
            return None;
        }
        let of_all = self.material.unwrap_or_default();
        let kinds = [of_all].into_iter().chain(self.matters.iter().map(|(_, material)| *material)).collect();
        let of = |n: usize| particles.rule(RuleTarget::Material, n).map_or(0, |rule| rule as u32 + 1);
        Some(Materials { kinds, of: parallel::from_fn(particles.positions.len(), of).into() })
    }

    /// The number of particles in each row that the rules for colours add to a legend, then of those that each rule for opacities
    /// applies to.
    pub(super) fn painted(&self, particles: &Particles) -> Vec<u64> {
        let all = 0..particles.positions.len();
        let element = |n: usize| particles.elements.get(n).copied().unwrap_or(0);
        let colored = all.clone().filter_map(|n| Some((particles.rule(RuleTarget::Color, n)?, element(n))));
        let mut faded = vec![0_u64; self.fades.len()];
        all.filter_map(|n| particles.rule(RuleTarget::Opacity, n)).for_each(|rule| faded[rule] += 1);
        [paint::counts(&self.paints, colored), faded].concat()
    }

    /// The legend with a row for each rule that gives some particle its colour or its opacity, by the numbers of [`Self::painted`]; a
    /// legend of these where there is none.
    pub(super) fn with_overrides(&self, legend: Option<Legend>, painted: &[u64]) -> Option<Legend> {
        let overrides = paint::categories(paint::rows(&self.paints).chain(self.fades.iter().map(faded)), painted);
        let legend = match legend {
            Some(legend) if overrides.is_empty() => Some(legend),
            // Where all have the colours of selections, elements are no heading.
            Some(mut legend) if legend.is_scale() || !legend.categories.is_empty() => {
                legend.overrides.extend(overrides);
                Some(legend)
            }
            _ if overrides.is_empty() => None,
            _ => Some(Legend::of_selections(overrides)),
        };
        self.titled(legend)
    }

    /// The legend with the title of the style, if that has one.
    pub(super) fn titled(&self, legend: Option<Legend>) -> Option<Legend> {
        legend.map(|legend| Legend { title: self.legend_title.clone(), ..legend })
    }

    /// The radii without the radii of rules. Nothing is said about particles that a rule gives their radius.
    fn radii_of(&self, particles: &Particles, spaced: Option<f64>, skipped: &mut Skipped) -> Vec<f64> {
        let (n, scale) = (particles.positions.len(), self.radius_scale);
        if let Some(radius) = self.radius {
            return vec![radius * scale; n];
        }
        let count = |lacks: &(dyn Fn(usize) -> bool + Sync)| {
            parallel::count(n, |n| particles.rule(RuleTarget::Radius, n).is_none() && lacks(n))
        };
        if !particles.radii.is_empty() {
            // Of several files, one of molecules has no radii, as expected.
            let has_element = |n: usize| particles.elements.get(n).is_some_and(|number| *number != 0);
            let is_expected = |n: usize| !particles.files.is_empty() && has_element(n);
            let missing = count(&|n| particles.radii[n].is_nan() && !is_expected(n));
            if missing > 0 {
                skipped.assumed.push(format!(
                    "{missing} of {n} particles have no radius in the file, so the radius of their element is used, or {UNKNOWN_RADIUS}"
                ));
            }
            let own = |n: usize| particles.elements.get(n).map_or(UNKNOWN_RADIUS, |number| self.radii.radius(*number));
            let radius = |n: usize| if particles.radii[n].is_nan() { own(n) } else { particles.radii[n] };
            return parallel::from_fn(particles.radii.len(), |n| radius(n) * scale);
        }
        if let Some(radius) = spaced {
            let missing = count(&|_| true);
            if missing > 0 {
                let particles = if missing == 1 { "particle has" } else { "particles have" };
                skipped.assumed.push(format!(
                    "{missing} {particles} no radius, so half the mean spacing is used, {}; use {RADIUS} to set another",
                    number(radius, 4)
                ));
            }
            return vec![radius * scale; n];
        }
        let known = |number: u8| element(number).and_then(|element| self.radii.of(element));
        let missing = count(&|n| known(particles.elements[n]).is_none());
        if missing > 0 {
            let names: Vec<String> = particles.unknown.iter().map(|(name, n)| format!("{n} {}", quote(name))).collect();
            let names = if names.is_empty() { String::new() } else { format!(" ({})", names.join(", ")) };
            skipped.assumed.push(format!(
                "{missing} of {n} atoms have no {} radius{names}, so {UNKNOWN_RADIUS} is used; use {RADIUS} to set one for all",
                self.radii.name()
            ));
        }
        parallel::map(&particles.elements, |number| self.radii.radius(*number) * scale)
    }

    /// Takes the file's colours where the style uses them.
    fn colors(&self, particles: &mut Particles, skipped: &mut Skipped) -> Result<(Option<Colors>, Option<Legend>)> {
        let elements = || {
            // The table is computed once, not a power for every atom.
            let table: Vec<[f32; 3]> = (0..=118).map(color_of_element).collect();
            let of = |number: &u8| table[usize::from(*number).min(118)];
            (!particles.elements.is_empty()).then(|| parallel::map(&particles.elements, of))
        };
        let colors = match &self.coloring {
            Coloring::One(color) => Some(vec![*color; particles.positions.len()]),
            Coloring::File if !particles.colors.is_empty() => {
                let mut colors = std::mem::take(&mut particles.colors);
                // Of several files, one that has no colours.
                if colors.iter().any(|color| color[0].is_nan()) {
                    let known = |n: usize| particles.elements.get(n).filter(|number| **number != 0);
                    let own = |n: usize| known(n).map_or(DEFAULT_COLOR, |number| color_of_element(*number));
                    parallel::each(&mut colors, |n, color| *color = if color[0].is_nan() { own(n) } else { *color });
                }
                Some(colors)
            }
            Coloring::File => {
                let legend = || categories::elements(&particles.elements, particles.rule_numbers(RuleTarget::Color));
                return Ok(elements().map_or((None, None), |colors| (Some(colors), Some(legend()))));
            }
            Coloring::Element => {
                let colors = elements().ok_or_else(|| {
                    Error::settings(
                        "the file has no elements to colour by",
                        format!("remove {COLOR_BY}, or use a column"),
                    )
                })?;
                return Ok((
                    Some(colors),
                    Some(categories::elements(&particles.elements, particles.rule_numbers(RuleTarget::Color))),
                ));
            }
            Coloring::Column(scale) => {
                let (colors, legend) = scale.apply(particles, skipped)?;
                return Ok((Some(colors), legend));
            }
        };
        Ok((colors, None))
    }
}

/// The error for selections of a scene that has no particles.
pub(super) fn no_selections() -> Error {
    let mend = "select particles of a particle file, or add select = \"...\" to a [[spheres]] table of the scene";
    Error::settings("this scene has no columns to select by", mend)
}

/// The mean distance between neighbours if the particles filled their box evenly; 1 for one particle.
fn spacing(positions: &[[f64; 3]]) -> f64 {
    let mut ends = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for position in positions {
        for (axis, x) in position.iter().enumerate() {
            (ends[0][axis], ends[1][axis]) = (ends[0][axis].min(*x), ends[1][axis].max(*x));
        }
    }
    spacing_of(ends, positions.len() as u64)
}

/// The same for this number of particles between these least and largest coordinates.
pub(super) fn spacing_of([low, high]: [[f64; 3]; 2], count: u64) -> f64 {
    let sides = low.iter().zip(high).map(|(a, b)| b - a).filter(|side| *side > 0.0 && side.is_finite());
    let sides: Vec<f64> = sides.collect();
    let spread = sides.iter().map(|side| side.ln()).sum::<f64>() - (count.max(1) as f64).ln();
    if sides.is_empty() { 1.0 } else { (spread / sides.len() as f64).exp() }
}

/// The label and the colour of a rule for opacities: grey on white, as translucent as its spheres are.
pub(super) fn faded((selection, opacity): &(Selection, f32)) -> (String, [f32; 3]) {
    let mixed = 1.0 + opacity * (VEILED_GREY - 1.0);
    let label = selection.caption().map_or_else(|| format!("{selection}: opacity {opacity}"), str::to_owned);
    (label, [mixed; 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn particles(n: usize) -> Particles {
        Particles { positions: (0..n).map(|k| [k as f64, 0.0, 0.0]).collect(), ..Particles::default() }
    }

    #[test]
    fn radii_come_from_the_option_the_file_the_element_or_the_spacing() {
        let mut p = particles(5);
        let radii = |style: &Style, p: &Particles| {
            let mut skipped = Skipped::default();
            (style.radii_of(p, style.spaced(p), &mut skipped), skipped.assumed.len())
        };
        let style = Style::default();
        let (spaced, warned) = radii(&style, &p);
        // Five in a row at a spacing of one fill a length of four.
        assert!((spaced[0] - 0.4).abs() < 1e-12 && warned == 1, "{spaced:?}");
        p.elements = vec![6, 1, 0, 8, 118];
        let (of_elements, warned) = radii(&style, &p);
        assert_eq!((&of_elements[..], warned), (&[1.7, 1.2, UNKNOWN_RADIUS, 1.52, UNKNOWN_RADIUS][..], 1));
        let covalent = Style { radii: Radii::Covalent, radius_scale: 2.0, ..style.clone() };
        assert_eq!(radii(&covalent, &p).0[..2], [1.52, 0.62]);
        p.radii = vec![3.0; 5];
        assert_eq!(radii(&style, &p), (vec![3.0; 5], 0));
        p.radii[1..3].fill(f64::NAN);
        assert_eq!(radii(&style, &p), (vec![3.0, 1.2, UNKNOWN_RADIUS, 3.0, 3.0], 1));
        p.radii = vec![3.0; 5];
        assert_eq!(radii(&Style { radius: Some(0.5), ..covalent }, &p), (vec![1.0; 5], 0));
    }
}
