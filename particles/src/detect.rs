//! Detects the format of a scene file by its beginning and its name.

use super::foreign;
use super::format::Format;
use super::lines::comment;
use crate::formats::table::fields::declared_delimiter;
use crate::formats::table::names::axes;
use halfline_ground::quote::setting::{COLUMNS, FORMAT};
use std::path::Path;

#[cfg(test)]
mod tests;

/// A format, and the warning where the name or the content of the file says another.
pub(super) type Recognised = (Format, Option<String>);

/// The format of a file with this beginning and name, or the problem and its remedy. The name decides where the beginning can be of
/// its format: titles and comments may look like any other format. Else the structure of a format whose first line is a title does,
/// then a signature, which one format alone has, and then what else the content shows. Where it is not recognised, the name decides. A
/// format that is not supported is recognised by content that no supported format has.
pub(super) fn recognise(start: &[u8], name: &Path) -> Result<Recognised, (String, String)> {
    let text = String::from_utf8_lossy(start);
    let lines: Vec<&str> = text.lines().take(64).collect();
    let foreign = |foreign: &foreign::Foreign| {
        (format!("this is {}, which is not supported", foreign.what), foreign.mend.to_owned())
    };
    let named = Format::of_name(name).map(|named| if is_cloud(named, &text) { Format::Pts } else { named });
    // Tinker's files have the extension of XYZ and a similar beginning.
    match (of_content(start, named), foreign::of_content(start, &lines)) {
        (None, Some(found)) if !is_native(&lines) => return Err(foreign(found)),
        (Some(Format::Xyz), Some(found)) if !is_atoms(&lines) => return Err(foreign(found)),
        (Some(format), _) => return Ok((format, named.and_then(|named| contradiction(format, named, &text)))),
        (None, _) => {}
    }
    if let Some(format) = named {
        return Ok((format, None));
    }
    if let Some(found) = foreign::of_name(name) {
        return Err(foreign(found));
    }
    native(start).map(|format| (format, None)).ok_or_else(|| {
        let names: Vec<_> = Format::ALL.iter().map(|format| format.name()).collect();
        // The number of points may be before them.
        let is_row =
            |row: &str| row.split([',', ';', '\t', ' ']).filter(|word| word.trim().parse::<f64>().is_ok()).count() >= 3;
        let table = content_lines(&lines).filter(|line| !line.starts_with("//")).take(2).any(is_row);
        let columns = format!("{COLUMNS} x=1,y=2,z=3");
        let table = if table {
            format!("name the columns of a table with {columns} (or {FORMAT} csv {columns}), or ")
        } else {
            String::new()
        };
        let mend = format!("{table}set it with {FORMAT}: {}", names.join(", "));
        ("the format cannot be detected from content or name".to_owned(), mend)
    })
}

/// The warning about a file that is read as `format` and whose name says `named`, another one, or about a PQR file whose numbers
/// are in PDB's columns; else `None`.
fn contradiction(format: Format, named: Format, text: &str) -> Option<String> {
    let (read, other) = (format.name(), named.name());
    if format != named {
        return Some(format!(
            "the name of the file says {other}, but its content is that of {read} and read as such; {FORMAT} sets another"
        ));
    }
    let lines: Vec<&str> = text.lines().collect();
    let in_columns = |atom: &str| run(atom) == 5 && columns(atom).is_some();
    let is_either = format == Format::Pqr && !is_pqr(&lines) && atoms(&lines).next().is_some();
    (is_either && atoms(&lines).all(in_columns)).then(|| {
        format!(
            "the numbers behind the coordinates are in the columns of occupancy and B factor of {}; they are read as charge and \
             radius, as the name of the file says; {FORMAT} sets another",
            Format::Pdb.name()
        )
    })
}

/// Whether a file with this beginning has a format that is recognised but not supported.
pub(super) fn is_foreign(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    foreign::of_content(start, &text.lines().take(64).collect::<Vec<_>>()).is_some()
}

/// Detects the format by the beginning of a file, which may be that of the format `named`.
fn of_content(start: &[u8], named: Option<Format>) -> Option<Format> {
    if start.starts_with(b"\x93NUMPY") {
        return Some(Format::Npy);
    }
    if start.starts_with(b"PK\x03\x04") && !foreign::is_zip(start, &[]) {
        return Some(Format::Npz);
    }
    if let Some((format, _)) = BINARY.iter().find(|(_, sign)| sign(start)) {
        return Some(*format);
    }
    let text = String::from_utf8_lossy(start);
    let mut lines: Vec<&str> = text.trim_start_matches('\u{feff}').lines().collect();
    // The last line may be cut.
    if lines.len() > 1 && !start.ends_with(b"\n") {
        lines.pop();
    }
    let found = |signs: &[(Format, Sign)]| signs.iter().find(|(_, sign)| sign(&lines)).map(|(format, _)| *format);
    let by_name = |named: &Format| match named {
        Format::Native => content_lines(&lines).next().is_some() && native(start).is_some(),
        Format::Pdb => is_pdb(&lines) && !is_free(&lines) && !has_types(&lines),
        Format::Pqr => is_pdb(&lines) && !is_pdbqt(&lines),
        Format::Pdbqt => is_pdb(&lines),
        Format::Pts => is_points(&lines),
        named => STRUCTURES.iter().chain(&SIGNS).any(|(format, sign)| format == named && sign(&lines)),
    };
    named.filter(by_name).or_else(|| found(&STRUCTURES)).or_else(|| found(&SIGNATURES)).or_else(|| found(&SIGNS))
}

/// The lines behind a title, which may be any.
const STRUCTURES: [(Format, Sign); 5] = [
    (Format::Gro, is_gro),
    (Format::Ptx, is_ptx),
    (Format::Poscar, is_poscar),
    (Format::Mmcif, is_mmcif),
    (Format::Data, is_sections),
];

/// The first lines that one format alone has.
const SIGNATURES: [(Format, Sign); 3] = [
    (Format::Ply, |lines| {
        lines.first().is_some_and(|line| line.split('\r').next().is_some_and(|line| line.trim_end() == "ply"))
    }),
    (Format::Pcd, is_pcd),
    (Format::Dump, |lines| lines.first().is_some_and(|line| line.starts_with("ITEM:"))),
];

/// The beginnings of the other formats of text; the first that fits is taken.
const SIGNS: [(Format, Sign); 8] = [
    (Format::Pdbqt, is_pdbqt),
    (Format::Pqr, is_pqr),
    (Format::Pdb, is_pdb),
    (Format::Xyz, is_xyz),
    (Format::Nff, is_nff),
    (Format::Data, is_data),
    (Format::Csv, is_csv),
    (Format::Pts, is_scan),
];

/// Whether bytes begin a format.
type BinarySign = fn(&[u8]) -> bool;

/// The first bytes of binary formats.
const BINARY: [(Format, BinarySign); 6] = [
    (Format::Mmcif, is_binary_cif),
    (Format::Xtc, |bytes| matches!(bytes, [0, 0, 7, 0xcb | 0xe7, ..])),
    (Format::Trr, |bytes| bytes.starts_with(&[0, 0, 7, 0xc9])),
    // The major version.
    (Format::Las, |bytes| bytes.starts_with(b"LASF") && bytes.get(24).is_none_or(|version| *version == 1)),
    (Format::Gsd, |bytes| bytes.starts_with(&0x65df_65df_65df_65df_u64.to_le_bytes())),
    (Format::Dcd, is_dcd),
];

/// The length of the first record, 84 bytes in 4 or 8 of either order, and its kind.
fn is_dcd(bytes: &[u8]) -> bool {
    let kind = match bytes {
        [84, 0, 0, 0, 0, 0, 0, 0, kind @ ..] | [0, 0, 0, 0, 0, 0, 0, 84, kind @ ..] => kind,
        [84, 0, 0, 0, kind @ ..] | [0, 0, 0, 84, kind @ ..] => kind,
        _ => return false,
    };
    kind.starts_with(b"CORD") || kind.starts_with(b"VELD")
}

/// A map of MessagePack whose first key is one of BinaryCIF.
fn is_binary_cif(bytes: &[u8]) -> bool {
    let entries = match bytes {
        [0x80..=0x8f, rest @ ..] | [0xde, _, _, rest @ ..] | [0xdf, _, _, _, _, rest @ ..] => rest,
        _ => return false,
    };
    [&b"\xa7version"[..], b"\xa7encoder", b"\xaadataBlocks"].iter().any(|key| entries.starts_with(key))
}

/// Whether lines have a format.
type Sign = fn(&[&str]) -> bool;

/// Lines with content: neither blank nor a comment.
fn content_lines<'a>(lines: &'a [&'a str]) -> impl Iterator<Item = &'a str> {
    lines.iter().map(|line| line.trim()).filter(|line| !line.is_empty() && !line.starts_with('#'))
}

fn numbers(words: &str) -> usize {
    words.split_whitespace().take_while(|word| word.parse::<f64>().is_ok()).count()
}

/// A word that begins a file of CIF, and a word of CIF behind it, if there is any.
fn is_mmcif(lines: &[&str]) -> bool {
    let mut words = content_lines(lines).flat_map(str::split_whitespace);
    let Some(word) = words.next().map(str::to_ascii_lowercase) else { return false };
    // Libraries of monomers begin with what is global.
    let is_block = word == "global_" || word.len() > 5 && word.starts_with("data_") && !word.contains('=');
    let is_tag = |word: &str| word.starts_with('_');
    let next = words.next().map(str::to_ascii_lowercase);
    let begins = ["loop_", "data_", "save_", "global_"];
    match next.as_deref() {
        None => is_block || word == "loop_" || word.starts_with("_atom_site."),
        Some(next) if is_block => is_tag(next) || begins.iter().any(|word| next.starts_with(word)),
        Some(next) if word == "loop_" => is_tag(next),
        // A value follows.
        Some(value) => {
            let ends = |word: &str| is_tag(word) || begins.contains(&word) || value.starts_with(['\'', '"', ';']);
            word.starts_with("_atom_site.") && words.next().is_none_or(ends)
        }
    }
}

/// The records that a PDB file may begin with.
const RECORDS: [&str; 20] = [
    "HEADER", "OBSLTE", "TITLE", "SPLIT", "CAVEAT", "COMPND", "REMARK", "CRYST1", "MODEL", "ATOM", "HETATM", "AUTHOR",
    "USER", "NUMMDL", "SEQRES", "HELIX", "SHEET", "SSBOND", "ORIGX1", "SCALE1",
];

fn is_pdb(lines: &[&str]) -> bool {
    // In free form a blank is enough behind the name of the record.
    let is_atom = |line: &str| ["ATOM", "HETATM"].contains(&line.split_whitespace().next().unwrap_or_default());
    let record = |line: &str| RECORDS.contains(&line.get(..6).unwrap_or(line).trim_end()) || is_atom(line);
    let mut nonblank = lines.iter().filter(|line| !line.trim().is_empty());
    // A title or a header of columns may begin with the name of a record, but what is behind it does not.
    let second = nonblank.clone().nth(1);
    let is_table = lines.first().is_some_and(|line| is_csv(&[line]));
    if second.is_some_and(|line| !record(line) && (is_table || !line.starts_with(|c: char| c.is_ascii_uppercase()))) {
        return false;
    }
    match nonblank.next() {
        // In GROMOS the word is alone on its line too, and its block ends before atoms; some writers of PDB have no title.
        Some(line) if line.trim_end() == "TITLE" => {
            nonblank.find(|line| line.trim_end() == "END" || record(line)).is_some_and(|line| record(line))
        }
        line => line.is_some_and(|line| record(line)),
    }
}

/// The atoms of a file of PDB records.
fn atoms<'a>(lines: &'a [&'a str]) -> impl Iterator<Item = &'a str> {
    lines.iter().copied().filter(|line| line.starts_with("ATOM") || line.starts_with("HETATM"))
}

/// A charge in columns 71 to 76 of an atom, and an AutoDock atom type behind it.
fn has_charge(atom: &str) -> bool {
    let point = atom.as_bytes().get(72) == Some(&b'.') && atom.as_bytes().get(76) == Some(&b' ');
    point
        && numbers(atom.get(70..76).unwrap_or_default()) == 1
        && atom.get(77..).is_some_and(|kind| !kind.trim().is_empty())
}

/// A tree of branches.
fn is_tree(lines: &[&str]) -> bool {
    is_pdb(lines) && lines.iter().any(|line| line.trim_end() == "ROOT")
}

/// PDB records whose atoms end in a charge and an AutoDock atom type, or that have a tree of branches.
fn is_pdbqt(lines: &[&str]) -> bool {
    atoms(lines).next().is_some_and(|atom| has_charge(atom) || is_tree(lines))
}

/// Whether PDB records have a tree, or an atom with a charge and a type that PDB's columns cannot hold: a letter in column 79, or
/// `A` (aromatic carbon) in column 78.
fn has_types(lines: &[&str]) -> bool {
    let typed = |atom: &str| {
        let kind = atom.as_bytes().get(77..).unwrap_or_default();
        kind.get(1).is_some_and(u8::is_ascii_alphabetic) || kind.first() == Some(&b'A')
    };
    is_tree(lines) || atoms(lines).any(|atom| has_charge(atom) && typed(atom))
}

/// The numbers with a decimal point that follow each other in an atom.
fn run(atom: &str) -> usize {
    let is_number = |word: &&str| word.contains('.') && word.parse::<f64>().is_ok();
    atom.split_whitespace().skip_while(|word| !is_number(word)).take_while(is_number).count()
}

/// Coordinates, occupancy and B factor of an atom, as far as its columns of PDB have numbers; `None` where they cannot be these.
fn columns(atom: &str) -> Option<[f64; 5]> {
    let field = |from: usize, to: usize| atom.get(from..to.min(atom.len())).unwrap_or_default().trim();
    let mut found = [0.0; 5];
    for (k, (from, to)) in [(30, 38), (38, 46), (46, 54), (54, 60), (60, 66)].into_iter().enumerate() {
        found[k] = match field(from, to) {
            "" if k > 2 => continue,
            text => text.parse().ok()?,
        };
    }
    Some(found)
}

/// PDB records most of whose atoms have two numbers after their coordinates, and are not in the columns of PDB.
fn is_free(lines: &[&str]) -> bool {
    let [fit, free] = atoms(lines).fold([0, 0], |[fit, free], atom| match columns(atom) {
        None if run(atom) == 5 => [fit, free + 1],
        _ => [fit + 1, free],
    });
    is_pdb(lines) && free > fit
}

/// The same, or atoms with charges: numbers in the columns of the occupancy of which some are negative.
fn is_pqr(lines: &[&str]) -> bool {
    let negative = |atom: &str| run(atom) == 5 && columns(atom).is_some_and(|numbers| numbers[3] < 0.0);
    is_free(lines) || is_pdb(lines) && atoms(lines).any(negative)
}

/// A title, a count, and atoms with their number in columns 16 to 20, before coordinates with a decimal point.
fn is_gro(lines: &[&str]) -> bool {
    let [_, count, atom, ..] = lines else { return false };
    let whole = |text: Option<&str>| text.is_some_and(|text| text.trim().parse::<i64>().is_ok());
    whole(Some(count))
        && whole(atom.get(..5))
        && whole(atom.get(15..20))
        && atom.get(20..).is_some_and(|rest| numbers(rest) >= 3 && rest.contains('.'))
}

/// A count, a comment, and lines of a word or a number and three numbers. Points behind their number, as scanners write them,
/// have no comment.
fn is_xyz(lines: &[&str]) -> bool {
    let Some(count) = lines.first().and_then(|line| line.trim().parse::<u64>().ok()) else { return false };
    let width = |line: &str| Some(numbers(line)).filter(|n| *n >= 3 && *n == line.split_whitespace().count());
    let is_whole = |row: &str| row.split_whitespace().next().is_some_and(|word| word.parse::<u32>().is_ok());
    // Rows of both, of which one begins with a coordinate.
    let mut rows = lines.iter().skip(2).take(usize::try_from(count).unwrap_or(usize::MAX).saturating_sub(1));
    let comment = lines.get(1).and_then(|line| width(line));
    if comment.is_some() && rows.any(|row| width(row) == comment && !is_whole(row)) {
        return false;
    }
    match lines.get(2) {
        None => count == 0,
        Some(atom) => atom.split_whitespace().count() >= 4 || lines[1].contains("Properties="),
    }
}

/// The same with the words of extended XYZ, or with three numbers behind the first word of each atom: no other format.
fn is_atoms(lines: &[&str]) -> bool {
    let count = lines.first().and_then(|line| line.trim().parse::<usize>().ok()).unwrap_or(0);
    let comment = lines.get(1).map(|line| line.to_ascii_lowercase()).unwrap_or_default();
    let is_number = |word: &str| word.parse::<f64>().is_ok();
    let is_atom = |line: &&str| line.split_whitespace().skip(1).take(3).filter(|word| is_number(word)).count() == 3;
    // The last line may be cut.
    let rows = lines.len().saturating_sub(3).max(1).min(count);
    comment.contains("properties=") || comment.contains("lattice=") || lines.iter().skip(2).take(rows).all(is_atom)
}

/// Whether a file that is called XYZ has points in place of atoms.
fn is_cloud(named: Format, text: &str) -> bool {
    let lines: Vec<&str> = text.lines().take(64).collect();
    // The last line may be cut.
    let whole = if lines.len() > 1 { &lines[..lines.len() - 1] } else { &lines };
    named == Format::Xyz && !is_xyz(whole) && is_points(whole)
}

/// Lines of 3, 4, 6 or 7 numbers, as many in each, perhaps behind their number; not atoms with their atomic numbers.
fn is_points(lines: &[&str]) -> bool {
    let rows: Vec<Vec<&str>> = table_rows(lines).skip(usize::from(counts(lines))).collect();
    let is_row = |row: &Vec<&str>| row.len() == rows[0].len() && row.iter().all(|word| word.parse::<f64>().is_ok());
    let is_atom = |row: &Vec<&str>| row.len() == 4 && matches!(row[0].parse(), Ok(1..=118_u32));
    rows.first().is_some_and(|row| matches!(row.len(), 3 | 4 | 6 | 7))
        && rows.iter().all(|row| is_row(row) || row.len() == 1 && row[0].parse::<u64>().is_ok())
        && !(rows.iter().all(is_atom) && rows.iter().any(|row| row[3].parse::<i64>().is_err()))
}

/// Points behind their number, with colours: no other format has such lines.
fn is_scan(lines: &[&str]) -> bool {
    counts(lines) && is_points(lines) && table_rows(lines).nth(1).is_some_and(|row| row.len() >= 6)
}

/// Whether the first line with content is a whole number alone.
fn counts(lines: &[&str]) -> bool {
    table_rows(lines).next().is_some_and(|row| row.len() == 1 && row[0].parse::<u64>().is_ok())
}

/// The fields of lines that are no comments, whatever separates them.
fn table_rows<'a>(lines: &'a [&'a str]) -> impl Iterator<Item = Vec<&'a str>> {
    let rows = lines.iter().map(|line| line.trim()).filter(|line| !line.is_empty() && comment(line) == 0);
    rows.map(|line| line.split([',', ';', '\t', ' ']).filter(|word| !word.is_empty()).collect())
}

/// Two counts, the place and the three axes of the scanner, and a matrix of four rows.
fn is_ptx(lines: &[&str]) -> bool {
    let numbers = |line: &&str| {
        let words: Vec<bool> = line.split_whitespace().map(|word| word.parse::<f64>().is_ok()).collect();
        words.len() * usize::from(words.iter().all(|is_number| *is_number))
    };
    lines.len() >= 10 && lines[..10].iter().map(numbers).eq([1, 1, 3, 3, 3, 3, 4, 4, 4, 4])
}

/// A comment, a scale, three vectors, optionally a line of species, and whole numbers.
fn is_poscar(lines: &[&str]) -> bool {
    let lines: Vec<&str> = lines.iter().take(7).map(|line| line.split(['!', '#']).next().unwrap_or_default()).collect();
    let [_, scale, a, b, c, first, second] = &lines[..] else { return false };
    let vector = |line: &&str| numbers(line) == 3;
    let counts = |line: &str| line.split_whitespace().next().is_some_and(|word| word.parse::<u32>().is_ok());
    let species = first.trim_start().starts_with(|c: char| c.is_ascii_alphabetic());
    // The sixth or the seventh line has a word, unless all are rows of a table, perhaps under its header.
    let table = lines[1..7].iter().all(|line| numbers(line) >= 3 && numbers(line) == line.split_whitespace().count());
    !table
        && [1, 3].contains(&numbers(scale))
        && [a, b, c].into_iter().all(vector)
        && (counts(first) || species && counts(second))
}

/// Lines with the names and the sizes of the fields of a point cloud.
fn is_pcd(lines: &[&str]) -> bool {
    let first = |line: &str| line.split_whitespace().next().map(str::to_owned);
    let begins = |key: &str| content_lines(lines).take(8).any(|line| first(line).as_deref() == Some(key));
    let is_header = content_lines(lines)
        .next()
        .and_then(first)
        .is_some_and(|key| ["VERSION", "FIELDS", "COLUMNS"].contains(&&key[..]));
    is_header && (begins("FIELDS") || begins("COLUMNS")) && begins("SIZE") && begins("TYPE")
}

/// The words that begin a statement of NFF.
pub const NFF_DIRECTIVES: [&str; 8] = ["v", "b", "l", "f", "s", "c", "p", "pp"];

fn is_nff(lines: &[&str]) -> bool {
    content_lines(lines).next().is_some_and(|line| {
        let mut words = line.split_whitespace().take_while(|word| !word.starts_with('#'));
        let Some(directive) = words.next().filter(|word| NFF_DIRECTIVES.contains(word)) else { return false };
        let numbers: Vec<&str> = words.collect();
        // `v` with numbers is a vertex of OBJ.
        (directive != "v" || numbers.is_empty()) && numbers.iter().all(|word| word.parse::<f64>().is_ok())
    })
}

/// A title, and soon after it `N atoms`.
fn is_data(lines: &[&str]) -> bool {
    lines.iter().skip(1).take(32).any(|line| {
        let mut words = line.split_whitespace();
        words.next().is_some_and(|n| n.parse::<u64>().is_ok()) && words.next() == Some("atoms")
    })
}

/// The same, with another line of the header or a section.
fn is_sections(lines: &[&str]) -> bool {
    let is_known = |line: &&str| {
        let words: Vec<&str> = line.split_whitespace().take(4).collect();
        matches!(
            words[..],
            [_, "atom", "types", ..] | [_, _, "xlo", "xhi"] | [_, _, _, "avec"] | ["Atoms" | "Masses", ..]
        )
    };
    is_data(lines) && lines.iter().skip(1).any(is_known)
}

/// A header that names the coordinates; it may be a comment or follow comments. A scene file may have such a comment.
fn is_csv(lines: &[&str]) -> bool {
    if is_native(lines) {
        return false;
    }
    let mut before = true;
    let first = |line: &&&str| std::mem::replace(&mut before, line.trim().is_empty() || comment(line.trim()) > 0);
    let is_declared = lines.first().is_some_and(|line| declared_delimiter(line).is_some());
    lines.iter().skip(usize::from(is_declared)).take_while(first).any(|line| {
        let header = line.trim()[comment(line.trim())..].trim();
        let names = |delimiters: &[char]| -> Vec<String> {
            header.split(delimiters).map(|name| name.trim().trim_matches('"').to_owned()).collect()
        };
        // `x (km)` is one name where commas separate, and two where spaces do.
        [&[',', ';', '\t', '|'][..], &[' ']].iter().any(|delimiters| axes(&names(delimiters)).is_some())
    })
}

/// Whether lines have the tables of a scene file.
fn is_native(lines: &[&str]) -> bool {
    let tables = ["[camera]", "[image]", "[[sphere]]", "[[spheres]]"];
    content_lines(lines).any(|line| tables.contains(&line.split('#').next().unwrap_or_default().trim_end()))
}

/// Text without another format's signature and without a known name is taken as a scene file, unless it cannot be TOML.
fn native(start: &[u8]) -> Option<Format> {
    let text = String::from_utf8_lossy(start);
    let lines: Vec<&str> = text.trim_start_matches('\u{feff}').lines().collect();
    // `[table]`, or a key, perhaps of several words with dots between them, and its value.
    let key = |text: &str| {
        !text.trim().is_empty() && text.trim().chars().all(|c| c.is_alphanumeric() || "_-.\"'".contains(c))
    };
    let plain = |line: &str| line.starts_with('[') || line.split_once('=').is_some_and(|(name, _)| key(name));
    content_lines(&lines).next().is_none_or(plain).then_some(Format::Native)
}
