//! Common parts of PDB, mmCIF and GRO: which atoms of a model are read, what is stored of them, and what is reported.

use super::assembly::{self, Assembly};
use super::atom_property::AtomProperty;
use super::frame::{Column, Particles};
use super::infer::{self, AtomNames, Inference, is_site};
use super::layout::named;
use super::request::{Altloc, Request};
use super::survey::Survey;
use halfline_ground::Cell;
use halfline_ground::check::keep;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::{Ledger, reserve};
use halfline_ground::progress::Watch;
use halfline_ground::quote::setting::{ALTLOC, ASSEMBLY, FRAMES, MODEL};
use halfline_ground::quote::{count, quote, unquoted};
use std::collections::HashMap;

/// The copies to make of the atoms of a model.
pub(crate) enum Copies<'a> {
    None,
    Assembly(&'a Assembly),
    /// Copies that the reader of the format makes: a crystal's symmetry.
    Made(&'a dyn Fn(Particles) -> Result<Particles>),
}

/// The numbers of skipped models: the first of them, and their count.
#[derive(Debug, Default)]
pub(crate) struct Passed {
    first: Vec<i64>,
    count: usize,
}

/// The most models that an error lists.
const LISTED: usize = 16;

impl Passed {
    pub(crate) fn push(&mut self, number: i64) {
        if self.count < LISTED {
            self.first.push(number);
        }
        self.count += 1;
    }

    /// The error for a model that `file` does not have.
    pub(crate) fn no_model(&self, number: i64, file: &Place) -> Error {
        let mut listed: Vec<String> = self.first.iter().map(i64::to_string).collect();
        if self.count > LISTED {
            listed.push(format!("{} more", self.count - LISTED));
        }
        let mend = if listed.is_empty() {
            "the file has no atoms".into()
        } else {
            format!("the file has {}", listed.join(", "))
        };
        Error::settings(format!("{file}: there is no model {number}"), mend)
    }
}

/// Bytes per site with several locations, besides its key, in a map while it grows.
const SITE: usize = 160;

/// The name of atoms without a position in the report of skipped items.
const UNPLACED: &str = "site without coordinates";

/// A model while it is read.
pub(crate) struct Model {
    particles: Particles,
    altloc: Altloc,
    /// The property in each column of the particles, in their order.
    kinds: Vec<AtomProperty>,
    /// The chain of every atom, stored for an assembly.
    chains: Option<Vec<u32>>,
    /// For [`Altloc::Highest`]: by atom with several locations, the index and the occupancy of the chosen one.
    best: HashMap<Vec<u8>, (usize, f64)>,
    beaten: Vec<usize>,
    /// Bytes of both.
    ledger: Ledger,
    as_operators: bool,
    watch: Watch,
    /// Inference of elements that the file does not give.
    inference: Inference,
    /// The survey that counts the atoms part by part and drops them; `None` keeps all until the end.
    survey: Option<Survey>,
    /// The number of atoms, and of those that are alternate locations.
    met: u64,
    alternates: u64,
    /// The first alternate location's identifier, and whether the selected one occurs.
    first: String,
    found: bool,
}

impl Model {
    /// An empty model; `has` are the columns of the file, and `inference` finds elements that it does not give.
    pub(crate) fn new(request: &Request, has: &[AtomProperty], inference: Inference) -> Self {
        let requested = named(&request.columns, &AtomProperty::ALL);
        let copy = request.assembly.is_some();
        let there = |kind: AtomProperty| has.contains(&kind) || copy && kind == AtomProperty::Copy;
        let names = AtomProperty::ALL.iter().filter(|(_, kind)| there(*kind)).map(|(name, _)| (*name).to_owned());
        let texts = requested.iter().filter(|kind| kind.is_text()).map(|kind| (kind.name().to_owned(), Vec::new()));
        let kinds: Vec<AtomProperty> = requested.iter().filter(|kind| there(**kind)).copied().collect();
        let columns = kinds.iter().map(|kind| Column { name: kind.name().to_owned(), values: Vec::new() });
        let columns = columns.collect();
        Self {
            // The names of these columns follow at the end of the model.
            particles: Particles { has: names.collect(), labels: texts.collect(), columns, ..Particles::default() },
            altloc: request.altloc.clone(),
            kinds,
            chains: request.assembly.is_some().then(Vec::new),
            best: HashMap::new(),
            beaten: Vec::new(),
            ledger: Ledger::default(),
            as_operators: request.as_operators,
            watch: request.watch.clone(),
            inference,
            // Copies are made of all atoms, and the highest occupancy is over all alternatives.
            survey: request.survey.clone().filter(|_| !copy && request.altloc != Altloc::Highest),
            met: 0,
            alternates: 0,
            first: String::new(),
            found: false,
        }
    }

    /// Keeps all atoms until the end, since copies of them are made.
    pub(crate) fn whole(self) -> Self {
        Self { survey: None, ..self }
    }

    /// Counts an atom without a position.
    ///
    /// # Errors
    /// [`Error::Scene`] where it is `strict`.
    pub(crate) fn unplaced(&mut self, strict: bool, place: impl FnOnce() -> Place) -> Result<()> {
        self.particles.skipped.skip(UNPLACED, strict, place)
    }

    /// Refuses a model of atoms without a position alone.
    ///
    /// # Errors
    /// [`Error::Scene`] for such a model.
    pub(crate) fn check_placed(&self, file: &Place) -> Result<()> {
        match self.particles.skipped.kinds.iter().find(|(kind, _)| *kind == UNPLACED) {
            Some((_, unplaced)) if self.met == 0 => {
                let problem = format!("{} without coordinates, and none with them", count(*unplaced, "atom"));
                Err(Error::scene(file.clone(), problem, "use a file with coordinates"))
            }
            _ => Ok(()),
        }
    }

    /// Whether an atom at an alternate location (empty if it has only one) is read. `site` writes what its alternatives
    /// have in common.
    ///
    /// # Errors
    /// [`Error::Limits`] where memory is short.
    pub(crate) fn admits(&mut self, location: &[u8], occupancy: f64, site: impl FnOnce(&mut Vec<u8>)) -> Result<bool> {
        self.met += 1;
        if location.is_empty() {
            return Ok(true);
        }
        self.alternates += 1;
        if self.first.is_empty() {
            self.first = String::from_utf8_lossy(location).into_owned();
        }
        match &self.altloc {
            Altloc::All => Ok(true),
            Altloc::Named(name) => {
                let same = name.as_bytes() == location;
                self.found |= same;
                Ok(same)
            }
            Altloc::Highest => {
                let mut key = Vec::new();
                site(&mut key);
                let here = self.particles.positions.len();
                let Some(best) = self.best.get_mut(&key) else {
                    self.ledger.add(SITE + key.len())?;
                    self.best.insert(key, (here, occupancy));
                    return Ok(true);
                };
                let more = occupancy > best.1;
                if more {
                    self.ledger.add(2 * size_of::<usize>())?;
                    self.beaten.push(best.0);
                    *best = (here, occupancy);
                }
                Ok(more)
            }
        }
    }

    /// Adds an atom: its names, its position, and its numbers by kind.
    ///
    /// # Errors
    /// As [`Particles::grow`], and errors of `value`.
    pub(crate) fn push(
        &mut self,
        atom: &AtomNames<'_>,
        position: [f64; 3],
        chain: u32,
        mut value: impl FnMut(AtomProperty) -> Result<f64>,
    ) -> Result<()> {
        if let Some(survey) = &self.survey
            && survey.is_full(self.particles.positions.len())
            && self.inference.decides_before(atom)
        {
            self.particles.count_part(&mut self.inference, survey);
        }
        self.particles.grow(1, size_of::<u32>() + infer::BYTES)?;
        self.inference.push(atom, &mut self.particles.elements);
        self.particles.positions.push(position);
        if let Some(chains) = &mut self.chains {
            reserve(chains, 1)?;
            chains.push(chain);
        }
        for (kind, column) in self.kinds.iter().zip(&mut self.particles.columns) {
            column.values.push(value(*kind)?);
        }
        Ok(())
    }

    /// Sets the radius of the last atom; NaN where the file gives none. Either all atoms of a model have one or none.
    pub(crate) fn radius(&mut self, radius: f64) {
        self.particles.radii.push(radius);
    }

    /// The particles with their copies; in an assembly chains are indices of `names`.
    ///
    /// # Errors
    /// As [`assembly::build`], and errors of `copies`.
    pub(crate) fn finish(mut self, copies: Copies<'_>, names: &[Vec<u8>], file: &Place) -> Result<Particles> {
        if self.survey.is_some() {
            let messages = self.particles.infer(std::mem::take(&mut self.inference), self.survey.as_ref());
            self.particles.skipped.assumed.extend(messages);
            self.particles.skipped.assumed.extend(self.alternates());
            return Ok(self.particles);
        }
        let read = self.particles.elements.len() as u64;
        let inferred = std::mem::take(&mut self.inference).finish(&mut self.particles.elements);
        if !self.beaten.is_empty() || inferred.sites() > 0 {
            let mut stays: Vec<bool> = self.particles.elements.iter().map(|code| !is_site(*code)).collect();
            self.beaten.iter().for_each(|n| stays[*n] = false);
            self.particles.keep(&stays);
            self.chains.iter_mut().for_each(|chains| keep(chains, &stays));
        }
        self.particles = match (copies, &self.chains) {
            (Copies::Assembly(assembly), Some(chains)) if self.as_operators => {
                assembly::keep_operators(assembly, self.particles, chains, names, file)?
            }
            (Copies::Assembly(assembly), Some(chains)) => {
                assembly::build(assembly, self.particles, chains, names, file, &self.watch)?
            }
            (Copies::Made(make), _) => make(self.particles)?,
            _ => self.particles,
        };
        self.particles.skipped.assumed.extend(inferred.sentences(read));
        self.particles.count_unknown_atoms(&inferred);
        self.particles.skipped.assumed.extend(self.alternates());
        Ok(self.particles)
    }

    /// The warning where all alternate locations are shown, or none of them; else `None`.
    fn alternates(&self) -> Option<String> {
        let of = format!("{} of {} atoms are alternate locations", self.alternates, self.met);
        let note = match &self.altloc {
            Altloc::All => {
                format!("{of} and all are shown; use {ALTLOC} highest or {} to show one", unquoted(&self.first))
            }
            Altloc::Named(name) if !self.found => {
                format!(
                    "{of}, but none of them has the identifier {}, so none is shown; use {ALTLOC} {} to show some",
                    quote(name),
                    unquoted(&self.first)
                )
            }
            _ => String::new(),
        };
        (self.alternates > 0 && !note.is_empty()).then_some(note)
    }
}

/// The warning about more models than the one that is shown, with their number if it is known.
pub(crate) fn more_models(count: Option<u64>) -> String {
    match count {
        Some(n) => {
            format!("the file has {n} models and the first is shown; use {MODEL} N or {FRAMES} 1-{n} to show others")
        }
        None => {
            format!(
                "the file has more than one model and the first is shown; use {MODEL} N or {FRAMES} 1- to show others"
            )
        }
    }
}

/// The warning about assemblies that are not built; `None` where they equal the atoms of the file.
pub(crate) fn not_assembled(assemblies: impl Iterator<Item = (String, u64)>) -> Option<String> {
    let several = assemblies.into_iter().find(|(_, operators)| *operators > 1);
    several.map(|(id, operators)| {
        format!(
            "the atoms are shown as in the file, not the biological assembly of {operators} copies; use {ASSEMBLY} {} to build it",
            unquoted(&id)
        )
    })
}

/// The cell with these edges, ångström, and angles between them (b and c, a and c, a and b), degrees: a along x, b in
/// the xy plane (wwPDB format 3.3, SCALEn). `None` for a cell without volume, and for the unit cube, which means "no
/// crystal".
pub(crate) fn cell([a, b, c]: [f64; 3], angles: [f64; 3]) -> Option<Cell> {
    let cosine = |degrees: f64| if degrees == 90.0 { 0.0 } else { degrees.to_radians().cos() };
    let [alpha, beta, gamma] = angles.map(cosine);
    let sine = (1.0 - gamma * gamma).sqrt();
    let x = (alpha - beta * gamma) / sine;
    let height = (1.0 - beta * beta - x * x).sqrt();
    let edges = [[a, 0.0, 0.0], [b * gamma, b * sine, 0.0], [c * beta, c * x, c * height]];
    let encloses = [a, b, c, sine, height].iter().all(|length| *length > 0.0 && length.is_finite());
    (encloses && [a, b, c] != [1.0; 3]).then_some(Cell { origin: [0.0; 3], edges })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_have_their_lengths_and_angles() {
        let (lengths, angles) = ([10.0, 20.0, 30.0], [70.0, 80.0, 100.0]);
        let edges = cell(lengths, angles).expect("a cell").edges;
        let dot = |i: usize, j: usize| (0..3).map(|k| edges[i][k] * edges[j][k]).sum::<f64>();
        for (n, (i, j)) in [(1, 2), (0, 2), (0, 1)].into_iter().enumerate() {
            let expected = lengths[i] * lengths[j] * f64::to_radians(angles[n]).cos();
            // A dozen roundings of numbers below 900.
            assert!((dot(i, j) - expected).abs() < 1e-11, "{i} {j}");
            assert!((dot(n, n).sqrt() - lengths[n]).abs() < 1e-13, "{n}");
        }
        assert_eq!(cell([2.0, 3.0, 4.0], [90.0; 3]).expect("a box").edges[2], [0.0, 0.0, 4.0]);
        for (lengths, angles) in
            [([1.0; 3], [90.0; 3]), ([0.0; 3], [90.0; 3]), ([5.0; 3], [0.0; 3]), ([5.0; 3], [170.0; 3])]
        {
            assert_eq!(cell(lengths, angles), None, "{lengths:?} {angles:?}");
        }
    }

    #[test]
    fn unknown_names_are_counted_after_selection() {
        let request = Request { altloc: Altloc::Highest, ..Request::default() };
        let mut model = Model::new(&request, &[], Inference::new(false));
        for (location, occupancy, name) in
            [("A", 0.4, "X1"), ("B", 0.6, "X2"), ("", 1.0, "MW"), ("C", 0.6, "X3"), ("", 1.0, "X1")]
        {
            if model.admits(location.as_bytes(), occupancy, |key| key.extend(b"same")).expect("room") {
                let atom = AtomNames { symbol: b"", name: name.as_bytes(), residue: b"LIG", site: b"" };
                model.push(&atom, [occupancy, 0.0, 0.0], 0, |_| Ok(0.0)).expect("room");
            }
        }
        let particles = model.finish(Copies::None, &[], &Place::default()).expect("particles");
        assert_eq!(particles.positions, [[0.6, 0.0, 0.0], [1.0, 0.0, 0.0]], "the first of the highest");
        assert_eq!((particles.unknown["X1"], particles.unknown["X2"], particles.unknown.get("X3")), (1, 1, None));
        assert_eq!(particles.elements, [0, 0]);
        let assumed = &particles.skipped.assumed;
        assert!(assumed.iter().any(|warning| warning.starts_with("1 virtual site left out (1 `MW`)")), "{assumed:?}");
    }
}
