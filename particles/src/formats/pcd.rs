//! Point clouds of the Point Cloud Library: a header of text, and the points in text, in binary or compressed
//! (pointclouds.org/documentation/tutorials/pcd_file_format.html). Points without coordinates, which keep the places of
//! an image of a scanner, are counted and left out. The crate pcd-rs 0.13 allocates the decompressed size that a file names.

mod header;
mod lzf;

use crate::format::{FormatRow, Has, Open, Sign};
use crate::input::Input;
use crate::lines::{Lines, Words};
use crate::npy::header::{bits, levels};
use crate::particles::bytes::{BinaryFile, DAMAGED};
use crate::particles::frame::Particles;
use crate::particles::request::Request;
use crate::particles::role::Role;
use crate::particles::rows::{blank_rest, filled_rows};
use crate::signs::content_lines;
use crate::source::Source;
use halfline_ground::error::{Place, Result, relocate};
use halfline_ground::memory::check;
use header::{PcdEncoding, PcdField, PcdHeader, PcdKind, header};

pub(crate) const PCD: FormatRow = FormatRow {
    name: "pcd",
    about: "point clouds of the Point Cloud Library",
    signs: &[Sign::Signature(is_pcd)],
    has: &[Has::AnyColumns],
    open: Open::Frame(read).optional(),
    ..FormatRow::PLAIN
};

/// The points, while they are read.
struct Points<'a> {
    header: &'a PcdHeader,
    particles: Particles,
    strict: bool,
}

/// The most bytes that are counted after the last point.
const BEHIND: u64 = 1 << 29;

/// Reads the points.
///
/// # Errors
/// [`Error::Scene`] with the place in the file, [`Error::Io`], [`Error::Limits`].
pub(crate) fn read(source: Source, request: &Request) -> Result<Particles> {
    let path = source.path.clone();
    let mut lines = Lines::new(source.reader, &path);
    let header = header(&mut lines, request)?;
    let mut points = Points { header: &header, particles: header.layout.begin(), strict: request.strict };
    match header.encoding {
        PcdEncoding::Ascii => points.ascii(&mut lines)?,
        PcdEncoding::Binary => points.binary(&mut BinaryFile::of(lines.into_reader(), path))?,
        PcdEncoding::Compressed => points.compressed(&mut BinaryFile::of(lines.into_reader(), path))?,
    }
    points.particles.tell_left_out();
    Ok(points.particles)
}

impl Points<'_> {
    fn ascii(&mut self, lines: &mut Lines<Input>) -> Result<()> {
        let (header, strict) = (self.header, self.strict);
        let point = |line: &Lines<&[u8]>, particles: &mut Particles| {
            let place = |field: &str| line.place(0).named(field);
            add(header, strict, &of_line(header, line)?, particles, place)
        };
        let read = filled_rows(lines, header.points, &header.layout, &mut self.particles, point)?;
        if read < header.points {
            let problem = format!("the file ends after {read} of {} points", header.points);
            return Err(lines.fail(0, "point", problem, "correct POINTS in the header"));
        }
        blank_rest(lines, header.points, "points")
    }

    fn binary(&mut self, file: &mut BinaryFile) -> Result<()> {
        let (record, mut block, mut read) = (&self.header.record, Vec::new(), 0);
        while read < self.header.points {
            let (count, at) = (record.per_block().min(self.header.points - read), file.at());
            file.block(count * record.size() as u64, &mut block, "points")?;
            let row = |n| format!("byte {}", at + (n * record.size()) as u64);
            self.block(&block, file, row)?;
            read += count;
        }
        self.behind(file)
    }

    fn compressed(&mut self, file: &mut BinaryFile) -> Result<()> {
        let packed = u32::from_le_bytes(file.bytes("compressed size")?);
        let at = file.at();
        let size = u64::from(u32::from_le_bytes(file.bytes("decompressed size")?));
        let (count, record) = (self.header.points, &self.header.record);
        if size != count * record.size() as u64 {
            let problem = format!("{size} bytes do not match {count} points of {} bytes", record.size());
            return Err(file.fail(at, "decompressed size", problem, DAMAGED));
        }
        let (at, mut packed_points) = (file.at(), Vec::new());
        file.block(u64::from(packed), &mut packed_points, "points")?;
        let bytes = match lzf::unpack(&packed_points, size)? {
            Some(bytes) => bytes,
            // Points that compression does not shorten are stored as they are, as by pypcd.
            None if u64::from(packed) == size => packed_points,
            None => return Err(file.fail(at, "points", format!("they do not decompress to {size} bytes"), DAMAGED)),
        };
        check(64 * count, || format!("{count} points"))?;
        // The file has field by field, all points of each.
        let (count, mut block, mut read) = (count as usize, Vec::new(), 0);
        while read < count {
            let points = read..count.min(read + record.per_block() as usize);
            block.clear();
            block.resize(points.len() * record.size(), 0);
            let (mut of_field, mut place) = (0, 0);
            for size in self.header.fields.iter().map(PcdField::size).filter(|size| *size > 0) {
                let from = &bytes[of_field + points.start * size..of_field + points.end * size];
                for (to, from) in block.chunks_exact_mut(record.size()).zip(from.chunks_exact(size)) {
                    to[place..place + size].copy_from_slice(from);
                }
                (of_field, place) = (of_field + count * size, place + size);
            }
            self.block(&block, file, |n| format!("point {}", read + n))?;
            read = points.end;
        }
        self.behind(file)
    }

    /// Adds the points of a block of records, whose rows have these names in errors.
    fn block(&mut self, block: &[u8], file: &BinaryFile, row: impl Fn(usize) -> String + Sync) -> Result<()> {
        let (header, strict, place) = (self.header, self.strict, file.file());
        header.record.append(block, &header.layout, &mut self.particles, true, |n, numbers, particles| {
            add(header, strict, numbers, particles, |field| place.clone().named(format!("{} {field}", row(n))))
        })?;
        file.found();
        Ok(())
    }

    /// Warns of bytes after the last point.
    fn behind(&mut self, file: &mut BinaryFile) -> Result<()> {
        let left = file.skip(BEHIND)?;
        if left > 0 {
            let (points, place) = (self.header.points, file.file());
            let warning = format!("{place}: {left} bytes follow the {points} points, whose number may be wrong");
            self.particles.skipped.assumed.push(warning);
        }
        Ok(())
    }
}

/// The numbers of a line, as in a record.
fn of_line(header: &PcdHeader, line: &Lines<&[u8]>) -> Result<Vec<f64>> {
    let (mut words, mut numbers) = (Words::of(line), Vec::new());
    for field in &header.fields {
        for _ in 0..field.count {
            let ends = || line.ends("point", "the line ends before the last field", "give every field");
            let word = words.next().ok_or_else(ends)?;
            match field.kind {
                PcdKind::Padding => {}
                PcdKind::Color => numbers.extend(levels(bits(word.number("rgb")?, field.scalar))),
                PcdKind::Numbers => numbers.push(word.number("point")?),
            }
        }
    }
    match words.next() {
        Some(word) => Err(line.fail(word.at, "point", "the line has more numbers than the fields", "correct COUNT")),
        None => Ok(numbers),
    }
}

/// Adds the point of these numbers, if it has coordinates; `place` gives the place of a field.
fn add(
    header: &PcdHeader,
    strict: bool,
    numbers: &[f64],
    particles: &mut Particles,
    place: impl Fn(&str) -> Place,
) -> Result<()> {
    let layout = &header.layout;
    let is_placed = (0..layout.len()).all(|k| !matches!(layout.role(k), Role::Position(_)) || numbers[k].is_finite());
    if !is_placed {
        return particles.skipped.skip("point without coordinates", strict, || place("point"));
    }
    layout.checked_numbers(numbers, particles, |error| relocate(error, |field| place(field)))
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

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb t _ n\nSIZE 4 8 4 4 2 1 4\nTYPE F F F U I U F\n\
        COUNT 1 1 1 1 1 3 2\nWIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\n";

    /// Three points, the second without coordinates.
    fn rows() -> [Vec<Vec<u8>>; 3] {
        [(1.5, 0xff0080, -3), (f32::NAN, 0, 0), (2.5, 0x00ff00, 7)].map(|(x, rgb, t): (f32, u32, i16)| {
            vec![
                x.to_le_bytes().to_vec(),
                0.1f64.to_le_bytes().to_vec(),
                (-x).to_le_bytes().to_vec(),
                rgb.to_le_bytes().to_vec(),
                t.to_le_bytes().to_vec(),
                vec![9; 3],
                [3f32, 4.0].iter().flat_map(|n| n.to_le_bytes()).collect(),
            ]
        })
    }

    fn binary() -> Vec<u8> {
        [format!("{HEAD}DATA binary\n").into_bytes(), rows().concat().concat()].concat()
    }

    /// The bytes without any copies.
    fn compressed() -> Vec<u8> {
        let rows = rows();
        let bytes: Vec<u8> = (0..7).flat_map(|field| rows.iter().flat_map(move |row| row[field].clone())).collect();
        let packed: Vec<u8> =
            bytes.chunks(32).flat_map(|run| [vec![run.len() as u8 - 1], run.to_vec()].concat()).collect();
        let sizes = [packed.len() as u32, bytes.len() as u32].map(u32::to_le_bytes).concat();
        [format!("{HEAD}DATA binary_compressed\n").into_bytes(), sizes, packed].concat()
    }

    fn read(bytes: &[u8], strict: bool) -> Result<Particles> {
        super::read(Source::of_bytes(bytes), &Request { strict, ..Request::of(&["t", "n"]) }).map(Particles::linearized)
    }

    #[test]
    fn the_three_encodings_hold_the_same_points() {
        let ascii = format!(
            "{HEAD}DATA ascii\n1.5 0.1 -1.5 16711808 -3 9 9 9 3 4\nnan nan nan 0 0 9 9 9 3 4\n2.5 0.1 -2.5 65280 7 9 9 9 3 4\n"
        );
        // A packed colour as a float: the bits of 0xff0080 are a denormal number.
        let float = ascii
            .replace("F F F U I", "F F F F I")
            .replace("16711808", "2.34182309e-38")
            .replace("65280", "9.14767638e-41");
        for bytes in [ascii.into_bytes(), float.into_bytes(), binary(), compressed()] {
            let found = read(&bytes, false).expect("points");
            assert_eq!(found.positions, [[1.5, 0.1, -1.5], [2.5, 0.1, -2.5]]);
            // IEC 61966-2-1 of 128/255.
            assert!(found.colors[0][..2] == [1.0, 0.0] && (found.colors[0][2] - 0.2158605).abs() < 1e-6);
            assert_eq!(found.colors[1], [0.0, 1.0, 0.0]);
            let columns: Vec<_> =
                found.columns.iter().map(|column| (column.name.as_str(), &column.values[..])).collect();
            let vector = [("n_x", &[3.0, 3.0][..]), ("n_y", &[4.0, 4.0]), ("n", &[5.0, 5.0])];
            assert_eq!(columns, [&[("t", &[-3.0, 7.0][..])][..], &vector].concat(), "a vector and its length");
            assert_eq!(found.skipped.kinds, [("point without coordinates", 1)]);
            let error = read(&bytes, true).map(drop).expect_err("strict").to_string();
            assert!(error.contains("point without coordinates"), "{error}");
        }
    }

    #[test]
    fn errors_are_reported() {
        let head =
            |from: &str, to: &str| format!("{}DATA ascii\n1 2 3 0 0 9 9 9 3 4\n", HEAD.replace(from, to)).into_bytes();
        let mut size = compressed();
        let at = size.len() - compressed().len() + format!("{HEAD}DATA binary_compressed\n").len();
        size[at + 4] ^= 1;
        let mut damaged = compressed();
        damaged[at + 8] = 200;
        for (bytes, expected) in [
            (HEAD.as_bytes().to_vec(), "the file ends within its header"),
            (head("FIELDS x", "FIELDS q"), "a point has no x"),
            (head("SIZE 4", "SIZE 3"), "TYPE of x: the type `F` of size `3`"),
            (head("COUNT 1 1 1 1 1 3 2", "COUNT 1"), ":6:1: COUNT: 7 fields have 1 words"),
            (head("COUNT 1", "COUNT 99999"), "COUNT of x: `99999`"),
            (head("POINTS 3", "POINTS three"), ":10:1: header: `POINTS three`"),
            (head("POINTS 3", "POINTS 99999999999"), "32-bit ids"),
            (head("VIEWPOINT", "VIEWED"), ":9:1: header: `VIEWED"),
            (head("FIELDS x y", "FIELDS x x"), "occurs twice"),
            (head("", ""), "the file ends after 1 of 3 points"),
            (head("POINTS 3", "POINTS 0"), "expected 0 points, found 1"),
            (format!("{HEAD}DATA zip\n").into_bytes(), ":11:1: header: `DATA zip`"),
            (format!("{HEAD}DATA ascii\n1 2 3\n").into_bytes(), ":12:6: point"),
            (format!("{HEAD}DATA ascii\n1 2 3 0 0 9 9 9 3 4 5\n").into_bytes(), ":12:21: point"),
            (binary()[..binary().len() - 1].to_vec(), "points: the file ends after 98 of 99 bytes"),
            (size, "do not match 3 points of 33 bytes"),
            (damaged, "points: they do not decompress to 99 bytes"),
        ] {
            let error = read(&bytes, false).map(drop).expect_err(expected).to_string();
            assert!(error.contains(expected), "{expected}: {error}");
        }
        let more = [binary(), vec![0; 5]].concat();
        let warnings = read(&more, false).expect("points").skipped.assumed;
        assert!(warnings.len() == 1 && warnings[0].contains("5 bytes follow the 3 points"), "{warnings:?}");
    }
}
