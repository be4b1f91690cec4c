//! Formats that are recognised but not supported, so that the error can name the format.

use super::format::ending;
use std::path::Path;

/// An unsupported format.
pub(super) struct Foreign {
    /// A file of this format, with an article.
    pub(super) what: &'static str,
    /// The remedy.
    pub(super) mend: &'static str,
    /// File name extensions that no supported format shares.
    endings: &'static [&'static str],
    /// Whether a file with these first bytes and lines is of this format. Invalid UTF-8 is removed from the lines.
    sign: fn(&[u8], &[&str]) -> bool,
}

const TRAJECTORY: &str = "convert it to GRO, PDB or XYZ, for example with `gmx trjconv` or MDAnalysis";
const TOPOLOGY: &str = "use the file with the coordinates; MDAnalysis writes PDB from both";
const STRUCTURE: &str = "convert it to PDB, mmCIF or XYZ, for example with Open Babel or MDAnalysis";
const ARRAYS: &str = "save the positions with numpy.save or numpy.savez";

/// All of them; the first match is used.
const ALL: &[Foreign] = &[
    Foreign {
        what: "a GROMOS file with blocks (TITLE ... END)",
        mend: TRAJECTORY,
        endings: &["trc", "g96"],
        sign: is_gromos,
    },
    Foreign {
        what: "a GROMACS run input file (TPR)",
        mend: "write its coordinates with `gmx editconf -f topol.tpr -o out.gro`",
        endings: &["tpr"],
        sign: |bytes, _| bytes.get(8..15) == Some(b"VERSION") || bytes.get(4..11) == Some(b"VERSION"),
    },
    Foreign { what: "a GROMACS TNG trajectory", mend: TRAJECTORY, endings: &["tng"], sign: |_, _| false },
    Foreign {
        what: "a NetCDF file",
        mend: TRAJECTORY,
        endings: &["nc", "ncdf", "ncrst"],
        sign: |bytes, _| matches!(bytes, [b'C', b'D', b'F', 1 | 2 | 5, ..]),
    },
    Foreign {
        what: "an HDF5 file",
        mend: ARRAYS,
        endings: &["h5", "hdf5", "h5md"],
        sign: |bytes, _| bytes.starts_with(b"\x89HDF\r\n\x1a\n"),
    },
    Foreign {
        what: "an SQLite file, as Desmond writes structures (DMS)",
        mend: STRUCTURE,
        endings: &["dms"],
        sign: |bytes, _| bytes.starts_with(b"SQLite format 3\0"),
    },
    Foreign { what: "an MMTF file", mend: "use the entry as mmCIF or PDB", endings: &["mmtf"], sign: |_, _| false },
    Foreign { what: "a BinaryCIF file", mend: "use the entry as mmCIF or PDB", endings: &["bcif"], sign: |_, _| false },
    Foreign {
        what: "a picture",
        mend: "use a scene or particle file; `halfline compare` reads pictures",
        endings: &["png", "exr", "pfm"],
        sign: |bytes, _| bytes.starts_with(b"\x89PNG") || bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]),
    },
    Foreign {
        what: "a CHARMM topology (PSF)",
        mend: TOPOLOGY,
        endings: &["psf"],
        sign: |_, lines| lines.first().is_some_and(|line| line.split_whitespace().next() == Some("PSF")),
    },
    Foreign {
        what: "an AMBER topology",
        mend: TOPOLOGY,
        endings: &["prmtop", "parm7"],
        sign: |_, lines| lines.first().is_some_and(|line| line.starts_with("%VERSION")),
    },
    Foreign {
        what: "an AMBER coordinate file",
        mend: TOPOLOGY,
        endings: &["inpcrd", "rst7", "mdcrd"],
        sign: |_, _| false,
    },
    Foreign { what: "a GROMACS topology", mend: TOPOLOGY, endings: &["itp", "top"], sign: |_, _| false },
    Foreign { what: "a CHARMM coordinate file", mend: STRUCTURE, endings: &["crd", "cor"], sign: is_charmm },
    Foreign {
        what: "a MOL2 file",
        mend: STRUCTURE,
        endings: &["mol2"],
        sign: |_, lines| lines.iter().any(|line| line.starts_with("@<TRIPOS>")),
    },
    Foreign {
        what: "an MDL file (MOL, SDF)",
        mend: STRUCTURE,
        endings: &["mol", "sdf"],
        sign: |_, lines| {
            lines.get(3).is_some_and(|line| ["V2000", "V3000"].iter().any(|v| line.trim_end().ends_with(v)))
        },
    },
    Foreign { what: "a Tinker file", mend: STRUCTURE, endings: &["txyz", "arc"], sign: is_tinker },
    Foreign {
        what: "an XML file",
        mend: STRUCTURE,
        endings: &["xml"],
        sign: |_, lines| lines.first().is_some_and(|line| line.starts_with("<?xml")),
    },
];

/// Detects a format by the beginning of a file.
pub(super) fn of_content(start: &[u8], lines: &[&str]) -> Option<&'static Foreign> {
    ALL.iter().find(|foreign| (foreign.sign)(start, lines))
}

/// Detects a format by a file name without the extension of its compression.
pub(super) fn of_name(path: &Path) -> Option<&'static Foreign> {
    let ending = ending(path);
    ALL.iter().find(|foreign| foreign.endings.contains(&ending.as_str()))
}

/// A line with only the name of a block, the lines of the block, and `END`.
fn is_gromos(_: &[u8], lines: &[&str]) -> bool {
    let mut lines = lines.iter().map(|line| line.trim_end()).filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.next() == Some("TITLE") && lines.next() != Some("END")
}

/// Title lines that begin with an asterisk, then the number of atoms.
fn is_charmm(_: &[u8], lines: &[&str]) -> bool {
    let mut rest = lines.iter().skip_while(|line| line.starts_with('*'));
    let count = rest.next().and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    lines.first().is_some_and(|line| line.starts_with('*')) && count.is_some()
}

/// A line with a count and optionally a title, optionally a cell, and atoms that begin with their number and name.
fn is_tinker(_: &[u8], lines: &[&str]) -> bool {
    let count = lines.first().and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    let atom = |line: &&str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        words.len() >= 6
            && words[0] == "1"
            && words[1].parse::<f64>().is_err()
            && words[2..5].iter().all(|word| word.parse::<f64>().is_ok())
            && words[5].parse::<u32>().is_ok()
    };
    count.is_some_and(|count| count > 0) && lines.iter().skip(1).take(2).any(atom)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Option<&'static str> {
        let lines: Vec<&str> = text.lines().collect();
        of_content(text.as_bytes(), &lines).map(|foreign| foreign.what)
    }

    #[test]
    fn unsupported_formats_are_recognised() {
        for (text, what) in [
            ("TITLE\n    a trajectory\nEND\nTIMESTEP\n", "a GROMOS file"),
            ("PSF CMAP\n\n", "a CHARMM topology"),
            ("* A TITLE\n*\n   3341\n", "a CHARMM coordinate file"),
            ("%VERSION  VERSION_STAMP = V0001.000\n", "an AMBER topology"),
            ("# a comment\n@<TRIPOS>MOLECULE\n", "a MOL2 file"),
            ("ethanol\n  made by hand\n\n  9  8  0  0  0  0  0  0  0  0999 V2000\n", "an MDL file"),
            ("2 water\n 1 O 0.0 0.0 0.0 1 2\n 2 H 1.0 0.0 0.0 2 1\n", "a Tinker file"),
            ("2\n 30.0 30.0 30.0 90.0 90.0 90.0\n 1 O 0.0 0.0 0.0 1 2\n", "a Tinker file"),
            ("\0\0\x07\u{0}", "nothing"),
            ("TITLE     A STRUCTURE\n", "nothing"),
            ("TITLE\nEND\n", "nothing"),
            ("2\n\n1 0 0 0 0.5 2\n", "nothing"),
            ("* a bullet\n", "nothing"),
        ] {
            let found = of(text).unwrap_or("nothing");
            assert!(found.starts_with(what), "{text:?} is {found}");
        }
        assert!(of_content(b"CDF\x01", &[]).is_some_and(|foreign| foreign.what.contains("NetCDF")));
        assert!(of_name(Path::new("a/b.NCDF")).is_some() && of_name(Path::new("b.pdb")).is_none());
    }

    #[test]
    fn no_ending_is_of_two_formats() {
        let mut all: Vec<&str> = ALL.iter().flat_map(|foreign| foreign.endings).copied().collect();
        all.extend(super::super::format::Format::ALL.iter().map(|format| format.name()));
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), count);
    }
}
