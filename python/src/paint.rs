//! Colours of selected spheres, and their legend.

use halfline::Spheres;
use halfline::frame::legend::{Category, Legend};
use halfline::frame::srgb;
use halfline::scene::DEFAULT_COLOR;
use halfline_files::read::{Columns, Selection};
use rayon::prelude::*;

/// Which rule colours each sphere: 0 none, else its number from 1.
pub(crate) struct Paint(Vec<u32>);

impl Paint {
    /// Finds the last rule that selects each sphere. The last `beads` spheres are beads of a cell, which keep their colour, as
    /// those of a reader do. Returns also notes on the rules.
    ///
    /// # Errors
    /// Errors of the selections, also for a column that was not kept.
    pub(crate) fn of(
        columns: &Columns,
        spheres: &Spheres,
        beads: usize,
        rules: &[(Selection, [f32; 3])],
    ) -> halfline::Result<(Self, Vec<String>)> {
        let (mut paint, mut notes) = (vec![0; spheres.len()], Vec::new());
        let count = spheres.len() - beads;
        for (number, (selection, _)) in (1..).zip(rules) {
            let (mask, messages) = columns.select(selection, spheres)?;
            paint[..count].par_iter_mut().zip(&mask).filter(|(_, flag)| **flag).for_each(|(paint, _)| *paint = number);
            notes.extend(messages);
        }
        Ok((Self(paint), notes))
    }

    /// The colours, and the legend: rows of before whose colours are still there, and the rules that colour some sphere.
    pub(crate) fn apply(
        &self,
        spheres: &Spheres,
        rules: &[(Selection, [f32; 3])],
        legend: Option<&Legend>,
    ) -> (Vec<[f32; 3]>, Option<Legend>) {
        let before = |n: usize| spheres.colors.as_ref().map_or(DEFAULT_COLOR, |colors| colors[n]);
        let color = |(n, rule): (usize, &u32)| match rule {
            0 => before(n),
            rule => rules[*rule as usize - 1].1,
        };
        let colors: Vec<[f32; 3]> = self.0.par_iter().enumerate().map(color).collect();
        let mut counts = vec![0_u64; rules.len()];
        self.0.iter().filter(|rule| **rule > 0).for_each(|rule| counts[*rule as usize - 1] += 1);
        let stays = |row: &&Category| {
            let is_shown = |(n, rule): (usize, &u32)| *rule == 0 && before(n).map(srgb::level) == row.color;
            self.0.par_iter().enumerate().any(is_shown)
        };
        let rows = rules.iter().zip(counts).filter(|(_, count)| *count > 0);
        let rows = rows.map(|((selection, color), count)| Category {
            label: selection.to_string(),
            color: color.map(srgb::level),
            count,
        });
        let old = legend.into_iter().flat_map(|legend| &legend.overrides).filter(stays).cloned();
        let overrides: Vec<Category> = old.chain(rows).collect();
        let legend = match legend {
            Some(legend) if legend.is_scale() => Some(Legend { overrides, ..legend.clone() }),
            Some(legend) => {
                let categories: Vec<Category> = legend.categories.iter().filter(stays).cloned().collect();
                // As the reader has it: without categories the legend is that of the selections.
                match categories.is_empty() {
                    true => Some(Legend::of_selections(overrides)),
                    false => Some(Legend { categories, overrides, ..legend.clone() }),
                }
            }
            None if overrides.is_empty() => None,
            None => Some(Legend::of_selections(overrides)),
        };
        (colors, legend)
    }
}
