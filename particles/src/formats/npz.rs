//! Named NumPy arrays: an archive as written by numpy.savez, read sequentially, so that it may come from a pipe; the
//! directory at its end is not used. The format is PKWARE's APPNOTE.TXT 6.3.10.

mod archive;

use crate::foreign::is_zip;
use crate::format::{FormatRow, Has, Open, Sign};
use crate::npy::header::{DType, Header, Scalar, bits, levels};
use crate::npy::{Npy, shown, text_size};
use crate::particles::frame::{Column, ParticleFrames, Particles};
use crate::particles::layout::{EVERY, is_requested};
use crate::particles::meaning::{FieldKind, Meanings, NamedField, is_known, is_length, meanings};
use crate::particles::request::Request;
use crate::particles::role::Role;
use crate::skipped::Skipped;
use crate::source::Source;
use archive::{Archive, MEND};
use halfline_ground::check::{check_color, is_center, is_radius};
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::check;
use halfline_ground::quote::{count, list, quote};
use std::collections::BTreeMap;
use std::io::BufRead;
use std::sync::Arc;

pub(crate) const NPZ: FormatRow = FormatRow {
    name: "npz",
    about: "named NumPy arrays",
    signs: &[Sign::Bytes(|bytes| bytes.starts_with(b"PK\x03\x04") && !is_zip(bytes, &[]))],
    has: &[Has::AnyColumns],
    open: Open::Frames(|source, request, _| Ok(Box::new(Npz::new(source, request)))).optional(),
    ..FormatRow::PLAIN
};

/// The reader.
pub(crate) struct Npz {
    source: Option<Source>,
    request: Request,
    /// The arrays, once they are read, and the next frame.
    arrays: Arrays,
    file: Place,
    next: usize,
}

/// The arrays of a file, in any order.
#[derive(Default)]
struct Arrays {
    /// Arrays that are called like positions, colours or radii.
    known: Vec<KnownArray>,
    columns: Vec<ColumnArray>,
    /// The texts of columns of texts.
    labels: BTreeMap<String, Vec<String>>,
    /// Warnings, where all columns are requested, about arrays that are no column because of their type.
    warnings: Vec<String>,
    /// Names and lengths of one-dimensional numeric arrays.
    one: Vec<(String, u64)>,
    /// All arrays in words: name, type and shape.
    shown: Vec<String>,
    /// The arrays whose names have capitals, by the names in lower case.
    capitals: BTreeMap<String, String>,
}

/// An array with the name of a position, a colour or a radius.
struct KnownArray {
    name: String,
    width: usize,
    /// The frames whose numbers follow each other; 1 also where all frames have the same numbers.
    frames: usize,
    /// Whether it is one number for all particles.
    is_scalar: bool,
    /// Its numbers and their type; for an array that cannot be used, its type and shape in words.
    numbers: Result<(Vec<f64>, Scalar), String>,
}

/// An array that is a column: of each particle, or of each particle of each frame.
struct ColumnArray {
    column: Column,
    frames: usize,
}

/// The most arrays, and the most bytes in the name of an array.
const MOST: usize = 4096;
const LONGEST_NAME: usize = 256;

impl Npz {
    pub(crate) fn new(source: Source, request: Request) -> Self {
        let file = Place::file(source.path.display().to_string());
        Self { source: Some(source), request, arrays: Arrays::default(), file, next: 0 }
    }

    fn read(&self, source: Source) -> Result<Arrays> {
        let counts = source.reader.counts();
        let mut archive = Archive { reader: source.reader, path: source.path };
        let mut found = Arrays::default();
        while let Some(member) = archive.member()? {
            archive.open(&member, |path, reader| {
                let (path, counts) = (path.to_path_buf(), Arc::clone(&counts));
                let mut npy = Npy { path, reader, bytes: 0, counts, mend: MEND, left_out: None };
                let header = npy.header()?;
                found.take(member.name.trim_end_matches(".npy"), &header, &mut npy, &self.request.columns)
            })?;
        }
        Ok(found)
    }

    /// Reads the arrays if they are not; returns whether there is another frame.
    fn has_next(&mut self) -> Result<bool> {
        if let Some(source) = self.source.take() {
            self.arrays = self.read(source)?;
        }
        Ok(self.next == 0 || self.next < self.arrays.frames())
    }
}

impl Arrays {
    fn take<R: BufRead>(&mut self, name: &str, header: &Header, npy: &mut Npy<R>, requested: &[String]) -> Result<()> {
        let (as_written, name) = (name, name.to_lowercase());
        let shape = header.shape.clone();
        if self.one.len() < MOST
            && name.len() <= LONGEST_NAME
            && shape.len() == 1
            && matches!(header.dtype, DType::Plain(_))
        {
            self.one.push((name.clone(), shape[0]));
        }
        if self.shown.len() < MOST && name.len() <= LONGEST_NAME {
            if as_written != name {
                self.capitals.insert(name.clone(), as_written.to_owned());
            }
            self.shown.push(format!("{as_written} ({} of shape {})", header.dtype, shown(&shape)));
        }
        let (is_every, is_requested, is_known) =
            (requested.iter().any(|name| name == EVERY), is_requested(requested, &name), is_known(&name));
        let is_text = is_requested
            && shape.len() == 1
            && matches!(&header.dtype, DType::Plain(kind) if text_size(kind).is_some());
        let is_single = is_single(&name);
        let (frames, width) = match shape[..] {
            [] if is_length(&name) => (1, 1),
            [_] => (1, 1),
            // Of frames, each with a number of each particle.
            [frames, _] if is_single => (frames, 1),
            [_, width @ 1..=4] if is_known => (1, width),
            [_, width @ 2..=3] => (1, width),
            [frames, _] if !is_known => (frames, 1),
            [frames, _, width @ 2..=4] if !is_single => (frames, width),
            _ => (1, 0),
        };
        let (frames, width) = (frames as usize, width as usize);
        if is_known && (width == 0 || header.dtype.scalar().is_none()) && self.known.len() < MOST {
            let found = format!("{} of shape {}", header.dtype, shown(&shape));
            let numbers = Err(found);
            self.known.push(KnownArray { name: name.clone(), width: 1, frames: 1, is_scalar: false, numbers });
            if !is_text {
                return Ok(());
            }
        }
        if width == 0 || !(is_requested || is_known) {
            return Ok(());
        }
        if is_text {
            let (values, names) = npy.texts(header)?;
            self.labels.insert(name.clone(), names.labels());
            self.columns.push(ColumnArray { column: Column { name, values }, frames: 1 });
            return Ok(());
        }
        if header.dtype.scalar().is_none() && is_every {
            self.warnings.push(format!("the array {} has the type {} and is no column", quote(&name), header.dtype));
            return Ok(());
        }
        let numbers = npy.numbers(header)?;
        let column = || check(8 * numbers.len() as u64, || format!("the column {}", quote(&name)));
        if is_known {
            if let Some(scalar) = header.dtype.scalar() {
                let is_scalar = shape.is_empty();
                if width == 1 && is_requested && !is_scalar {
                    column()?;
                    let column = Column { name: name.clone(), values: numbers.clone() };
                    self.columns.push(ColumnArray { column, frames });
                }
                self.known.push(KnownArray { name, width, frames, is_scalar, numbers: Ok((numbers, scalar)) });
            }
            return Ok(());
        }
        // For vectors their length.
        column()?;
        let length = |vector: &[f64]| vector.iter().fold(0.0f64, |length, x| length.hypot(*x));
        let values = if width == 1 { numbers } else { numbers.chunks_exact(width).map(length).collect() };
        self.columns.push(ColumnArray { column: Column { name, values }, frames });
        Ok(())
    }

    /// The number of frames of the positions.
    fn frames(&self) -> usize {
        let meanings = self.meanings();
        let is_placed = |k: &usize| meanings.fields[*k].iter().any(|(_, role)| matches!(role, Role::Position(_)));
        (0..self.known.len()).filter(is_placed).map(|k| self.known[k].frames).max().unwrap_or(1)
    }

    /// The meanings of the known arrays, by their names, types and widths.
    fn meanings(&self) -> Meanings {
        let named = |array: &KnownArray| match &array.numbers {
            Ok((_, scalar)) => (array.width, FieldKind::Binary(*scalar)),
            Err(found) => (1, FieldKind::Other(found.clone())),
        };
        let fields = self.known.iter().map(|array| {
            let (count, kind) = named(array);
            NamedField { name: &array.name, count, kind }
        });
        meanings(&fields.collect::<Vec<_>>())
    }

    /// The numbers of a role's column in a frame, and whether they are one for all particles.
    fn numbers(&self, meanings: &Meanings, role: Role, frame: usize) -> Option<(Vec<f64>, bool)> {
        let column = |k: usize| meanings.fields[k].iter().position(|(_, known)| *known == role);
        let (k, column) = (0..self.known.len()).find_map(|k| Some((k, column(k)?)))?;
        let KnownArray { width, frames, is_scalar, .. } = self.known[k];
        let (numbers, scalar) = self.known[k].numbers.as_ref().ok()?;
        let numbers = of_frame(numbers, frames, frame);
        if meanings.packed == Some(k) {
            return Some((numbers.iter().map(|number| levels(bits(*number, *scalar))[column]).collect(), is_scalar));
        }
        Some((numbers.iter().skip(column).step_by(width).copied().collect(), is_scalar))
    }

    /// The particles of a frame.
    fn particles(&self, frame: usize, file: &Place) -> Result<Particles> {
        let fail = |field: &str, problem: String| Err(Error::scene(file.clone().named(field), problem, MEND));
        let numbers: usize =
            self.known.iter().filter_map(|array| array.numbers.as_ref().ok()).map(|(all, _)| all.len()).sum();
        check(16 * numbers as u64, || "the particles besides the file's arrays".into())?;
        let meanings = self.meanings();
        let of = |role: Role| self.numbers(&meanings, role, frame).map(|(numbers, _)| numbers);
        let three = |role: fn(usize) -> Role| Some([of(role(0))?, of(role(1))?, of(role(2))?]);
        let Some([x, y, z]) = three(Role::Position) else {
            let found = if self.shown.is_empty() { "none".to_owned() } else { list(&self.shown) };
            let problem = "no array of numbers of shape (n, 3) or (frames, n, 3) has that name";
            return fail("positions", format!("{problem}; found {found}"));
        };
        if x.len() != y.len() || x.len() != z.len() {
            return fail("x, y, z", format!("x, y and z have {}, {} and {} numbers", x.len(), y.len(), z.len()));
        }
        let positions: Vec<[f64; 3]> = x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect();
        let n = positions.len();
        let lengths = |role: Role, share: f64| {
            let (lengths, is_scalar) = self.numbers(&meanings, role, frame)?;
            let radii: Vec<f64> = lengths.into_iter().map(|length| length * share).collect();
            Some(if is_scalar { vec![radii[0]; n] } else { radii })
        };
        let radii = lengths(Role::Radius, 1.0).or_else(|| lengths(Role::Diameter, 0.5)).unwrap_or_default();
        if !radii.is_empty() && radii.len() != n {
            return fail("radii", format!("found {} radii for {n} positions", radii.len()));
        }
        let [red, green, blue] = three(Role::Color).unwrap_or_default();
        let lengths = [&red, &green, &blue].map(Vec::len);
        if let Some(length) = lengths.into_iter().find(|length| *length != lengths[0] || *length > 0 && *length != n) {
            return fail("colors", format!("found {length} colours for {n} positions"));
        }
        let colors = red.into_iter().zip(green).zip(blue).map(|((r, g), b)| [r, g, b].map(|c| c as f32));
        let colors: Vec<[f32; 3]> = colors.collect();
        for (row, color) in colors.iter().enumerate() {
            check_color(*color, || file.clone().named(format!("colors row {row}")))?;
        }
        let column = |array: &ColumnArray| {
            let values = of_frame(&array.column.values, array.frames, frame);
            (values.len() == n).then(|| Column { name: array.column.name.clone(), values: values.to_vec() })
        };
        let columns: Vec<Column> = self.columns.iter().filter_map(column).collect();
        let has = self.one.iter().filter(|(_, rows)| *rows == n as u64).map(|(name, _)| name.clone()).collect();
        let Meanings { color_type, warnings, .. } = meanings;
        let mut labels = self.labels.clone();
        labels.retain(|name, _| columns.iter().any(|column| column.name == *name));
        let skipped = Skipped { assumed: [&warnings[..], &self.warnings].concat(), ..Skipped::default() };
        let shown = self.capitals.clone();
        Ok(Particles {
            positions,
            radii,
            colors,
            color_type,
            columns,
            labels,
            has,
            shown,
            skipped,
            ..Particles::default()
        })
    }
}

impl ParticleFrames for Npz {
    fn next(&mut self) -> Result<Option<Particles>> {
        if !self.has_next()? {
            return Ok(None);
        }
        let mut particles = self.arrays.particles(self.next, &self.file)?;
        self.next += 1;
        if self.request.skip_invalid {
            leave_invalid_out(&mut particles);
        }
        Ok(Some(particles))
    }

    fn skip(&mut self) -> Result<bool> {
        let has_next = self.has_next()?;
        self.next += usize::from(has_next);
        Ok(has_next)
    }
}

/// Leaves particles out that are no spheres, by a centre that is not finite or a radius that is not positive.
fn leave_invalid_out(particles: &mut Particles) {
    // NaN is no radius.
    let is_valid = |n: usize| {
        let radius = particles.radii.get(n).copied().filter(|radius| !radius.is_nan()).unwrap_or(1.0);
        is_center(&particles.positions[n]) & is_radius(&radius)
    };
    let stays: Vec<bool> = (0..particles.positions.len()).map(is_valid).collect();
    let Some(first) = stays.iter().position(|stays| !stays) else { return };
    let left = stays.iter().filter(|stays| !**stays).count() as u64;
    let warning = format!("{} left out, the first: row {first} is no sphere", count(left, "row"));
    particles.skipped.assumed.push(warning);
    particles.keep(&stays);
}

/// Whether a name is of one number of each particle.
fn is_single(name: &str) -> bool {
    ["x", "y", "z"].contains(&name) || is_length(name)
}

/// The numbers of a frame, unless all frames share them.
fn of_frame(numbers: &[f64], frames: usize, frame: usize) -> &[f64] {
    if frames < 2 {
        return numbers;
    }
    let each = numbers.len() / frames;
    numbers.get(frame * each..(frame + 1) * each).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::DeflateEncoder;
    use std::io::Write;

    fn npy(shape: &str, numbers: &[f64]) -> Vec<u8> {
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
        bytes
    }

    #[derive(Clone, Copy, PartialEq)]
    enum How {
        Stored,
        Deflated,
        /// Sizes after the file, as written to a pipe.
        Piped,
    }

    fn archive(how: How, members: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (name, content) in members {
            let mut crc = flate2::Crc::new();
            crc.update(content);
            let packed = if how == How::Stored {
                content.clone()
            } else {
                let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
                encoder.write_all(content).expect("in memory");
                encoder.finish().expect("in memory")
            };
            let piped = how == How::Piped;
            let sizes = [crc.sum(), packed.len() as u32, content.len() as u32];
            bytes.extend(b"PK\x03\x04\x14\x00");
            bytes.extend([if piped { 8 } else { 0 }, 0, if how == How::Stored { 0 } else { 8 }, 0, 0, 0, 0, 0]);
            sizes.iter().for_each(|n| bytes.extend(if piped { 0u32 } else { *n }.to_le_bytes()));
            bytes.extend((name.len() as u16).to_le_bytes());
            bytes.extend([0, 0]);
            bytes.extend(name.as_bytes());
            bytes.extend(packed);
            if piped {
                bytes.extend(b"PK\x07\x08");
                sizes.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
            }
        }
        bytes.extend(b"PK\x05\x06");
        bytes
    }

    fn read(bytes: &[u8], columns: &[&str]) -> Result<Particles> {
        let mut npz = Npz::new(Source::of_bytes(bytes), Request::of(columns));
        Ok(npz.next()?.expect("one frame"))
    }

    fn members() -> Vec<(&'static str, Vec<u8>)> {
        vec![
            ("colors.npy", npy("(2, 3)", &[0.0, 0.5, 1.0, 1.0, 1.0, 1.0])),
            ("vel.npy", npy("(2, 3)", &[2.0, 3.0, 6.0, 0.0, 0.0, 1.0])),
            ("t.npy", npy("(2,)", &[7.0, 8.0])),
            ("other.npy", npy("(5,)", &[0.0; 5])),
            ("positions.npy", npy("(2, 3)", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])),
            ("radii.npy", npy("(2,)", &[0.5, 1.5])),
        ]
    }

    #[test]
    fn arrays_are_found_by_name_in_any_order() {
        for how in [How::Stored, How::Deflated, How::Piped] {
            let found = read(&archive(how, &members()), &["t", "VEL", "other"]).expect("arrays");
            assert_eq!(found.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
            assert_eq!((&found.radii[..], found.colors[0]), (&[0.5, 1.5][..], [0.0, 0.5, 1.0]));
            let columns: Vec<_> = found.columns.iter().map(|c| (c.name.as_str(), &c.values[..])).collect();
            assert_eq!(columns, [("vel", &[7.0, 1.0][..]), ("t", &[7.0, 8.0])], "the length of a vector");
            assert_eq!(found.has, ["t", "radii"]);
        }
        let axes = ["x", "y", "z"].map(|axis| (axis, npy("(1,)", &[f64::from(axis.as_bytes()[0])])));
        let found = read(&archive(How::Stored, &axes), &["y"]).expect("arrays");
        assert_eq!((found.positions[0], found.columns[0].values[0]), ([120.0, 121.0, 122.0], 121.0));
    }

    /// An array of texts as numpy writes it.
    fn texts(kind: &str, texts: &[&str]) -> Vec<u8> {
        let width = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0);
        let header = format!("{{'descr': '{kind}{width}', 'fortran_order': False, 'shape': ({},), }}\n", texts.len());
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        for text in texts {
            for letter in text.chars().chain(std::iter::repeat('\0')).take(width) {
                match kind {
                    "<U" => bytes.extend(u32::from(letter).to_le_bytes()),
                    ">U" => bytes.extend(u32::from(letter).to_be_bytes()),
                    _ => bytes.push(letter as u8),
                }
            }
        }
        bytes
    }

    #[test]
    fn texts_are_columns_and_other_types_are_reported() {
        for kind in ["<U", ">U", "|S"] {
            let mut members = members();
            members.push(("name.npy", texts(kind, &["CA", "N\u{e9}\u{e9}"])));
            let complex = npy("(2,)", &[1.0; 4]);
            let at = complex.windows(3).position(|bytes| bytes == b"<f8").expect("a type");
            let mut complex = [&complex[..at], b"<c16", &complex[at + 3..]].concat();
            complex[8] += 1;
            members.push(("wave.npy", complex));
            let bytes = archive(How::Deflated, &members);
            let found = read(&bytes, &["*"]).unwrap_or_else(|error| panic!("{error}"));
            let column = found.columns.iter().find(|column| column.name == "name").expect("a column");
            assert_eq!((&column.values[..], found.labels["name"][0].as_str()), (&[0.0, 1.0][..], "CA"), "{kind}");
            assert!(found.labels["name"][1] == "N\u{e9}\u{e9}" || kind == "|S", "{:?}", found.labels);
            assert!(found.skipped.assumed[0].contains("`wave` has the type `<c16`"), "{:?}", found.skipped);
            assert!(read(&bytes, &["wave"]).is_err(), "asked for by its name");
            assert_eq!(read(&bytes, &[]).expect("nothing is asked for").positions.len(), 2);
        }
        // A text that is called like a radius is a column, and it is told that it is no radius.
        let mut members = members();
        members.retain(|(name, _)| *name != "radii.npy");
        members.push(("radius.npy", texts("<U", &["a", "b"])));
        let found = read(&archive(How::Stored, &members), &["radius"]).expect("a column");
        assert_eq!((found.radii.len(), &found.labels["radius"][..]), (0, &["a".into(), "b".into()][..]));
        assert!(found.skipped.assumed[0].starts_with("radii are not taken from `radius`"), "{:?}", found.skipped);
    }

    #[test]
    fn errors_are_reported() {
        let good = archive(How::Deflated, &members());
        let mut damaged = good.clone();
        damaged[14] ^= 1;
        let mut foreign = good.clone();
        foreign[8] = 12;
        let with = |name: &'static str, shape: &str, n: usize| {
            let members = [members().swap_remove(4), (name, npy(shape, &vec![1.0; n]))];
            archive(How::Stored, &members)
        };
        for (bytes, message) in [
            (damaged, "colors.npy: the content does not match its checksum"),
            (foreign, "method 12 of colors.npy"),
            (good[..good.len() / 2].to_vec(), "text"),
            (
                archive(How::Stored, &members()[..4]),
                "(n, 3) or (frames, n, 3) has that name; found colors (`<f8` of shape (2, 3)), vel",
            ),
            (with("radii.npy", "(3,)", 3), "radii: found 3 radii for 2"),
            (with("radii.npy", "(1000000000000,)", 3), "text/radii.npy: data: the file ends after 3 of"),
            (with("colors.npy", "(1, 3)", 3), "found 1 colours for 2"),
            (with("colors.npy", "(2, 3)", 5), "after 1 of 2 rows"),
        ] {
            let error = read(&bytes, &[]).map(drop).expect_err(message).to_string();
            assert!(error.contains(message), "{error}");
        }
    }
}
