//! The columns of the particles of a scene: names, numbers and texts in the order of its spheres, for those who look up
//! what a file says about an id.

use super::elements::element;
use super::particles::frame::{Column, Particles};
use super::select::selection::Selection;
use super::select::{self, candidates};
use halfline_ground::error::{Error, Result};
use halfline_ground::memory::check;
use halfline_ground::parallel;
use halfline_ground::quote::{list, quote};
use std::collections::BTreeMap;

/// Columns in the order of a scene's spheres.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Columns {
    /// Names and values; the names in the order of the file, then `element` and `index`.
    list: Vec<(String, ColumnValues)>,
    /// Columns of the file that were not kept.
    others: Vec<String>,
}

/// The values of a column, one per sphere.
#[derive(Debug, Clone, PartialEq)]
pub enum ColumnValues {
    /// Numbers; NaN where the file has none, and for spheres that are no particles.
    Numbers(Vec<f64>),
    /// Numbers that count or identify, all of them whole.
    Whole(Vec<i32>),
    /// 0, 1, 2 ... up to this number of spheres.
    Order(usize),
    /// Texts: for each sphere the index of its text.
    Texts(Codes, Vec<String>),
}

/// Indices of texts, in the smallest type that holds all of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Codes {
    /// Up to 256 texts.
    U8(Vec<u8>),
    /// Up to 65,536 texts.
    U16(Vec<u16>),
    /// More than 65,536 texts.
    U32(Vec<u32>),
}

/// The words of selections for the number in the file and for the element, which every format has alike.
const INDEX: &str = "index";
const ELEMENT: &str = "element";

/// Columns that count or identify: their numbers are whole. Others are measured, even if all of their values are whole.
const WHOLE: [&str; 18] = [
    "residue",
    "resid",
    "resnum",
    "serial",
    "id",
    "type",
    "typeid",
    "mol",
    "molecule",
    "model",
    "copy",
    "ix",
    "iy",
    "iz",
    "body",
    "proc",
    "classification",
    "return_number",
];

/// Columns that a scene has anyway: the coordinates and the radii of its spheres.
const OWN: [&str; 4] = ["x", "y", "z", "radius"];

impl Columns {
    /// The columns that were read with these particles.
    ///
    /// # Errors
    /// [`Error::Limits`] where memory is short.
    pub fn of(particles: &Particles) -> Result<Self> {
        let count = particles.positions.len();
        let each = 5 + 8 * particles.columns.len();
        check((count * each) as u64, || format!("the columns of {count} particles"))?;
        let has_elements = !particles.elements.is_empty();
        let is_own = |name: &str| OWN.contains(&name) || name == INDEX || has_elements && name == ELEMENT;
        let read = particles.columns.iter().filter(|column| !is_own(&column.name) && column.values.len() == count);
        let mut list: Vec<(String, ColumnValues)> = read
            .map(|column| {
                let values = match particles.labels.get(&column.name) {
                    Some(texts) => of_texts(&column.values, texts),
                    None => of_numbers(&column.name, &column.values),
                };
                (column.name.clone(), values)
            })
            .collect();
        if has_elements {
            let symbol = |number: u8| element(number).map_or_else(String::new, |element| element.symbol.to_owned());
            list.push((ELEMENT.into(), of_elements(&particles.elements, (0..=u8::MAX).map(symbol).collect())));
        }
        let places = &particles.places;
        let has_places = places.len() == count && parallel::all(places, |place| i32::try_from(*place).is_ok());
        list.push((
            INDEX.into(),
            match has_places {
                true => ColumnValues::Whole(parallel::map(places, |place| *place as i32)),
                false => ColumnValues::Order(count),
            },
        ));
        let is_kept = |name: &String| list.iter().any(|(known, _)| known == name);
        let others = particles.has.iter().filter(|name| !is_kept(name) && !is_own(name)).cloned().collect();
        Ok(Self { list, others })
    }

    /// The columns with these names and values, as many values in each.
    #[must_use]
    pub fn from_list(list: Vec<(String, ColumnValues)>) -> Self {
        Self { list, others: Vec::new() }
    }

    /// The names and the values.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &ColumnValues)> {
        self.list.iter().map(|(name, values)| (name.as_str(), values))
    }

    /// Whether there are no columns.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The names: the file's names in lower case, `element`, and `index` for the number in the file from 0.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.list.iter().map(|(name, _)| name.as_str())
    }

    /// The name and the values of the column that a word of a selection reads: `resid` reads `residue`.
    ///
    /// # Errors
    /// [`Error::Settings`] for a word without a column, with those that there are.
    pub fn get(&self, word: &str) -> Result<(&str, &ColumnValues)> {
        let candidates = candidates(word);
        let is = |name: &str| candidates.iter().any(|candidate| candidate.eq_ignore_ascii_case(name));
        // The first candidate that is there, as in selections.
        let find = |candidate: &String| self.list.iter().find(|(name, _)| name.eq_ignore_ascii_case(candidate));
        if let Some((name, values)) = candidates.iter().find_map(find) {
            return Ok((name, values));
        }
        let problem = match self.others.iter().find(|name| is(name)) {
            Some(name) => return Err(not_kept(name)),
            None if self.is_empty() => format!("there is no column {}: the scene has no columns", quote(word)),
            None => format!("there is no column {}", quote(word)),
        };
        let mend = match word.to_lowercase().as_str() {
            "x" | "y" | "z" => "the coordinates are scene.centers".to_owned(),
            "radius" => "the radii are scene.radii".to_owned(),
            _ if self.is_empty() => "use the scene of a particle file, and keep=True".to_owned(),
            _ => format!("the columns are {}", list(self.names().chain(self.others.iter().map(String::as_str)))),
        };
        Err(Error::settings(problem, mend))
    }

    /// The atomic numbers, 0 for an unknown element and for beads of a cell; empty without elements.
    pub fn elements(&self) -> Vec<u8> {
        match self.list.iter().find(|(name, _)| name == ELEMENT) {
            Some((_, ColumnValues::Texts(codes, _))) => {
                (0..codes.len()).map(|n| u8::try_from(codes.at(n)).unwrap_or(0)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// The spheres that a selection selects, as flags, and the messages about it. These are the columns of the spheres with these centres and radii;
    /// `radius` is the radius of the sphere, and beads of a cell have no values.
    ///
    /// # Errors
    /// [`Error::Settings`] for a selection that these columns do not fit, also for a column that was not kept;
    /// [`Error::Limits`] where memory is short.
    pub fn select(
        &self,
        selection: &Selection,
        centers: &[[f64; 3]],
        radii: &[f64],
    ) -> Result<(Vec<bool>, Vec<String>)> {
        let mut particles = self.particles(centers, radii)?;
        particles.add_lengths(&selection.columns())?;
        let selected = select::mask(selection, &particles);
        let others = &self.others;
        let lost =
            || others.iter().find(|name| selection.columns().iter().any(|known| known.eq_ignore_ascii_case(name)));
        match (selected, lost()) {
            (Err(_), Some(name)) => Err(not_kept(name)),
            (selected, _) => selected,
        }
    }

    /// The spheres as particles with these columns.
    fn particles(&self, centers: &[[f64; 3]], radii: &[f64]) -> Result<Particles> {
        let count = centers.len();
        check((count * (40 + 8 * self.list.len())) as u64, || format!("a selection of {count} spheres"))?;
        let mut particles = Particles { positions: centers.to_vec(), radii: radii.to_vec(), ..Particles::default() };
        for (name, values) in &self.list {
            // Every scene has the number in the file.
            if name != INDEX {
                particles.has.push(name.clone());
            }
            match values {
                // An element's code is its atomic number; beads of a cell have none.
                ColumnValues::Texts(..) if name == ELEMENT => particles.elements = self.elements(),
                _ if name == INDEX => {
                    let place =
                        |n| Some(values.at(n)).filter(|place| !place.is_nan()).map_or(u32::MAX, |place| place as u32);
                    particles.places = parallel::from_fn(count, place);
                }
                _ => {
                    let values = parallel::from_fn(count, |n| values.at(n));
                    particles.columns.push(Column { name: name.clone(), values });
                }
            }
            if let ColumnValues::Texts(_, texts) = values {
                particles.labels.insert(name.clone(), texts.clone());
            }
        }
        Ok(particles)
    }

    /// The columns of spheres that are made of these: each has the values of the sphere with its index in `rows`, and
    /// `extra` spheres after them, which are no particles, have an empty text and NaN.
    ///
    /// # Errors
    /// [`Error::Limits`] where memory is short.
    pub fn rearranged(&self, rows: &[u32], extra: usize) -> Result<Self> {
        let count = rows.len() + extra;
        check((8 * count * self.list.len()) as u64, || format!("the columns of {count} spheres"))?;
        let list = self.list.iter().map(|(name, values)| (name.clone(), values.rearranged(rows, extra))).collect();
        Ok(Self { list, others: self.others.clone() })
    }
}

/// The error for a column of the file that was not kept.
fn not_kept(name: &str) -> Error {
    let problem = format!("the column {} was not kept", quote(name));
    Error::settings(problem, format!("read the file with keep=[{name:?}], or keep=True"))
}

/// A value of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColumnValue<'a> {
    /// A number; NaN where the file has none.
    Number(f64),
    /// A text.
    Text(&'a str),
}

impl ColumnValues {
    /// The value of a sphere.
    ///
    /// # Panics
    /// For a number beyond the last sphere.
    #[must_use]
    pub fn value(&self, n: usize) -> ColumnValue<'_> {
        match self {
            Self::Texts(codes, texts) => ColumnValue::Text(&texts[codes.at(n) as usize]),
            _ => ColumnValue::Number(self.at(n)),
        }
    }

    /// The texts that some sphere has, each once; none of a column of numbers.
    #[must_use]
    pub fn texts(&self) -> Vec<&str> {
        let Self::Texts(codes, texts) = self else { return Vec::new() };
        let mut is_used = vec![false; texts.len()];
        (0..codes.len()).for_each(|n| is_used[codes.at(n) as usize] = true);
        texts.iter().zip(is_used).filter(|(_, is_used)| *is_used).map(|(text, _)| text.as_str()).collect()
    }

    /// The number of a sphere, or the number of its text.
    fn at(&self, n: usize) -> f64 {
        match self {
            Self::Numbers(values) => values[n],
            Self::Whole(values) => values[n].into(),
            Self::Order(_) => n as f64,
            Self::Texts(codes, _) => codes.at(n).into(),
        }
    }

    fn rearranged(&self, rows: &[u32], extra: usize) -> Self {
        let with_nan = |at: &(dyn Fn(u32) -> f64 + Sync)| {
            let value = |n: usize| rows.get(n).map_or(f64::NAN, |row| at(*row));
            Self::Numbers(parallel::from_fn(rows.len() + extra, value))
        };
        match self {
            Self::Numbers(values) => with_nan(&|row| values[row as usize]),
            Self::Whole(values) if extra > 0 => with_nan(&|row| f64::from(values[row as usize])),
            Self::Order(_) if extra > 0 => with_nan(&f64::from),
            Self::Whole(values) => Self::Whole(parallel::map(rows, |row| values[*row as usize])),
            Self::Order(_) => Self::Whole(parallel::map(rows, |row| *row as i32)),
            Self::Texts(codes, texts) => {
                let mut texts = texts.clone();
                let blank = texts.iter().position(String::is_empty).unwrap_or_else(|| {
                    texts.push(String::new());
                    texts.len() - 1
                });
                let at = |row: usize| rows.get(row).map_or(blank as u32, |row| codes.at(*row as usize));
                let codes = Codes::of(rows.len() + extra, texts.len(), at);
                Self::Texts(codes, texts)
            }
        }
    }
}

impl Codes {
    /// The codes of so many spheres, for so many texts.
    fn of(count: usize, texts: usize, at: impl Fn(usize) -> u32 + Sync) -> Self {
        match texts {
            0..=0x100 => Self::U8(parallel::from_fn(count, |n| at(n) as u8)),
            0x101..=0x10000 => Self::U16(parallel::from_fn(count, |n| at(n) as u16)),
            _ => Self::U32(parallel::from_fn(count, at)),
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::U8(codes) => codes.len(),
            Self::U16(codes) => codes.len(),
            Self::U32(codes) => codes.len(),
        }
    }

    fn at(&self, n: usize) -> u32 {
        match self {
            Self::U8(codes) => codes[n].into(),
            Self::U16(codes) => codes[n].into(),
            Self::U32(codes) => codes[n],
        }
    }
}

/// Numbers, as whole ones where the column counts or identifies and they are.
fn of_numbers(name: &str, values: &[f64]) -> ColumnValues {
    let is_whole = |value: &f64| f64::from(*value as i32) == *value;
    match WHOLE.contains(&name) && parallel::all(values, is_whole) {
        true => ColumnValues::Whole(parallel::map(values, |value| *value as i32)),
        false => ColumnValues::Numbers(values.to_vec()),
    }
}

/// Texts by their numbers, without the blanks around them; a number without a text has an empty one.
fn of_texts(values: &[f64], labels: &[String]) -> ColumnValues {
    // Texts that differ in blanks only become one.
    let (mut texts, mut known, mut of) = (Vec::new(), BTreeMap::new(), Vec::with_capacity(labels.len() + 1));
    for label in labels.iter().map(String::as_str).chain([""]) {
        let label = label.trim();
        of.push(*known.entry(label).or_insert_with(|| {
            texts.push(label.to_owned());
            texts.len() as u32 - 1
        }));
    }
    let none = of[labels.len()];
    let at = |n: usize| match values[n] {
        value if value >= 0.0 => of.get(value as usize).copied().unwrap_or(none),
        _ => none,
    };
    let codes = Codes::of(values.len(), texts.len(), at);
    ColumnValues::Texts(codes, texts)
}

/// The elements by their atomic numbers.
fn of_elements(numbers: &[u8], symbols: Vec<String>) -> ColumnValues {
    ColumnValues::Texts(Codes::U8(numbers.to_vec()), symbols)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(name: &str, values: &[f64]) -> Column {
        Column { name: name.into(), values: values.to_vec() }
    }

    fn some() -> Particles {
        Particles {
            positions: vec![[0.0; 3]; 3],
            elements: vec![6, 0, 8],
            columns: vec![
                column("chain", &[1.0, 0.0, 1.0]),
                column("residue", &[-3.0, 5.0, 5.0]),
                column("bfactor", &[1.0, 2.0, 3.0]),
                column("x", &[0.0; 3]),
            ],
            labels: [("chain".to_owned(), vec![" A ".to_owned(), "B".to_owned()])].into(),
            has: ["chain", "residue", "bfactor", "x", "occupancy"].map(str::to_owned).to_vec(),
            ..Particles::default()
        }
    }

    /// The values of a column as texts.
    fn shown(columns: &Columns, word: &str) -> Vec<String> {
        match columns.get(word).expect("a column").1 {
            ColumnValues::Numbers(values) => values.iter().map(|value| format!("{value:?}")).collect(),
            ColumnValues::Whole(values) => values.iter().map(i32::to_string).collect(),
            ColumnValues::Order(count) => (0..*count).map(|n| n.to_string()).collect(),
            ColumnValues::Texts(codes, texts) => {
                let count = match codes {
                    Codes::U8(codes) => codes.len(),
                    Codes::U16(codes) => codes.len(),
                    Codes::U32(codes) => codes.len(),
                };
                (0..count).map(|n| texts[codes.at(n) as usize].clone()).collect()
            }
        }
    }

    #[test]
    fn columns_are_found_by_the_words_of_selections() {
        let columns = Columns::of(&some()).expect("room");
        assert_eq!(columns.names().collect::<Vec<_>>(), ["chain", "residue", "bfactor", "element", "index"]);
        assert_eq!(shown(&columns, "chainid"), ["B", "A", "B"]);
        assert_eq!(shown(&columns, "resid"), ["-3", "5", "5"]);
        assert_eq!(shown(&columns, "beta"), ["1.0", "2.0", "3.0"]);
        assert_eq!(shown(&columns, "element"), ["C", "", "O"]);
        assert_eq!(shown(&columns, "index"), ["0", "1", "2"]);
        let fault = |word: &str| columns.get(word).expect_err(word).to_string();
        assert!(fault("occupancy").contains("keep=[\"occupancy\"]"), "{}", fault("occupancy"));
        assert!(
            fault("chian").contains("the columns are chain, residue, bfactor, element, index, occupancy"),
            "{}",
            fault("chian")
        );
        assert!(fault("x").contains("scene.centers"), "{}", fault("x"));
    }

    #[test]
    fn what_is_left_keeps_its_place_in_the_file() {
        let mut particles = some();
        particles.keep(&[true, false, true]);
        assert_eq!(shown(&Columns::of(&particles).expect("room"), "index"), ["0", "2"]);
    }

    #[test]
    fn copies_have_the_values_of_their_particles_and_beads_have_none() {
        let columns = Columns::of(&some()).expect("room");
        let copied = columns.rearranged(&[2, 0, 2], 0).expect("room");
        assert_eq!(shown(&copied, "chain"), ["B", "B", "B"]);
        assert_eq!(
            (shown(&copied, "residue"), shown(&copied, "index")),
            (shown(&copied, "resnum"), vec!["2".into(), "0".into(), "2".into()])
        );
        let outlined = columns.rearranged(&[1], 2).expect("room");
        assert_eq!(shown(&outlined, "chain"), ["A", "", ""]);
        assert_eq!(shown(&outlined, "residue"), ["5.0", "NaN", "NaN"]);
        assert_eq!(shown(&outlined, "index"), ["1.0", "NaN", "NaN"]);
    }

    #[test]
    fn selections_read_the_columns_of_spheres() {
        let centers: Vec<[f64; 3]> = (0..4).map(|n| [f64::from(n), 0.0, 0.0]).collect();
        // The last sphere is a bead.
        let columns = Columns::of(&some()).expect("room").rearranged(&[0, 1, 2], 1).expect("room");
        for (text, expected) in [
            ("chain B", [true, false, true, false]),
            ("resid 5 and not name CA", [false; 4]),
            ("element C O", [true, false, true, false]),
            ("bfactor > 1.5", [false, true, true, false]),
            ("index 0:1", [true, true, false, false]),
            ("x >= 2", [false, false, true, true]),
            ("within 1 of (index 0)", [true, true, false, false]),
        ] {
            let selection: Selection = text.parse().expect(text);
            match columns.select(&selection, &centers, &[1.0; 4]) {
                Ok((mask, _)) => assert_eq!(mask, expected, "{text}"),
                // The particles have no names.
                Err(error) => {
                    assert!(text.contains("name") && error.to_string().contains("no name"), "{text}: {error}")
                }
            }
        }
        let fault =
            columns.select(&"occupancy < 1".parse().expect("a selection"), &centers, &[1.0; 4]).expect_err("not kept");
        assert!(fault.to_string().contains("was not kept"), "{fault}");
    }

    #[test]
    fn many_texts_have_wider_numbers() {
        let labels: Vec<String> = (0..300).map(|n| n.to_string()).collect();
        let values: Vec<f64> = (0..300).map(f64::from).collect();
        let ColumnValues::Texts(codes, texts) = of_texts(&values, &labels) else { panic!("texts") };
        assert!(matches!(codes, Codes::U16(_)) && texts[codes.at(299) as usize] == "299");
        let ColumnValues::Texts(codes, _) = of_texts(&values[..9], &labels[..9]) else { panic!("texts") };
        assert!(matches!(codes, Codes::U8(_)));
        // Whole numbers too large for 32 bits stay exact in 64.
        assert_eq!(of_numbers("id", &[5e9]), ColumnValues::Numbers(vec![5e9]));
    }
}
