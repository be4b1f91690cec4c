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
const SCAN: &str = "convert it to LAS, PLY or PCD, for example with CloudCompare or PDAL";
const MESH: &str = "save its vertices as PLY, for example with MeshLab or trimesh";
const TABLE: &str = "save its columns as CSV or NPY, for example with pandas";

/// All of them; the first match is used.
const ALL: &[Foreign] = &[
    Foreign {
        what: "a text in UTF-16",
        mend: "save it as UTF-8, for example with `iconv -f UTF-16 -t UTF-8`",
        endings: &[],
        sign: |bytes, _| bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff"),
    },
    Foreign {
        what: "compressed with xz",
        mend: "decompress it with `xz -d`",
        endings: &["xz"],
        sign: |bytes, _| bytes.starts_with(b"\xfd7zXZ\0"),
    },
    Foreign {
        what: "compressed with Zstandard",
        mend: "decompress it with `zstd -d`",
        endings: &["zst", "zstd"],
        sign: |bytes, _| matches!(bytes, [0x22..=0x28, 0xb5, 0x2f, 0xfd, ..]),
    },
    Foreign {
        what: "compressed with LZ4",
        mend: "decompress it with `lz4 -d`",
        endings: &["lz4"],
        sign: |bytes, _| bytes.starts_with(b"\x04\x22\x4d\x18"),
    },
    Foreign {
        what: "compressed with LZMA",
        mend: "decompress it with `unlzma`",
        endings: &["lzma"],
        sign: |bytes, _| bytes.starts_with(b"\x5d\0\0"),
    },
    Foreign {
        what: "compressed with compress",
        mend: "decompress it with `gzip -d`",
        endings: &["z"],
        sign: |bytes, _| bytes.starts_with(b"\x1f\x9d"),
    },
    Foreign {
        what: "a 7z archive",
        mend: "unpack it with `7z x`, and use a file of it",
        endings: &["7z"],
        sign: |bytes, _| bytes.starts_with(b"7z\xbc\xaf\x27\x1c"),
    },
    Foreign {
        what: "a RAR archive",
        mend: "unpack it with `7z x`, and use a file of it",
        endings: &["rar"],
        sign: |bytes, _| bytes.starts_with(b"Rar!\x1a\x07"),
    },
    Foreign {
        what: "a ZIP archive without arrays of NumPy",
        mend: "unpack it with `unzip`, and use a file of it; save a spreadsheet as CSV",
        endings: &["zip", "xlsx", "ods"],
        sign: is_zip,
    },
    Foreign {
        what: "a tar archive",
        mend: "unpack it with `tar -xf`, and use a file of it",
        endings: &["tar", "tgz"],
        sign: |bytes, _| bytes.get(257..262) == Some(b"ustar"),
    },
    Foreign {
        what: "a pointer of Git LFS in place of its file",
        mend: "fetch the file with `git lfs pull`",
        endings: &[],
        sign: |bytes, _| bytes.starts_with(b"version https://git-lfs"),
    },
    Foreign {
        what: "a pointer of git-annex in place of its file",
        mend: "fetch the file with `git annex get`",
        endings: &[],
        sign: |_, lines| lines.first().is_some_and(|line| line.contains("/annex/objects/")),
    },
    Foreign {
        what: "an HTML page, perhaps an error of a download",
        mend: "download the file itself",
        endings: &["html", "htm"],
        sign: |_, lines| {
            let begins =
                |line: &str, tag: &str| line.get(..tag.len()).is_some_and(|tag_of| tag_of.eq_ignore_ascii_case(tag));
            let first = lines.iter().map(|line| line.trim()).find(|line| !line.is_empty()).unwrap_or_default();
            begins(first, "<!doctype html") || begins(first, "<html")
        },
    },
    Foreign { what: "an E57 scan", mend: SCAN, endings: &["e57"], sign: |bytes, _| bytes.starts_with(b"ASTM-E57") },
    Foreign { what: "a PTX scan", mend: SCAN, endings: &["ptx"], sign: is_ptx },
    Foreign {
        what: "a VTK file",
        mend: "save its points as CSV or PLY, for example with ParaView",
        endings: &["vtk", "vtp", "vtu", "vti", "pvd"],
        sign: |_, lines| {
            lines.first().is_some_and(|line| line.starts_with("# vtk DataFile"))
                || lines.iter().take(2).any(|line| line.trim_start().starts_with("<VTKFile"))
        },
    },
    Foreign {
        what: "an STL mesh",
        mend: MESH,
        endings: &["stl"],
        sign: |_, lines| {
            lines.first().is_some_and(|line| line.starts_with("solid"))
                && lines.get(1).is_some_and(|line| line.trim_start().starts_with("facet"))
        },
    },
    Foreign { what: "an OBJ mesh", mend: MESH, endings: &["obj"], sign: |_, _| false },
    Foreign {
        what: "a glTF scene",
        mend: MESH,
        endings: &["gltf", "glb"],
        sign: |bytes, _| bytes.starts_with(b"glTF"),
    },
    Foreign {
        what: "a FITS file",
        mend: "save the positions as CSV or NPY, for example with astropy",
        endings: &["fits", "fit"],
        sign: |bytes, _| bytes.starts_with(b"SIMPLE  ="),
    },
    Foreign { what: "a Parquet file", mend: TABLE, endings: &["parquet"], sign: |bytes, _| bytes.starts_with(b"PAR1") },
    Foreign {
        what: "an Arrow file",
        mend: TABLE,
        endings: &["arrow", "feather"],
        sign: |bytes, _| bytes.starts_with(b"ARROW1") || bytes.starts_with(b"FEA1"),
    },
    Foreign {
        what: "a pickle of Python",
        mend: ARRAYS,
        endings: &["pkl", "pickle"],
        sign: |bytes, _| matches!(bytes, [0x80, 2..=5, ..]),
    },
    Foreign {
        what: "a MATLAB file",
        mend: ARRAYS,
        endings: &["mat"],
        sign: |bytes, _| bytes.starts_with(b"MATLAB 5.0 MAT-file"),
    },
    Foreign {
        what: "a trajectory of ASE",
        mend: "convert it to extended XYZ with `ase convert in.traj out.extxyz`",
        endings: &["traj"],
        sign: |bytes, _| bytes.starts_with(b"- of Ulm"),
    },
    Foreign {
        what: "a file of a grid (cube, XSF)",
        mend: "convert it to extended XYZ, for example with `ase convert`",
        endings: &["cube", "xsf"],
        sign: |_, _| false,
    },
    Foreign {
        what: "a JSON file",
        mend: ARRAYS,
        endings: &["json", "geojson", "jsonl"],
        sign: |_, lines| lines.first().is_some_and(|line| line.trim_start().starts_with('{')),
    },
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

/// A line with only the name of a block, the lines of the block, and `END`. Records of PDB may follow such a line too.
fn is_gromos(_: &[u8], lines: &[&str]) -> bool {
    let mut lines = lines.iter().map(|line| line.trim_end()).filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.next() == Some("TITLE") && lines.next() != Some("END")
}

/// An archive whose first file has another ending than that of an array.
pub(super) fn is_zip(bytes: &[u8], _: &[&str]) -> bool {
    let length = bytes.get(26..28).map_or(0, |bytes| usize::from(bytes[0]) | usize::from(bytes[1]) << 8);
    let name = bytes.get(30..30 + length).unwrap_or_default();
    bytes.starts_with(b"PK\x03\x04") && !name.ends_with(b".npy") && (name.contains(&b'.') || name.ends_with(b"/"))
}

/// Two counts, the place and the three axes of the scanner, and a matrix of four rows.
fn is_ptx(_: &[u8], lines: &[&str]) -> bool {
    let numbers = |line: &&str| {
        let words: Vec<bool> = line.split_whitespace().map(|word| word.parse::<f64>().is_ok()).collect();
        words.len() * usize::from(words.iter().all(|is_number| *is_number))
    };
    lines.len() >= 10 && lines[..10].iter().map(numbers).eq([1, 1, 3, 3, 3, 3, 4, 4, 4, 4])
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
