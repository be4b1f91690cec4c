//! Atom styles of LAMMPS: the columns of the section Atoms of data files (docs.lammps.org/read_data.html).

use halfline_ground::error::{Error, Result};
use halfline_ground::quote::quote;
use std::fmt::{self, Display};
use std::str::FromStr;

/// The columns of the Atoms section by style: from the manual, and from `fields_data_atom` for styles that its table lacks. `x y z` are
/// coordinates, `diameter` is a diameter.
const STYLES: [(&str, &str); 31] = [
    ("amoeba", "id mol type q x y z"),
    ("angle", "id mol type x y z"),
    ("apip", "id type x y z"),
    ("atomic", "id type x y z"),
    ("body", "id type bodyflag mass x y z"),
    ("bond", "id mol type x y z"),
    ("bpm/sphere", "id mol type diameter density x y z"),
    ("charge", "id type q x y z"),
    ("dielectric", "id type q x y z normx normy normz area ed em epsilon curvature"),
    ("dipole", "id type q x y z mux muy muz"),
    ("dpd", "id type theta x y z"),
    ("edpd", "id type edpd_temp edpd_cv x y z"),
    ("electron", "id type q espin eradius x y z"),
    ("ellipsoid", "id type ellipsoidflag density x y z"),
    ("full", "id mol type q x y z"),
    ("line", "id mol type lineflag density x y z"),
    ("mdpd", "id type rho x y z"),
    ("mesont", "id mol type bond_nt mass mradius mlength buckling x y z"),
    ("molecular", "id mol type x y z"),
    ("oxdna", "id type x y z"),
    ("peri", "id type volume density x y z"),
    ("rheo", "id type status rho x y z"),
    ("rheo/thermal", "id type status rho energy x y z"),
    ("smd", "id type mol volume mass kradius cradius x0 y0 z0 x y z"),
    ("sph", "id type rho esph cv x y z"),
    ("sphere", "id type diameter density x y z"),
    ("spin", "id type x y z spx spy spz sp"),
    ("tdpd", "id type x y z"),
    ("template", "id type mol template atom x y z"),
    ("tri", "id mol type triangleflag density x y z"),
    ("wavepacket", "id type q espin eradius etag cs_re cs_im x y z"),
];

/// The columns that the sub-styles of `hybrid` follow.
const HYBRID: &str = "id type x y z";

/// An atom style of LAMMPS data, for files that do not say theirs: a style (`full`), `hybrid` with its sub-styles in the order of
/// LAMMPS's input (`hybrid charge sphere`), or the columns themselves (`id type q x y z`).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AtomStyle {
    name: String,
    columns: String,
}

impl AtomStyle {
    /// The style that the comment behind `Atoms` begins with; `None` for another comment.
    pub(super) fn of_comment(comment: &str) -> Option<Self> {
        let words: Vec<&str> = comment.split_whitespace().collect();
        let known = match words.first()? {
            word if plain(word) == "hybrid" => {
                1 + words[1..].iter().take_while(|word| columns_of(word).is_some()).count()
            }
            _ => 1,
        };
        Self::of_words(&words[..known])
    }

    /// Whether a comment behind `Atoms` is one word, as the name of a style is: LAMMPS writes it there.
    pub(super) fn is_named_by(comment: &str) -> bool {
        comment.split_whitespace().count() == 1 && comment.chars().any(char::is_alphabetic)
    }

    /// The style with these words; `None` for words that name no style.
    fn of_words(words: &[&str]) -> Option<Self> {
        let name = words.iter().map(|word| plain(word)).collect::<Vec<_>>().join(" ");
        match words {
            [word] if plain(word) != "hybrid" => {
                columns_of(word).map(|columns| Self { name, columns: columns.to_owned() })
            }
            [first, parts @ ..] if plain(first) == "hybrid" => {
                let mut columns: Vec<&str> = HYBRID.split(' ').collect();
                for part in parts {
                    // A value that several sub-styles have is written once.
                    let own =
                        columns_of(part)?.split(' ').filter(|column| !columns.contains(column)).collect::<Vec<_>>();
                    columns.extend(own);
                }
                Some(Self { name, columns: columns.join(" ") })
            }
            _ => None,
        }
    }

    /// Whether more columns than these may follow, in any number.
    pub(super) fn is_open(&self) -> bool {
        self.name == "hybrid" || self.name.split(' ').any(|style| style == "tdpd")
    }

    /// The names of the columns, in their order.
    pub(super) fn columns(&self) -> impl Iterator<Item = &str> {
        self.columns.split(' ')
    }

    /// The same with blanks between them.
    pub(super) fn list(&self) -> &str {
        &self.columns
    }

    /// The names of all styles.
    pub(super) fn names() -> String {
        STYLES.map(|(name, _)| name).join(", ")
    }
}

impl Display for AtomStyle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

impl FromStr for AtomStyle {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let words: Vec<&str> = text.split([' ', ',']).filter(|word| !word.is_empty()).collect();
        let has = |column: &str| words.iter().filter(|word| **word == column).count() == 1;
        if ["id", "type", "x", "y", "z"].into_iter().all(has) && words[0] == "id" {
            return Ok(Self { name: words.join(" "), columns: words.join(" ") });
        }
        Self::of_words(&words).ok_or_else(|| {
            let mend = format!(
                "use one of {}, hybrid with its sub-styles, or the columns, such as `id type q x y z`",
                Self::names()
            );
            Error::settings(format!("{} is no atom style of LAMMPS", quote(text)), mend)
        })
    }
}

/// A style without the suffix of accelerators.
fn plain(word: &str) -> &str {
    word.split_once('/').filter(|(_, suffix)| *suffix == "kk").map_or(word, |(style, _)| style)
}

/// The columns of a style.
fn columns_of(word: &str) -> Option<&'static str> {
    STYLES.iter().find(|(name, _)| *name == plain(word)).map(|(_, columns)| *columns)
}
