//! The distances at which atoms are joined: by a bond, or by touching a protein or nucleic acid.

use crate::elements::element;
use crate::particles::frame::Particles;
use crate::particles::infer::residues::{ResidueClass, class};
use halfline_ground::parallel::{self, CHEAP};

/// The longest bond, in sums of covalent radii. Vibrations stretch bonds by less; the closest atoms without a bond are the
/// ends of a hydrogen bond, 1.5 times their sum apart.
const LONGEST: f32 = 1.2;

/// Half the distance within which two atoms other than hydrogen touch, ångström: a little more than their van der Waals radii.
const TOUCH: f32 = 2.25;

/// Alkali and alkaline earth metals: ions among what surrounds them, not atoms of its molecules.
const IONS: [u8; 10] = [3, 11, 12, 19, 20, 37, 38, 55, 56, 88];

/// The reach of each atom, ångström: two atoms are joined if they are at most the sum of their reaches apart.
pub(super) struct Atoms {
    /// Reach of a bond; 0 for ions, unknown elements and water, which is whole by its residue.
    pub(super) bonds: Vec<f32>,
    /// Reach of a contact; 0 for hydrogen, and for residues of a known class, such as water, other than protein and
    /// nucleic acid. Empty where nothing is a protein or nucleic acid.
    pub(super) contacts: Vec<f32>,
    /// Whether each atom is of a protein or a nucleic acid.
    are_polymers: Vec<bool>,
    /// Whether any element is known.
    pub(super) has_elements: bool,
}

impl Atoms {
    pub(super) fn of(particles: &Particles) -> Self {
        let elements = &particles.elements;
        let covalent = |number: u8| element(number).and_then(|element| element.covalent);
        let has_elements = !parallel::all(elements, |number| covalent(*number).is_none());
        let reach = |number: u8| {
            let radius = covalent(number).filter(|_| !IONS.contains(&number));
            radius.map_or(0.0, |radius| LONGEST * radius as f32)
        };
        let table: Vec<f32> = (0..=u8::MAX).map(reach).collect();
        let classes = classes(particles);
        let is = |n: usize, class: ResidueClass| classes.get(n).is_some_and(|found| *found == Some(class));
        let bond = |n: usize| if is(n, ResidueClass::Water) { 0.0 } else { table[usize::from(elements[n])] };
        let is_polymer = |n: usize| is(n, ResidueClass::Protein) || is(n, ResidueClass::Nucleic);
        let are_polymers = parallel::from_fn(elements.len(), is_polymer);
        let contact = |n: usize| {
            let touches = elements[n] > 1 && (are_polymers[n] || classes.get(n) == Some(&None));
            if touches { TOUCH } else { 0.0 }
        };
        let is_without = parallel::all(&are_polymers, |is_polymer| !is_polymer);
        let contacts = if is_without { Vec::new() } else { parallel::from_fn(elements.len(), contact) };
        Self { bonds: parallel::from_fn(elements.len(), bond), contacts, are_polymers, has_elements }
    }

    /// Whether two atoms that touch are joined.
    pub(super) fn may_touch(&self, a: usize, b: usize) -> bool {
        self.are_polymers[a] || self.are_polymers[b]
    }
}

/// The class of each particle's residue; empty where the file has no names of residues.
fn classes(particles: &Particles) -> Vec<Option<ResidueClass>> {
    let column = particles.columns.iter().find(|column| column.name == "resname");
    let Some((column, names)) = column.and_then(|column| Some((column, particles.labels.get(&column.name)?))) else {
        return Vec::new();
    };
    let of = |name: &String| class(name.trim().to_ascii_uppercase().as_bytes());
    let known: Vec<_> = names.iter().map(of).collect();
    parallel::values(column.values.len(), CHEAP, |n| known.get(column.values[n] as usize).copied().flatten())
}
