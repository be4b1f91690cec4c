//! Where a scene comes from: a file or standard input, compressed or not, in a format that its content tells.

use super::particles::axes;
use super::{ending, nff};
use crate::error::{Error, Place, Result};
use bzip2::bufread::MultiBzDecoder;
use flate2::bufread::MultiGzDecoder;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The formats that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// The native scene file, TOML.
    Native,
    /// Haines' Neutral File Format.
    Nff,
    /// XYZ and extended XYZ.
    Xyz,
    /// Protein Data Bank.
    Pdb,
    /// Macromolecular CIF.
    Mmcif,
    /// GROMACS coordinates.
    Gro,
    /// LAMMPS dump.
    Dump,
    /// LAMMPS data.
    Data,
    /// Points of a Stanford polygon file.
    Ply,
    /// Comma- or space-separated values with named columns.
    Csv,
    /// A NumPy array.
    Npy,
    /// Named NumPy arrays.
    Npz,
}

impl Format {
    /// All of them.
    pub const ALL: &'static [Self] = &[
        Self::Native,
        Self::Nff,
        Self::Xyz,
        Self::Pdb,
        Self::Mmcif,
        Self::Gro,
        Self::Dump,
        Self::Data,
        Self::Ply,
        Self::Csv,
        Self::Npy,
        Self::Npz,
    ];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.endings()[0]
    }

    /// The endings of its files; the first is its name.
    fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Native => &["toml"],
            Self::Nff => &["nff"],
            Self::Xyz => &["xyz", "extxyz"],
            Self::Pdb => &["pdb", "ent"],
            Self::Mmcif => &["cif", "mmcif"],
            Self::Gro => &["gro"],
            Self::Dump => &["dump", "lammpstrj"],
            Self::Data => &["data", "lammps"],
            Self::Ply => &["ply"],
            Self::Csv => &["csv", "tsv"],
            Self::Npy => &["npy"],
            Self::Npz => &["npz"],
        }
    }

    /// By the name of a file without what it was compressed by.
    fn of_name(path: &Path) -> Option<Self> {
        let ending = ending(path);
        Self::ALL.iter().copied().find(|format| format.endings().contains(&ending.as_str()))
    }

    /// By how a file begins.
    fn of_content(start: &[u8]) -> Option<Self> {
        if start.starts_with(b"\x93NUMPY") {
            return Some(Self::Npy);
        }
        if start.starts_with(b"PK\x03\x04") {
            return Some(Self::Npz);
        }
        let text = String::from_utf8_lossy(start);
        let lines: Vec<&str> = text.trim_start_matches('\u{feff}').lines().take(64).collect();
        let signs: [(Self, Sign); 9] = [
            (Self::Ply, |lines| lines.first().is_some_and(|line| line.trim_end() == "ply")),
            (Self::Dump, |lines| lines.first().is_some_and(|line| line.starts_with("ITEM:"))),
            (Self::Mmcif, is_mmcif),
            (Self::Pdb, is_pdb),
            (Self::Gro, is_gro),
            (Self::Xyz, is_xyz),
            (Self::Nff, is_nff),
            (Self::Data, is_data),
            (Self::Csv, is_csv),
        ];
        signs.into_iter().find(|(_, sign)| sign(&lines)).map(|(format, _)| format)
    }
}

/// Whether lines are those of a format.
type Sign = fn(&[&str]) -> bool;

impl FromStr for Format {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self> {
        crate::error::by_name("format", name, Self::ALL, Self::name)
    }
}

/// Lines that say something: neither blank nor a comment.
fn said<'a>(lines: &'a [&'a str]) -> impl Iterator<Item = &'a str> {
    lines.iter().map(|line| line.trim()).filter(|line| !line.is_empty() && !line.starts_with('#'))
}

fn numbers(words: &str) -> usize {
    words.split_whitespace().take_while(|word| word.parse::<f64>().is_ok()).count()
}

fn is_mmcif(lines: &[&str]) -> bool {
    said(lines).next().is_some_and(|line| {
        let word = line.split_whitespace().next().unwrap_or_default();
        word.len() > 5 && word.to_ascii_lowercase().starts_with("data_") && !word.contains('=')
            || line.eq_ignore_ascii_case("loop_")
            || word.starts_with("_atom_site.")
    })
}

/// The records that a PDB file may begin with.
const RECORDS: [&str; 12] =
    ["HEADER", "OBSLTE", "TITLE", "SPLIT", "CAVEAT", "COMPND", "REMARK", "CRYST1", "MODEL", "ATOM", "HETATM", "AUTHOR"];

fn is_pdb(lines: &[&str]) -> bool {
    let record = |line: &str| RECORDS.contains(&line.get(..6).unwrap_or(line).trim_end());
    lines.iter().find(|line| !line.trim().is_empty()).is_some_and(|line| record(line))
}

/// A title, a count, and atoms whose number stands in columns 16 to 20, before coordinates with a point.
fn is_gro(lines: &[&str]) -> bool {
    let [_, count, atom, ..] = lines else { return false };
    let whole = |text: Option<&str>| text.is_some_and(|text| text.trim().parse::<i64>().is_ok());
    whole(Some(count))
        && whole(atom.get(..5))
        && whole(atom.get(15..20))
        && atom.get(20..).is_some_and(|rest| numbers(rest) >= 3 && rest.contains('.'))
}

/// A count, a comment, and lines of a word or a number and three numbers.
fn is_xyz(lines: &[&str]) -> bool {
    let Some(count) = lines.first().and_then(|line| line.trim().parse::<u64>().ok()) else { return false };
    match lines.get(2) {
        None => count == 0,
        Some(atom) => atom.split_whitespace().count() >= 4 || lines[1].contains("Properties="),
    }
}

fn is_nff(lines: &[&str]) -> bool {
    said(lines).next().is_some_and(|line| {
        let mut words = line.split_whitespace().take_while(|word| !word.starts_with('#'));
        let directive = words.next().is_some_and(|word| nff::DIRECTIVES.contains(&word));
        directive && words.all(|word| word.parse::<f64>().is_ok())
    })
}

/// A title, and soon after it `N atoms`.
fn is_data(lines: &[&str]) -> bool {
    lines.iter().skip(1).take(32).any(|line| {
        let mut words = line.split_whitespace();
        words.next().is_some_and(|n| n.parse::<u64>().is_ok()) && words.next() == Some("atoms")
    })
}

/// A header that names x, y and z, which may be a comment or follow some.
fn is_csv(lines: &[&str]) -> bool {
    let mut before = true;
    let first = |line: &&&str| std::mem::replace(&mut before, line.trim().is_empty() || line.trim().starts_with('#'));
    lines.iter().take_while(first).any(|line| {
        let header = line.trim().trim_start_matches('#').trim();
        let names = |delimiters: &[char]| -> Vec<String> {
            header.split(delimiters).map(|name| name.trim().trim_matches('"').to_owned()).collect()
        };
        // `x (km)` is one name where commas separate, and two where spaces do.
        [&[',', ';', '\t'][..], &[' ']].iter().any(|delimiters| axes(&names(delimiters)).is_some())
    })
}

/// Bytes, decompressed.
pub(super) type Stream = Box<dyn BufRead + Send>;

/// An opened scene file.
pub(super) struct Source {
    /// The bytes, decompressed.
    pub(super) reader: Stream,
    /// As the user named it; `-` is standard input.
    pub(super) path: PathBuf,
    /// In this format.
    pub(super) format: Format,
    /// Length of a file that is not compressed, else 0: nothing is known.
    pub(super) bytes: u64,
}

/// Bytes that are looked at to tell the format.
const LOOK: u64 = 1 << 16;

impl Source {
    /// Opens `path`. gzip and bzip2 are known by their first bytes; the format is `format`, or told by the content, or by
    /// the name.
    ///
    /// # Errors
    /// [`Error::Io`], and [`Error::Scene`] for a file whose format nothing tells.
    pub(super) fn open(path: &Path, format: Option<Format>) -> Result<Self> {
        let stdin = path == Path::new("-");
        let mut bytes = 0;
        let raw: Box<dyn Read + Send> = if stdin {
            Box::new(io::stdin())
        } else {
            let file = File::open(path).map_err(|e| Error::read(path, e))?;
            bytes = file.metadata().map_or(0, |found| found.len());
            Box::new(file)
        };
        let mut raw = BufReader::with_capacity(1 << 16, raw);
        let mut magic = Vec::new();
        (&mut raw).take(3).read_to_end(&mut magic).map_err(|e| Error::read(path, e))?;
        let packed = Cursor::new(magic.clone()).chain(raw);
        let mut name = path.to_path_buf();
        let mut reader: Stream = match magic[..] {
            [0x1f, 0x8b, _] => Box::new(BufReader::with_capacity(1 << 16, MultiGzDecoder::new(packed))),
            [b'B', b'Z', b'h'] => Box::new(BufReader::with_capacity(1 << 16, MultiBzDecoder::new(packed))),
            _ => Box::new(packed),
        };
        if matches!(magic[..], [0x1f, 0x8b, _] | [b'B', b'Z', b'h']) {
            bytes = 0;
            name.set_extension("");
        }
        let mut start = Vec::new();
        reader.by_ref().take(LOOK).read_to_end(&mut start).map_err(|e| Error::read(path, e))?;
        let told = || Format::of_content(&start).or_else(|| Format::of_name(&name)).or_else(|| native(&start));
        let Some(format) = format.or_else(told) else {
            let names: Vec<_> = Format::ALL.iter().map(|format| format.name()).collect();
            let place = Place::file(path.display().to_string());
            let mend = format!("name it with --format: {}", names.join(", "));
            return Err(Error::scene(place, "neither content nor name tell what format this is", mend));
        };
        let reader = Box::new(Cursor::new(start).chain(reader));
        Ok(Self { reader, path: path.to_path_buf(), format, bytes })
    }
}

#[cfg(test)]
impl Source {
    /// A text in memory, for the readers' tests; `format` does not matter to a reader.
    pub(super) fn of_text(text: &str) -> Self {
        Self::of_bytes(text.as_bytes())
    }

    /// As [`Source::of_text`].
    pub(super) fn of_bytes(bytes: &[u8]) -> Self {
        let reader = Box::new(Cursor::new(bytes.to_vec()));
        Self { reader, path: "text".into(), format: Format::Native, bytes: bytes.len() as u64 }
    }
}

/// A text without a format's signs and without a name is taken for a scene file, unless it is plainly none.
fn native(start: &[u8]) -> Option<Format> {
    let text = match std::str::from_utf8(start) {
        Ok(text) => text,
        // What is looked at may end within a character.
        Err(error) if error.error_len().is_none() => std::str::from_utf8(&start[..error.valid_up_to()]).ok()?,
        Err(_) => return None,
    };
    let lines: Vec<&str> = text.trim_start_matches('\u{feff}').lines().collect();
    let plain = said(&lines).next().is_none_or(|line| line.starts_with('[') || line.contains('='));
    plain.then_some(Format::Native)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_told_by_content() {
        let gro = "a title\n 2\n    1SOL     OW    1   0.126   1.624   1.679\n";
        let cases: [(&str, Option<Format>); 19] = [
            ("ply\nformat ascii 1.0\n", Some(Format::Ply)),
            ("ITEM: TIMESTEP\n0\n", Some(Format::Dump)),
            ("# a comment\ndata_1ABC\n#\nloop_\n", Some(Format::Mmcif)),
            ("HEADER    VIRUS\n", Some(Format::Pdb)),
            ("ATOM      1  N   MET A   1      27.340  24.430   2.614\n", Some(Format::Pdb)),
            (gro, Some(Format::Gro)),
            ("2\n\nO 0 0 0\nH 1 0 0\n", Some(Format::Xyz)),
            ("0\nempty\n", Some(Format::Xyz)),
            ("1\nProperties=pos:R:3\n1 2 3\n", Some(Format::Xyz)),
            ("# by hand\nv\nfrom 0 0 1\n", Some(Format::Nff)),
            ("s 0 0 0 1\n", Some(Format::Nff)),
            ("LAMMPS data file\n\n 12 atoms\n", Some(Format::Data)),
            ("x,y,z,radius\n", Some(Format::Csv)),
            ("# id X Y Z vx\n", Some(Format::Csv)),
            ("# by hand\n\nradius,z,y,x\n", Some(Format::Csv)),
            ("name,x_km,y_km,z_km\n", Some(Format::Csv)),
            ("[camera]\neye = [0, 0, 1]\n", None),
            ("hello\n", None),
            ("", None),
        ];
        for (text, format) in cases {
            assert_eq!(Format::of_content(text.as_bytes()), format, "{text:?}");
        }
        assert_eq!(Format::of_content(b"\x93NUMPY\x01\x00"), Some(Format::Npy));
        assert_eq!(Format::of_content(b"PK\x03\x04"), Some(Format::Npz));
    }

    #[test]
    fn a_scene_that_is_longer_than_the_look_is_one_wherever_that_ends() {
        let text = "# \u{e9}\n[camera]\n";
        assert_eq!(native(text.as_bytes()), Some(Format::Native));
        let within = format!("{text}# \u{e9}");
        assert_eq!(native(&within.as_bytes()[..within.len() - 1]), Some(Format::Native));
        assert_eq!(native(b"[camera]\n\xff\n"), None);
    }
}
