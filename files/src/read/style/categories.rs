//! Colours of categories: names, numbers that identify, elements.

use super::confidence;
use super::scale::{Colored, Scale};
use halfline::error::{Error, Result};
use halfline::frame::color_map::ColorMap;
use halfline::frame::legend::{Category, Legend};
use halfline::parallel;
use halfline::quote::setting::{LOG, RANGE};
use halfline_particles::Skipped;
use halfline_particles::elements::element;
use halfline_particles::particles::frame::{Column, Particles, RuleTarget};
use std::collections::{BTreeMap, HashMap};

/// Columns whose whole numbers are identifiers: of types, molecules, copies.
const NUMBERED: [&str; 7] = ["type", "typeid", "mol", "molecule", "model", "copy", "cluster"];

/// The most categories that are counted separately; the rest are counted together.
const MOST: usize = 1 << 16;

/// 0xrrggbb of an element in 8-bit sRGB; deep pink if it is unknown.
pub(super) fn of_element(number: u8) -> u32 {
    element(number).map_or(0xff1493, |element| element.color)
}

/// The legend of the elements that occur, by atomic number; unknown elements come last. `paint` has the rules that give
/// particles other colours, see [`Particles::paint`]; these are not counted.
pub(super) fn elements(elements: &[u8], paint: &[u16]) -> Legend {
    let mut counts = [0_u64; 256];
    let own = elements.iter().enumerate().filter(|(n, _)| !is_painted(paint, *n));
    own.for_each(|(_, number)| counts[usize::from(*number)] += 1);
    let there = (1..=u8::MAX).chain([0]).filter(|number| counts[usize::from(*number)] > 0);
    let category = |number: u8| {
        let [_, red, green, blue] = of_element(number).to_be_bytes();
        let label = element(number).map_or("unknown", |element| element.symbol).to_owned();
        Category { label, color: [red, green, blue], count: counts[usize::from(number)] }
    };
    let categories = there.map(category).collect();
    let (map, range) = (ColorMap::Category, [1.0, 118.0]);
    Legend {
        name: "element".into(),
        title: None,
        map,
        range,
        log: false,
        categories,
        names: Vec::new(),
        overrides: Vec::new(),
    }
}

/// Whether a rule gives particle `n` a colour of its own.
pub(super) fn is_painted(paint: &[u16], n: usize) -> bool {
    paint.get(n).is_some_and(|rule| *rule > 0)
}

/// The legend of two parts of a file: names in their order, elements in the order of [`elements`].
pub(in crate::read) fn joined_categories(mut first: Legend, second: &Legend) -> Legend {
    let rows = [(&mut first.categories, &second.categories), (&mut first.overrides, &second.overrides)];
    for (rows, more) in rows {
        for category in more {
            match rows.iter_mut().find(|known| known.label == category.label) {
                Some(known) => known.count += category.count,
                None => rows.push(category.clone()),
            }
        }
    }
    let names = std::mem::take(&mut first.names);
    let number = |label: &str| (1..=u8::MAX).find(|n| element(*n).is_some_and(|found| found.symbol == label));
    let place = |label: &str| match names.iter().position(|name| name == label) {
        Some(place) => place,
        None => usize::from(number(label).unwrap_or(u8::MAX)),
    };
    first.categories.sort_by_key(|category| place(&category.label));
    first.names = names;
    first
}

/// The colours and the legend where the scale's columns are categories; `None` where they are numbers.
///
/// # Errors
/// [`Error::Settings`] for a range, a logarithm or several columns of categories.
pub(super) fn apply(
    scale: &Scale,
    columns: &[&Column],
    particles: &Particles,
    skipped: &mut Skipped,
) -> Result<Option<Colored>> {
    let labels = columns.iter().find_map(|column| particles.labels.get(&column.name)).map(Vec::as_slice);
    let name = scale.columns.join(", ");
    if labels.is_none() && scale.map == Some(ColorMap::Plddt) {
        let column = only(&Scale { range: None, ..scale.clone() }, columns, &name)?;
        let classes = confidence::classes(column, scale.ends(column.values.iter().copied()), skipped);
        let scale = Scale { names: Vec::new(), ..scale.clone() };
        return Ok(Some(colored(&scale, confidence::NAME, &classes.column, Some(&classes.names), particles, skipped)));
    }
    if labels.is_none() && !are_categories(scale, columns) {
        return Ok(None);
    }
    let column = only(scale, columns, &name)?;
    Ok(Some(colored(scale, &name, column, labels, particles, skipped)))
}

/// The colours and the legend of a column of categories, with the labels of its numbers where it has names.
fn colored(
    scale: &Scale,
    name: &str,
    column: &Column,
    labels: Option<&[String]>,
    particles: &Particles,
    skipped: &mut Skipped,
) -> Colored {
    let categories = Categories::new(scale, labels);
    let counts = Counts::of(&categories, column, particles.rule_numbers(RuleTarget::Color));
    skipped.assumed.extend(counts.notes(name, column.values.len(), &categories.map, &scale.missing_words()));
    let ends = |n: Option<&i64>| n.map_or(0.0, |n| *n as f64);
    let legend = Legend {
        name: name.to_owned(),
        title: None,
        map: categories.map.clone(),
        range: [ends(counts.known.keys().next()), ends(counts.known.keys().next_back())],
        log: false,
        categories: counts.known.iter().map(|(number, count)| categories.row(*number, *count)).collect(),
        names: categories.names.clone(),
        overrides: scale.missing_row("none", counts.missing).into_iter().collect(),
    };
    // Few colours for many particles.
    let known: BTreeMap<i64, [f32; 3]> = counts.known.keys().map(|n| (*n, categories.color(*n as f64))).collect();
    let of = |x: &f64| {
        let category = categories.of(*x);
        let color = known.get(&(category as i64)).filter(|_| category.is_finite());
        color.copied().unwrap_or_else(|| categories.color(category))
    };
    let colors = parallel::map(&column.values, of);
    (colors, (counts.several() > 0).then_some(legend))
}

/// Whether columns of numbers are categories: by the map, or because the column's whole numbers are identifiers.
fn are_categories(scale: &Scale, columns: &[&Column]) -> bool {
    let whole = |column: &Column| parallel::all(&column.values, |x| x.fract() == 0.0);
    let is_plain = scale.map.is_none() && scale.range.is_none() && !scale.log;
    let are_numbered = || matches!(columns, [column] if NUMBERED.contains(&&column.name[..]) && whole(column));
    scale.map == Some(ColorMap::Category) || is_plain && are_numbered()
}

/// The column of categories.
///
/// # Errors
/// [`Error::Settings`] for what categories do not have: several columns, a range, a logarithm.
fn only<'a>(scale: &Scale, columns: &[&'a Column], name: &str) -> Result<&'a Column> {
    let refused =
        |what: &str, mend: String| Err(Error::settings(format!("{name} has categories, which have no {what}"), mend));
    match columns {
        [_] if scale.range.is_some() => refused("range", format!("remove {RANGE}, or use a column of numbers")),
        [_] if scale.log => refused("logarithm", format!("remove {LOG}, or use a column of numbers")),
        [column] => Ok(column),
        _ => refused("length", "use one column".into()),
    }
}

/// The categories of a column: their names and their colours.
struct Categories {
    /// The names by the numbers of the categories; empty for a column of numbers.
    names: Vec<String>,
    /// The category of each label of the file, by its place; `None` for a column of numbers.
    places: Option<Vec<f64>>,
    map: ColorMap,
    /// The category at the end of a continuous map.
    last: f64,
    /// Linear RGB of particles without a category.
    missing: [f32; 3],
}

impl Categories {
    fn new(scale: &Scale, labels: Option<&[String]>) -> Self {
        let (names, places) = labels.map(|labels| joined(&scale.names, labels)).unzip();
        let names: Vec<String> = names.unwrap_or_default();
        // A continuous map is spread over all names of the file.
        let last = labels.map_or(1, |_| names.len().saturating_sub(1).max(1)) as f64;
        Self { names, places, map: scale.map.clone().unwrap_or(ColorMap::Category), last, missing: scale.missing() }
    }

    /// The category of a value; not finite if it has none.
    fn of(&self, value: f64) -> f64 {
        match &self.places {
            Some(places) if value >= 0.0 => places.get(value as usize).copied().unwrap_or(f64::NAN),
            _ => value.floor(),
        }
    }

    /// The place of a category on the map.
    fn place(&self, category: f64) -> f64 {
        if self.map == ColorMap::Category { category } else { category / self.last }
    }

    fn color(&self, category: f64) -> [f32; 3] {
        if category.is_finite() { self.map.color(self.place(category)) } else { self.missing }
    }

    /// The row of a category in the legend.
    fn row(&self, number: i64, count: u64) -> Category {
        let label = match self.places {
            Some(_) => usize::try_from(number).ok().and_then(|n| self.names.get(n)).cloned().unwrap_or_default(),
            None => number.to_string(),
        };
        let label = Some(label).filter(|label| !label.trim().is_empty()).unwrap_or_else(|| "(blank)".into());
        Category { label, color: self.map.srgb(self.place(number as f64)), count }
    }
}

/// The numbers of particles in categories.
#[derive(Default)]
struct Counts {
    /// By category, at most [`MOST`].
    known: BTreeMap<i64, u64>,
    /// Particles without a category.
    missing: u64,
    /// Particles in other categories.
    more: u64,
}

impl Counts {
    fn of(categories: &Categories, column: &Column, paint: &[u16]) -> Self {
        let mut counts = Self::default();
        for (_, value) in column.values.iter().enumerate().filter(|(n, _)| !is_painted(paint, *n)) {
            let has_room = counts.known.len() < MOST;
            match categories.of(*value) {
                category if !category.is_finite() => counts.missing += 1,
                category if has_room || counts.known.contains_key(&(category as i64)) => {
                    *counts.known.entry(category as i64).or_default() += 1;
                }
                _ => counts.more += 1,
            }
        }
        counts
    }

    /// The number of categories, at least.
    fn several(&self) -> u64 {
        self.known.len() as u64 + self.more
    }

    /// Notes on particles without a category, of so many, and on categories that share colours.
    fn notes(&self, name: &str, of: usize, map: &ColorMap, color: &str) -> impl Iterator<Item = String> {
        let (missing, several, colors) = (self.missing, self.several(), ColorMap::CATEGORIES);
        let missing = (missing > 0).then(|| {
            format!(
                "{missing} of {of} values of {name} are not numbers, so these particles have no category and {color}"
            )
        });
        let shared = (*map == ColorMap::Category && several > colors)
            .then(|| format!("{several} categories of {name} share {colors} colours"));
        missing.into_iter().chain(shared)
    }
}

/// The known names and then the new ones of a file, and the place of each of the file's names in this list.
fn joined(known: &[String], labels: &[String]) -> (Vec<String>, Vec<f64>) {
    let mut names = known.to_vec();
    let mut places: HashMap<&str, usize> = known.iter().enumerate().map(|(n, name)| (name.as_str(), n)).collect();
    let mut place = |name| {
        *places.entry(name).or_insert_with(|| {
            names.push(name.to_owned());
            names.len() - 1
        }) as f64
    };
    let numbers = labels.iter().map(|name| place(name.as_str())).collect();
    (names, numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::style::scale::RangeEnd;
    use halfline::frame::srgb::linear;
    use halfline_particles::color::of_hex;

    fn colored(name: &str, values: &[f64], labels: &[&str], scale: &Scale) -> Result<Option<(Colored, Vec<String>)>> {
        let column = Column { name: name.into(), values: values.to_vec() };
        let mut particles = Particles::default();
        if !labels.is_empty() {
            particles.labels.insert(name.into(), labels.iter().map(|label| (*label).to_owned()).collect());
        }
        let mut skipped = Skipped::default();
        Ok(apply(scale, &[&column], &particles, &mut skipped)?.map(|found| (found, skipped.assumed)))
    }

    fn scale(name: &str, map: Option<ColorMap>) -> Scale {
        Scale { map, ..Scale::of(vec![name.into()]) }
    }

    #[test]
    fn names_are_categories_by_default() {
        let chains = ["A", "B", " ", "D"];
        let ((colors, legend), warnings) = colored("chain", &[0.0, 0.0, 3.0, 2.0], &chains, &scale("chain", None))
            .expect("colours")
            .expect("categories");
        let categories = legend.expect("a legend").categories;
        let found: Vec<(&str, u64)> = categories.iter().map(|category| (&category.label[..], category.count)).collect();
        assert_eq!(found, [("A", 2), ("(blank)", 1), ("D", 1)], "absent categories have no swatch");
        assert_eq!(colors, [0.0, 0.0, 3.0, 2.0].map(|k| ColorMap::Category.color(k)));
        assert_eq!(categories[2].color, ColorMap::Category.srgb(3.0));
        assert!(warnings.is_empty(), "{warnings:?}");
        // A film keeps the colours of its first frame's names; new ones follow.
        let fixed = Scale { names: vec!["D".into(), "C".into()], ..scale("chain", None) };
        let ((colors, legend), _) = colored("chain", &[0.0, 3.0, 1.0], &chains, &fixed).expect("ok").expect("some");
        assert_eq!(colors, [2.0, 0.0, 3.0].map(|k| ColorMap::Category.color(k)));
        let legend = legend.expect("a legend");
        let found: Vec<&str> = legend.categories.iter().map(|category| &category.label[..]).collect();
        assert_eq!((found, legend.names), (vec!["D", "A", "B"], ["D", "C", "A", "B", " "].map(String::from).to_vec()));
        // A continuous map is spread over the names.
        let viridis = Some(ColorMap::Viridis);
        let ((colors, _), _) =
            colored("chain", &[0.0, 3.0, 1.5], &chains, &scale("chain", viridis)).expect("ok").expect("some");
        assert_eq!(colors[..2], [ColorMap::Viridis.color(0.0), ColorMap::Viridis.color(1.0)]);
    }

    #[test]
    fn whole_numbers_are_categories_where_they_are_names() {
        let is =
            |name: &str, values: &[f64], map| colored(name, values, &[], &scale(name, map)).expect("colours").is_some();
        assert!(is("type", &[1.0, 2.0], None) && is("mass", &[1.0, 2.0], Some(ColorMap::Category)));
        assert!(!is("mass", &[1.0, 2.0], None) && !is("type", &[1.0, 2.5], None));
        assert!(!is("type", &[1.0, 2.0], Some(ColorMap::Viridis)));
        let numbers = Scale { range: Some([0.0, 5.0].map(RangeEnd::Value)), ..scale("type", None) };
        assert!(colored("type", &[1.0], &[], &numbers).expect("numbers").is_none(), "a range needs numbers");
        let values = [2.0, f64::NAN, -1.0, 2.5, f64::INFINITY];
        let ((colors, legend), warnings) =
            colored("q", &values, &[], &scale("q", Some(ColorMap::Category))).expect("ok").expect("categories");
        let legend = legend.expect("a legend");
        let labels: Vec<&str> = legend.categories.iter().map(|category| &category.label[..]).collect();
        assert_eq!((labels, legend.range), (vec!["-1", "2"], [-1.0, 2.0]));
        assert_eq!((colors[1], colors[4], colors[0]), (linear([0x80; 3]), linear([0x80; 3]), colors[3]));
        assert!(warnings[0].starts_with("2 of 5 values of q"), "{warnings:?}");
        let many: Vec<f64> = (0..40).map(f64::from).collect();
        let (_, warnings) = colored("type", &many, &[], &scale("type", None)).expect("ok").expect("categories");
        assert!(warnings[0].starts_with("40 categories of type share 30 colours"), "{warnings:?}");
    }

    #[test]
    fn categories_have_no_range_and_no_logarithm() {
        for (bad, word) in [
            (Scale { range: Some([0.0, 1.0].map(RangeEnd::Value)), ..scale("chain", None) }, "range"),
            (Scale { log: true, ..scale("chain", None) }, "logarithm"),
        ] {
            let error = colored("chain", &[0.0], &["A"], &bad).map(drop).expect_err(word).to_string();
            assert!(error.contains(word) && error.contains("chain"), "{error}");
        }
    }

    #[test]
    fn elements_are_listed_by_number() {
        let found = elements(&[8, 1, 1, 0, 6], &[]).categories;
        let labels: Vec<(&str, u64)> = found.iter().map(|category| (&category.label[..], category.count)).collect();
        assert_eq!(labels, [("H", 2), ("C", 1), ("O", 1), ("unknown", 1)]);
        assert_eq!((linear(found[2].color), found[3].color), (of_hex(of_element(8)), [0xff, 0x14, 0x93]));
        let found = elements(&[8, 1, 1, 6], &[0, 1, 1, 2]).categories;
        assert_eq!(
            found.iter().map(|found| &found.label[..]).collect::<Vec<_>>(),
            ["O"],
            "the others have other colours"
        );
        let parts = joined_categories(elements(&[8, 0, 6], &[]), &elements(&[7, 8, 1], &[]));
        assert_eq!(parts, elements(&[8, 0, 6, 7, 8, 1], &[]));
    }
}
