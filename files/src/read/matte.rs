//! The names of spheres in a Cryptomatte layer, and of the paths of a figure: their numbers, or the values of columns.

use super::sequence::SceneFrame;
use halfline::error::{Error, Result};
use halfline::quote::setting::{CRYPTOMATTE, GROUP};
use halfline::quote::{list, quote};
use halfline_particles::{ColumnValue, Columns};
use std::sync::Arc;

/// The words of selections for the columns that tell residues apart, in the order of their names; words of one part of the
/// name together.
const RESIDUE: [&[&str]; 4] = [&["chain"], &["segid"], &["resname"], &["resid", "icode"]];

/// The columns whose values the paths of a figure have, where a file has them.
const KNOWN: [&str; 4] = ["name", "element", "residue", "chain"];

/// The name of a sphere whose column has no text.
const BLANK: &str = "(blank)";

/// The names of the spheres of a scene in one layer.
#[derive(Debug, Clone, PartialEq)]
pub struct MatteNames {
    layer: String,
    naming: Naming,
    columns: Arc<Columns>,
    /// The number of spheres that are particles; beads of a cell follow.
    particles: usize,
}

#[derive(Debug, Clone, PartialEq)]
enum Naming {
    /// The number of the sphere in the buffer of ids.
    Id,
    /// The columns of each part of the residue's name.
    Residue(Vec<Vec<String>>),
    /// The value of a column.
    Column(String),
}

impl MatteNames {
    /// The names by a word: `id`, `residue`, or a column.
    ///
    /// # Errors
    /// [`Error::Settings`] for a column that is not there.
    fn of(setting: &str, word: &str, columns: &Arc<Columns>, particles: usize) -> Result<Self> {
        let name = |word: &str| columns.get(word).map(|(name, _)| name.to_owned());
        let known = |word: &str| {
            name(word).map_err(|_| {
                let problem = format!("{setting} names spheres by {}, and there is no such column", quote(word));
                Error::settings(problem, format!("use id, or a column: {}", list(columns.names())))
            })
        };
        let naming = match word.to_lowercase().as_str() {
            "id" => Naming::Id,
            "residue" => {
                known("resid")?;
                let part = |words: &&[&str]| words.iter().filter_map(|word| name(word).ok()).collect();
                Naming::Residue(RESIDUE.iter().map(part).collect())
            }
            word => Naming::Column(known(word)?),
        };
        Ok(Self { layer: layer(&word.to_lowercase()), naming, columns: Arc::clone(columns), particles })
    }

    /// The name of the layer, such as `CryptoChain`.
    #[must_use]
    pub fn layer(&self) -> &str {
        &self.layer
    }

    /// The name of a sphere.
    #[must_use]
    pub fn name(&self, id: u32) -> String {
        let n = id as usize;
        let name = match &self.naming {
            Naming::Id => return id.to_string(),
            _ if n >= self.particles => return "cell".into(),
            Naming::Column(word) => self.value(word, n),
            Naming::Residue(parts) => {
                let part = |words: &Vec<String>| words.iter().map(|word| self.value(word, n)).collect::<String>();
                let mut parts: Vec<String> = parts.iter().map(part).collect();
                // The segment of most mmCIF files is its chain.
                if parts[0] == parts[1] {
                    parts.remove(1);
                }
                parts.retain(|part| !part.is_empty());
                parts.join("/")
            }
        };
        if name.is_empty() { BLANK.into() } else { name }
    }

    /// The value of a column as text: the shortest number that is read back as the same.
    fn value(&self, column: &str, n: usize) -> String {
        let found = self.columns.iter().find(|(name, _)| *name == column);
        match found.map(|(_, values)| values.value(n)) {
            Some(ColumnValue::Text(text)) => text.to_owned(),
            Some(ColumnValue::Number(x)) if x == x.trunc() && x.abs() < 1e15 => format!("{x:.0}"),
            Some(ColumnValue::Number(x)) => format!("{x:?}"),
            None => String::new(),
        }
    }

    /// A digest of the names of all spheres, for provenance: 16 hexadecimal digits of BLAKE3.
    #[must_use]
    pub fn digest(&self, spheres: u64) -> String {
        let mut hash = blake3::Hasher::new();
        if self.naming == Naming::Id {
            hash.update(b"id");
        } else {
            (0..spheres as u32).for_each(|id| _ = hash.update(self.name(id).as_bytes()).update(&[0]));
        }
        hash.finalize().to_hex()[..16].to_owned()
    }
}

impl SceneFrame {
    /// The names of the spheres in Cryptomatte layers, by a word for each: `id`, `residue`, or a column.
    ///
    /// # Errors
    /// [`Error::Settings`] for a column that is not there, and for two layers of one name.
    pub fn matte_names(&self, words: &[String]) -> Result<Vec<MatteNames>> {
        let particles = self.scene.spheres.len() - self.beads;
        let all = words
            .iter()
            .map(|word| MatteNames::of(CRYPTOMATTE, word, &self.columns, particles))
            .collect::<Result<Vec<_>>>()?;
        for (n, names) in all.iter().enumerate() {
            if all[..n].iter().any(|other| other.layer == names.layer) {
                let problem = format!("two layers of {CRYPTOMATTE} are {}", quote(&names.layer));
                return Err(Error::settings(problem, format!("give {CRYPTOMATTE} each column once")));
            }
        }
        Ok(all)
    }

    /// The names of the spheres by the columns of the groups of a figure, and then by the name, the element, the residue and the chain that the
    /// file has: words and names.
    ///
    /// # Errors
    /// [`Error::Settings`] for a column of a group that is not there.
    pub fn path_names(&self, groups: &[String]) -> Result<Vec<(String, MatteNames)>> {
        let particles = self.scene.spheres.len() - self.beads;
        let names = |word: &str| Ok((word.to_lowercase(), MatteNames::of(GROUP, word, &self.columns, particles)?));
        let mut all = groups.iter().map(|word| names(word)).collect::<Result<Vec<_>>>()?;
        all.extend(
            KNOWN
                .iter()
                .filter(|word| !groups.iter().any(|group| group.eq_ignore_ascii_case(word)))
                .filter_map(|word| names(word).ok()),
        );
        Ok(all)
    }
}

/// The name of the layer of a word: letters and digits alone, so that compositors can use it in channels.
fn layer(word: &str) -> String {
    let plain: String = word.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let (first, rest) = plain.split_at(plain.len().min(1));
    format!("Crypto{}{}", first.to_ascii_uppercase(), rest)
}
