//! Colours and opacities of selected spheres of a frame, and their legend.

use super::sequence::SceneFrame;
use super::style::{self, Paint, Style, paint};
use halfline::error::Result;
use halfline::frame::legend::{Category, Legend};
use halfline::frame::srgb;
use halfline::parallel::{self, CHEAP};
use halfline::scene::DEFAULT_COLOR;
use halfline_particles::Selection;

impl SceneFrame {
    /// The same spheres with the colours and the opacities that the rules of a style give them.
    ///
    /// # Errors
    /// As [`Self::painted`].
    pub fn styled(&self, style: &Style) -> Result<Self> {
        let painted = if style.paints.is_empty() { self.clone() } else { self.painted(&style.paints)?.0 };
        let mut faded = painted.faded(style)?;
        faded.legend = style.titled(faded.legend.take());
        Ok(faded)
    }

    /// The same spheres, which had no opacities before, with these opacities, and a row of the legend for each rule.
    fn faded(mut self, style: &Style) -> Result<Self> {
        if style.opacity.is_none() && style.fades.is_empty() {
            return Ok(self);
        }
        let (chosen, _) = self.chosen(&style.fades)?;
        let count = chosen.len() - self.beads;
        let of_all = style.opacity.unwrap_or(1.0);
        let opacity = |n: usize| match chosen[n] {
            _ if n >= count => 1.0,
            0 => of_all,
            rule => style.fades[rule as usize - 1].1,
        };
        self.scene.spheres.opacities = Some(parallel::from_fn(chosen.len(), opacity).into());
        self.scene.spheres.share();
        let rows = paint::categories(style.fades.iter().map(style::faded), &counts(&chosen, style.fades.len()));
        match &mut self.legend {
            Some(legend) => legend.overrides.extend(rows),
            None if rows.is_empty() => {}
            None => self.legend = Some(Legend::of_selections(rows)),
        }
        Ok(self)
    }

    /// The same spheres, each in the colour of the last rule that selects it, and with a legend of these colours. Beads of a
    /// cell keep their colours, as beads of a reader do. Returns also notes on the rules.
    ///
    /// # Errors
    /// Errors of the selections, also for a column that was not kept.
    pub fn painted(&self, rules: &[(Selection, Paint)]) -> Result<(Self, Vec<String>)> {
        let (paint, notes) = self.chosen(rules)?;
        let elements = self.columns.elements();
        paint::check(rules, &elements)?;
        let element = |n: usize| elements.get(n).copied().unwrap_or(0);
        let before = |n: usize| self.scene.spheres.colors.as_ref().map_or(DEFAULT_COLOR, |colors| colors[n]);
        let color = |n: usize| match paint[n] {
            0 => before(n),
            rule => rules[rule as usize - 1].1.color(element(n)),
        };
        let colors = parallel::from_fn(paint.len(), color);
        let stays = |row: &&Category| {
            let is_shown = |n: usize| paint[n] == 0 && before(n).map(srgb::level) == row.color;
            parallel::any(paint.len(), CHEAP, &|mut spheres| spheres.any(is_shown))
        };
        let mut painted = Self { legend: self.legend_with(&paint, rules, element, stays), ..self.clone() };
        painted.scene.spheres.colors = Some(colors.into());
        painted.scene.spheres.share();
        Ok((painted, notes))
    }

    /// The number of the last rule that selects each sphere, from 1; 0 for none.
    fn chosen<T>(&self, rules: &[(Selection, T)]) -> Result<(Vec<u32>, Vec<String>)> {
        let spheres = &self.scene.spheres;
        let (mut paint, mut notes) = (vec![0; spheres.len()], Vec::new());
        let count = spheres.len() - self.beads;
        for (number, (selection, _)) in (1..).zip(rules) {
            let (mask, messages) = self.selected(selection)?;
            parallel::zip(&mut paint[..count], &mask, |paint, flag| *paint = if *flag { number } else { *paint });
            notes.extend(messages);
        }
        Ok((paint, notes))
    }

    /// The legend: rows of before whose colours stay, and the rules that colour some sphere.
    fn legend_with(
        &self,
        paint: &[u32],
        rules: &[(Selection, Paint)],
        element: impl Fn(usize) -> u8,
        stays: impl Fn(&&Category) -> bool,
    ) -> Option<Legend> {
        let painted = paint.iter().zip(0..).filter(|(rule, _)| **rule > 0);
        let counts = paint::counts(rules, painted.map(|(rule, n)| (*rule as usize - 1, element(n))));
        let rows = paint::categories(paint::rows(rules), &counts);
        let old = self.legend.iter().flat_map(|legend| &legend.overrides).filter(&stays).cloned();
        let overrides: Vec<Category> = old.chain(rows).collect();
        match &self.legend {
            Some(legend) if legend.is_scale() => Some(Legend { overrides, ..legend.clone() }),
            Some(legend) => {
                let categories: Vec<Category> = legend.categories.iter().filter(stays).cloned().collect();
                // As the reader has it: without categories the legend shows the selections.
                match categories.is_empty() {
                    true => Some(Legend::of_selections(overrides)),
                    false => Some(Legend { categories, overrides, ..legend.clone() }),
                }
            }
            None if overrides.is_empty() => None,
            None => Some(Legend::of_selections(overrides)),
        }
    }
}

/// The number of spheres that each of so many rules gives its value.
fn counts(chosen: &[u32], rules: usize) -> Vec<u64> {
    let mut counts = vec![0; rules];
    chosen.iter().filter(|rule| **rule > 0).for_each(|rule| counts[*rule as usize - 1] += 1);
    counts
}
