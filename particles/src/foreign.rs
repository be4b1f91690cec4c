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
    sign: Sign,
}

/// The sign of a format in a file.
enum Sign {
    /// One of these beginnings.
    Start(&'static [&'static [u8]]),
    /// Whether a file with these first bytes and lines is of this format. Invalid UTF-8 is removed from the lines.
    Test(fn(&[u8], &[&str]) -> bool),
    /// None but its name.
    Name,
}

impl Sign {
    fn is_of(&self, start: &[u8], lines: &[&str]) -> bool {
        match self {
            Self::Start(starts) => starts.iter().any(|known| start.starts_with(known)),
            Self::Test(test) => test(start, lines),
            Self::Name => false,
        }
    }
}

const fn row(what: &'static str, mend: &'static str, endings: &'static [&'static str], sign: Sign) -> Foreign {
    Foreign { what, mend, endings, sign }
}

const TRAJECTORY: &str = "convert it to GRO, PDB or XYZ, for example with `gmx trjconv` or MDAnalysis";
const TOPOLOGY: &str = "use the file with the coordinates; MDAnalysis writes PDB from both";
const STRUCTURE: &str = "convert it to PDB, mmCIF or XYZ, for example with Open Babel or MDAnalysis";
const ARRAYS: &str = "save the positions with numpy.save or numpy.savez";
const HDF5: &str = "save the positions as NPY, from H5MD with `python -c \"import h5py, numpy; numpy.save('out.npy', \
    h5py.File('in.h5md')['particles/all/position/value'])\"`";
const MESH: &str = "save its vertices as PLY, for example with MeshLab or trimesh";
const TABLE: &str = "save its columns as CSV or NPY, for example with pandas";

/// All of them; the first match is used.
const ALL: &[Foreign] = &[
    row(
        "compressed with Zstandard before version 0.8",
        "decompress it with `zstd -d`",
        &[],
        Sign::Test(|bytes, _| matches!(bytes, [0x22..=0x27, 0xb5, 0x2f, 0xfd, ..])),
    ),
    row("compressed with LZ4", "decompress it with `lz4 -d`", &["lz4"], Sign::Start(&[b"\x04\x22\x4d\x18"])),
    row("compressed with LZMA", "decompress it with `unlzma`", &["lzma"], Sign::Start(&[b"\x5d\0\0"])),
    row("compressed with compress", "decompress it with `gzip -d`", &["z"], Sign::Start(&[b"\x1f\x9d"])),
    row("a 7z archive", "unpack it with `7z x`, and use a file of it", &["7z"], Sign::Start(&[b"7z\xbc\xaf\x27\x1c"])),
    row("a RAR archive", "unpack it with `7z x`, and use a file of it", &["rar"], Sign::Start(&[b"Rar!\x1a\x07"])),
    row(
        "a ZIP archive without arrays of NumPy",
        "unpack it with `unzip`, and use a file of it; save a spreadsheet as CSV",
        &["zip", "xlsx", "ods"],
        Sign::Test(is_zip),
    ),
    row(
        "a tar archive",
        "unpack it with `tar -xf`, and use a file of it",
        &["tar", "tgz"],
        Sign::Test(|bytes, _| bytes.get(257..262) == Some(b"ustar")),
    ),
    row(
        "a pointer of Git LFS in place of its file",
        "fetch the file with `git lfs pull`",
        &[],
        Sign::Start(&[b"version https://git-lfs"]),
    ),
    row(
        "a pointer of git-annex in place of its file",
        "fetch the file with `git annex get`",
        &[],
        Sign::Test(|_, lines| lines.first().is_some_and(|line| line.contains("/annex/objects/"))),
    ),
    row(
        "an HTML page, perhaps an error of a download",
        "download the file itself",
        &["html", "htm"],
        Sign::Test(|_, lines| {
            let begins =
                |line: &str, tag: &str| line.get(..tag.len()).is_some_and(|tag_of| tag_of.eq_ignore_ascii_case(tag));
            let first = lines.iter().map(|line| line.trim()).find(|line| !line.is_empty()).unwrap_or_default();
            begins(first, "<!doctype html") || begins(first, "<html")
        }),
    ),
    row(
        "an STL mesh",
        MESH,
        &["stl"],
        Sign::Test(|_, lines| {
            lines.first().is_some_and(|line| line.starts_with("solid"))
                && lines.get(1).is_some_and(|line| line.trim_start().starts_with("facet"))
        }),
    ),
    row("an OBJ mesh", MESH, &["obj", "mtl"], Sign::Test(is_obj)),
    row(
        "a file of Gaussian splats",
        "convert it to PLY, for example with SuperSplat or splat-transform",
        &["splat", "ksplat", "spz", "sog"],
        Sign::Start(&[b"NGSP"]),
    ),
    row("a glTF scene", MESH, &["gltf", "glb"], Sign::Start(&[b"glTF"])),
    row(
        "a FITS file",
        "save the positions as CSV or NPY, for example with astropy",
        &["fits", "fit"],
        Sign::Start(&[b"SIMPLE  ="]),
    ),
    row("a Parquet file", TABLE, &["parquet"], Sign::Start(&[b"PAR1"])),
    row("an Arrow file", TABLE, &["arrow", "feather"], Sign::Start(&[b"ARROW1", b"FEA1"])),
    row("a pickle of Python", ARRAYS, &["pkl", "pickle"], Sign::Test(|bytes, _| matches!(bytes, [0x80, 2..=5, ..]))),
    row("a MATLAB file", ARRAYS, &["mat"], Sign::Start(&[b"MATLAB 5.0 MAT-file"])),
    row(
        "a trajectory of ASE",
        "convert it to extended XYZ with `ase convert in.traj out.extxyz`",
        &["traj"],
        Sign::Start(&[b"- of Ulm"]),
    ),
    row(
        "a file of a grid (cube, XSF)",
        "convert it to extended XYZ, for example with `ase convert`",
        &["cube", "xsf"],
        Sign::Name,
    ),
    row(
        "a JSON file",
        ARRAYS,
        &["json", "geojson", "jsonl"],
        Sign::Test(|_, lines| lines.first().is_some_and(|line| line.trim_start().starts_with('{'))),
    ),
    row("a GROMOS file with blocks (TITLE ... END)", TRAJECTORY, &["trc", "g96"], Sign::Test(is_gromos)),
    row(
        "a GROMACS run input file (TPR)",
        "write its coordinates with `gmx editconf -f topol.tpr -o out.gro`",
        &["tpr"],
        Sign::Test(|bytes, _| bytes.get(8..15) == Some(b"VERSION") || bytes.get(4..11) == Some(b"VERSION")),
    ),
    row("a GROMACS TNG trajectory", TRAJECTORY, &["tng"], Sign::Name),
    row("an HDF5 file", HDF5, &["h5", "hdf5", "h5md"], Sign::Start(&[b"\x89HDF\r\n\x1a\n"])),
    row(
        "an SQLite file, as Desmond writes structures (DMS)",
        STRUCTURE,
        &["dms"],
        Sign::Start(&[b"SQLite format 3\0"]),
    ),
    row("an MMTF file", "use the entry as mmCIF or PDB", &["mmtf"], Sign::Name),
    row(
        "a picture",
        "use a scene or particle file; `halfline compare` reads pictures",
        &["png", "exr", "pfm"],
        Sign::Start(&[b"\x89PNG", b"\x76\x2f\x31\x01"]),
    ),
    row(
        "a CHARMM topology (PSF)",
        TOPOLOGY,
        &["psf"],
        Sign::Test(|_, lines| lines.first().is_some_and(|line| line.split_whitespace().next() == Some("PSF"))),
    ),
    row(
        "an AMBER topology",
        TOPOLOGY,
        &["prmtop", "parm7"],
        Sign::Test(|_, lines| lines.first().is_some_and(|line| line.starts_with("%VERSION"))),
    ),
    row("an AMBER coordinate file", TOPOLOGY, &["inpcrd", "rst7", "mdcrd"], Sign::Name),
    row("a GROMACS topology", TOPOLOGY, &["itp", "top"], Sign::Name),
    row("a CHARMM coordinate file", STRUCTURE, &["crd", "cor"], Sign::Test(is_charmm)),
    row(
        "a MOL2 file",
        STRUCTURE,
        &["mol2"],
        Sign::Test(|_, lines| lines.iter().any(|line| line.starts_with("@<TRIPOS>"))),
    ),
    row(
        "an MDL file (MOL, SDF)",
        STRUCTURE,
        &["mol", "sdf"],
        Sign::Test(|_, lines| {
            lines.get(3).is_some_and(|line| ["V2000", "V3000"].iter().any(|v| line.trim_end().ends_with(v)))
        }),
    ),
    row("a Tinker file", STRUCTURE, &["txyz", "arc"], Sign::Test(is_tinker)),
    row(
        "an XML file",
        STRUCTURE,
        &["xml"],
        Sign::Test(|_, lines| lines.first().is_some_and(|line| line.starts_with("<?xml"))),
    ),
];

/// Detects a format by the beginning of a file.
pub(super) fn of_content(start: &[u8], lines: &[&str]) -> Option<&'static Foreign> {
    ALL.iter().find(|foreign| foreign.sign.is_of(start, lines))
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

/// An archive whose first file has another ending than an array.
pub(super) fn is_zip(bytes: &[u8], _: &[&str]) -> bool {
    let length = bytes.get(26..28).map_or(0, |bytes| usize::from(bytes[0]) | usize::from(bytes[1]) << 8);
    let name = bytes.get(30..30 + length).unwrap_or_default();
    bytes.starts_with(b"PK\x03\x04") && !name.ends_with(b".npy") && (name.contains(&b'.') || name.ends_with(b"/"))
}

/// Title lines that begin with an asterisk, then the number of atoms.
fn is_charmm(_: &[u8], lines: &[&str]) -> bool {
    let mut rest = lines.iter().skip_while(|line| line.starts_with('*'));
    let count = rest.next().and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    lines.first().is_some_and(|line| line.starts_with('*')) && count.is_some()
}

/// Vertices, faces or names of a mesh; `v` and `f` of NFF have no numbers, and eight.
fn is_obj(_: &[u8], lines: &[&str]) -> bool {
    let words = |line: &&str| line.split_whitespace().map(str::to_owned).collect::<Vec<String>>();
    let rows = lines.iter().map(words).filter(|words| words.first().is_some_and(|word| !word.starts_with('#')));
    let rows: Vec<Vec<String>> = rows.collect();
    let is_known =
        |row: &Vec<String>| ["v", "vn", "vt", "f", "l", "o", "g", "s", "mtllib", "usemtl"].contains(&&row[0][..]);
    let is_vertex = |row: &Vec<String>| {
        row[0] == "v" && (4..=8).contains(&row.len()) && row[1..].iter().all(|word| word.parse::<f64>().is_ok())
    };
    rows.first().is_some_and(is_known) && rows.iter().any(is_vertex)
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
        assert!(of_content(b"\x89HDF\r\n\x1a\n", &[]).is_some_and(|foreign| foreign.what.contains("HDF5")));
        assert!(of_name(Path::new("a/b.H5MD")).is_some() && of_name(Path::new("b.pdb")).is_none());
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
