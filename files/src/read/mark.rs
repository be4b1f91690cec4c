//! Marks: texts on things of a picture, which selections name.

use super::sequence::SceneFrame;
use halfline::error::{Error, Result};
use halfline::quote::setting::{MARK, MARK_ONE};
use halfline::quote::{count, list, number, quote};
use halfline_particles::{ColumnValue, Selection};
use std::str::FromStr;

/// The most marks of a picture.
const MOST: usize = 500;

/// The most letters of a mark.
const LETTERS: usize = 200;

/// The words of selections for the columns that tell residues apart.
const RESIDUE: [&str; 5] = ["chain", "segid", "resid", "icode", "resname"];

/// A text for what a selection selects; `{column}` in it stands for the value of a column.
#[derive(Debug, Clone)]
pub struct MarkRule {
    selection: Selection,
    /// Whether what is selected is one thing.
    once: bool,
    parts: Vec<Part>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Part {
    Text(String),
    Column(String),
}

/// A thing with its text: spheres of one residue, or one sphere.
#[derive(Debug, Clone, PartialEq)]
pub struct Marked {
    /// The text.
    pub text: String,
    /// The ids of the spheres that are selected of it, in increasing order.
    pub ids: Vec<u32>,
}

/// The number of marks and a digest of their texts and spheres, for provenance: 16 hexadecimal digits of BLAKE3.
#[must_use]
pub fn words(marked: &[Marked], all: bool) -> String {
    let mut hash = blake3::Hasher::new();
    for Marked { text, ids } in marked {
        hash.update(text.as_bytes());
        hash.update(&[0]);
        hash.update(bytemuck::cast_slice(ids));
        hash.update(&u32::MAX.to_le_bytes());
    }
    let hidden = if all { ", also of what is hidden" } else { "" };
    format!("{}{hidden}, {}", count(marked.len() as u64, "mark"), &hash.finalize().to_hex()[..16])
}

impl MarkRule {
    /// The rule of a selection and a text.
    ///
    /// # Errors
    /// [`Error::Settings`] for an expression that is no selection, and for a text that is blank, too long, or has a brace without its
    /// other.
    pub fn new(expression: &str, text: &str) -> Result<Self> {
        if text.trim().is_empty() || text.chars().count() > LETTERS {
            let what = if text.trim().is_empty() { "empty" } else { "too long" };
            return Err(Error::settings(
                format!("the text of a mark is {what}"),
                format!("use 1 to {LETTERS} letters"),
            ));
        }
        let (mut parts, mut rest) = (Vec::new(), text);
        while let Some(start) = rest.find(['{', '}']) {
            let (before, from) = rest.split_at(start);
            let inside = from.strip_prefix('{').and_then(|from| from.split_once('}'));
            let Some((name, after)) = inside.filter(|(name, _)| !name.trim().is_empty()) else {
                let problem = "a brace in the text of a mark is alone";
                return Err(Error::settings(problem, "write {column} for the value of a column"));
            };
            parts.extend([Part::Text(before.to_owned()), Part::Column(name.trim().to_owned())]);
            rest = after;
        }
        parts.push(Part::Text(rest.to_owned()));
        Ok(Self { selection: expression.parse()?, once: false, parts })
    }

    /// The rule that writes its text once, for all that is selected.
    #[must_use]
    pub fn once(self) -> Self {
        Self { once: true, ..self }
    }
}

impl FromStr for MarkRule {
    type Err = Error;

    /// Parses `EXPR=TEXT`; an expression may contain an equals sign, a text does not.
    ///
    /// # Errors
    /// Errors of [`MarkRule::new`], and [`Error::Settings`] without an equals sign.
    fn from_str(rule: &str) -> Result<Self> {
        let Some((expression, text)) = rule.rsplit_once('=') else {
            return Err(Error::settings("a mark has no text", "write EXPR=TEXT, such as 'ligand={resname}'"));
        };
        Self::new(expression, text)
    }
}

impl SceneFrame {
    /// The things that rules select, with their texts. Of a rule [once](MarkRule::once) all selected spheres are one thing. Else
    /// the selected particles of each residue are one thing, or without residues each selected sphere is. Beads of a cell are none. Returns
    /// also messages about the selections.
    ///
    /// # Errors
    /// Errors of the selections; [`Error::Settings`] for a column that is not there, and for more than 500 things.
    pub fn marked(&self, rules: &[MarkRule]) -> Result<(Vec<Marked>, Vec<String>)> {
        let (mut marked, mut notes) = (Vec::new(), Vec::new());
        let things = if rules.is_empty() { Vec::new() } else { self.things() };
        for rule in rules {
            let (mask, messages) = self.selected(&rule.selection)?;
            notes.extend(messages);
            let (mut last, first) = (None, marked.len());
            for (n, thing) in things.iter().enumerate().filter(|(n, _)| mask.get(*n).is_some_and(|flag| *flag)) {
                match marked.last_mut().filter(|_| last.is_some_and(|last| rule.once || last == *thing)) {
                    Some(Marked { ids, .. }) => ids.push(n as u32),
                    None => marked.push(Marked { text: self.text_of(rule, n)?, ids: vec![n as u32] }),
                }
                last = Some(*thing);
            }
            notes.extend(
                marked
                    .get(first)
                    .filter(|_| rule.once)
                    .and_then(|mark| self.several(rule, mark).transpose())
                    .transpose()?,
            );
            if marked.len() > MOST {
                let problem = format!("{MARK} has {}, more than {MOST}", count(marked.len() as u64, "thing"));
                let mend = format!("select fewer, such as one atom of each residue, or name them once by {MARK_ONE}");
                return Err(Error::settings(problem, mend));
            }
        }
        Ok((marked, notes))
    }

    /// A note about a text for one thing whose columns have other values at other spheres of it.
    fn several(&self, rule: &MarkRule, Marked { text, ids }: &Marked) -> Result<Option<String>> {
        if rule.parts.iter().all(|part| matches!(part, Part::Text(_))) {
            return Ok(None);
        }
        for id in ids {
            let other = self.text_of(rule, *id as usize)?;
            if other != *text {
                let selection = rule.selection.brief();
                return Ok(Some(format!(
                    "{MARK_ONE} writes {} at all that {selection} selects, but the text of some is {}; \
                     select less, or use {MARK}",
                    quote(text),
                    quote(&other)
                )));
            }
        }
        Ok(None)
    }

    /// The number of the thing that each particle belongs to: neighbours in the file with the same residue are one.
    fn things(&self) -> Vec<u32> {
        let particles = self.scene.spheres.len() - self.beads;
        let columns: Vec<_> = RESIDUE.iter().filter_map(|word| self.columns.get(word).ok()).collect();
        let has_residues = self.columns.get("resid").is_ok();
        let mut thing = 0;
        let number = |n: usize| {
            let is_same = |(_, values): &(&str, &super::ColumnValues)| values.value(n) == values.value(n - 1);
            if n > 0 && !(has_residues && columns.iter().all(is_same)) {
                thing += 1;
            }
            thing
        };
        (0..particles).map(number).collect()
    }

    /// The number of a sphere that every scene has: a coordinate, its radius, its index.
    fn own_number(&self, name: &str, n: usize) -> Option<f64> {
        let spheres = &self.scene.spheres;
        let [x, y, z] = spheres.centers[n];
        match name {
            "x" => Some(x),
            "y" => Some(y),
            "z" => Some(z),
            "radius" => Some(spheres.radii[n]),
            "index" => Some(n as f64),
            _ => None,
        }
    }

    /// The text of a rule for the thing of a sphere.
    fn text_of(&self, rule: &MarkRule, n: usize) -> Result<String> {
        let part = |part: &Part| match part {
            Part::Text(text) => Ok(text.clone()),
            Part::Column(name) => match (self.columns.get(name), self.own_number(name, n)) {
                (Ok((_, values)), _) => Ok(match values.value(n) {
                    ColumnValue::Text(text) => text.to_owned(),
                    ColumnValue::Number(x) => brief(x),
                }),
                (Err(_), Some(x)) => Ok(brief(x)),
                (Err(_), None) => {
                    let problem = format!("the text of {MARK} has {}, and there is no such column", quote(name));
                    let names = self.columns.names().chain(["x", "y", "z", "radius"]);
                    Err(Error::settings(problem, format!("use one of {}", list(names))))
                }
            },
        };
        rule.parts.iter().map(part).collect()
    }
}

/// A number of five digits, a whole one with all of its digits; blank for NaN.
fn brief(x: f64) -> String {
    match x {
        x if x.is_nan() => String::new(),
        x if x == x.trunc() && x.abs() < 1e15 => format!("{x:.0}"),
        x => number(x, 5),
    }
}
