//! PTX, as Leica Cyclone exports scans: the numbers of columns and rows, the place and the axes of the scanner, a matrix of four rows, and
//! a point for each cell of the scan; scan after scan. Points are row vectors and the matrix is applied from the right. A cell
//! without a return has the point 0 0 0, which is counted and left out.

use crate::format::{FormatRow, Has, Open, Sign};
use crate::input::Input;
use crate::lines::{Lines, Words};
use crate::particles::frame::Particles;
use crate::particles::layout::Layout;
use crate::particles::points::{self, PointColumns};
use crate::particles::request::Request;
use crate::particles::rows::rows;
use crate::source::Source;
use halfline_ground::error::Result;
use halfline_ground::memory::check_ids;
use std::io::BufRead;

pub(crate) const PTX: FormatRow = FormatRow {
    name: "ptx",
    about: "scans of Leica Cyclone",
    signs: &[Sign::Structure(is_ptx)],
    has: &[Has::Blocks, Has::AnyColumns],
    open: Open::Frame(read).optional(),
    ..FormatRow::PLAIN
};

/// The remedies for a damaged header, and for a file that ends within a scan.
const HEADER: &str = "a scan begins with its columns, its rows, 4 rows of 3 numbers and 4 rows of 4";
const CUT: &str = "give a point for each cell of the scan, or correct its columns and rows";

/// The header of a scan.
struct Scan {
    /// Cells.
    count: u64,
    matrix: [[f64; 4]; 4],
}

/// Reads all scans.
///
/// # Errors
/// [`Error::Scene`](halfline_ground::error::Error::Scene) with line and column.
pub(crate) fn read(source: Source, request: &Request) -> Result<Particles> {
    let mut lines = Lines::new(source.reader, &source.path);
    let mut layout = Layout::new(request);
    let mut particles = Particles::default();
    while let Some(scan) = scan(&mut lines)? {
        let mut left = scan.count;
        if layout.len() == 0 && left > 0 {
            lines.need("point", CUT)?;
            layout = columns(&lines, request)?;
            particles = layout.begin();
            scan.point(&lines, &layout, request.strict, &mut particles)?;
            left -= 1;
        }
        let row = |line: &Lines<&[u8]>, found: &mut Particles| scan.point(line, &layout, request.strict, found);
        if rows(&mut lines, left, &layout, &mut particles, row)? < left {
            return Err(lines.cut("point", CUT));
        }
    }
    particles.settle_texts()?;
    Ok(particles)
}

impl Scan {
    /// Adds the point of the current line, or counts a cell without a return.
    fn point<R: BufRead>(&self, line: &Lines<R>, layout: &Layout, strict: bool, found: &mut Particles) -> Result<()> {
        let mut words = Words::of(line);
        if words.clone().take(3).filter(|word| word.text.parse() == Ok(0.0)).count() == 3 {
            return found.skipped.skip("cell without a return", strict, || line.place(0));
        }
        let before = found.positions.len();
        layout.row(&mut words, line, found)?;
        if let Some(word) = words.next() {
            let problem = format!("the point has more than the {} numbers of the first", layout.len());
            return Err(line.fail(word.at, "point", problem, "give each point as many numbers as the first"));
        }
        found.positions[before..].iter_mut().for_each(|point| *point = placed(*point, &self.matrix));
        Ok(())
    }
}

/// A point of the scanner in the world: of each coordinate the products with x, y and z are added in this order, and then the
/// translation, each operation rounded to f64.
fn placed([x, y, z]: [f64; 3], m: &[[f64; 4]; 4]) -> [f64; 3] {
    [0, 1, 2].map(|k| x * m[0][k] + y * m[1][k] + z * m[2][k] + m[3][k])
}

/// The header of the next scan; `None` at the end of the file.
fn scan(lines: &mut Lines<Input>) -> Result<Option<Scan>> {
    while lines.advance()? {
        if lines.text().trim().is_empty() {
            continue;
        }
        let columns = lines.count("columns", HEADER)?;
        lines.need("rows", HEADER)?;
        let count = columns.saturating_mul(lines.count("rows", HEADER)?);
        check_ids(count)?;
        for field in ["scanner", "axis x", "axis y", "axis z"] {
            numbers::<3>(lines, field)?;
        }
        let mut matrix = [[0.0; 4]; 4];
        for row in &mut matrix {
            *row = numbers(lines, "matrix")?;
        }
        return Ok(Some(Scan { count, matrix }));
    }
    Ok(None)
}

/// The numbers of the next line.
fn numbers<const N: usize>(lines: &mut Lines<Input>, field: &str) -> Result<[f64; N]> {
    lines.need(field, HEADER)?;
    let mut words = Words::of(lines);
    let mut found = [0.0; N];
    for (k, number) in found.iter_mut().enumerate() {
        let few = || lines.ends(field, format!("expected {N} numbers, found {k}"), HEADER);
        *number = words.next().ok_or_else(few)?.finite(field)?;
    }
    match words.next() {
        Some(word) => Err(lines.fail(word.at, field, format!("expected {N} numbers, found more"), HEADER)),
        None => Ok(found),
    }
}

/// The columns, by the first point.
fn columns(lines: &Lines<Input>, request: &Request) -> Result<Layout> {
    let mut layout = Layout::new(request);
    let names = points::columns(Words::of(lines).map(|word| word.text));
    let names = names.filter(|found| [4, 7].contains(&found.names.len()));
    let wrong = |problem: String| {
        lines.fail(0, "point", problem, "a point is x y z intensity, or x y z intensity red green blue")
    };
    let PointColumns { names, warning } =
        names.ok_or_else(|| wrong("the point has neither 4 nor 7 numbers".to_owned()))?;
    for (name, role) in names {
        layout.add(&name, role).map_err(wrong)?;
    }
    warning.into_iter().for_each(|warning| layout.warn(warning));
    Ok(layout)
}

/// Two counts, the place and the three axes of the scanner, and a matrix of four rows.
fn is_ptx(lines: &[&str]) -> bool {
    let numbers = |line: &&str| {
        let words: Vec<bool> = line.split_whitespace().map(|word| word.parse::<f64>().is_ok()).collect();
        words.len() * usize::from(words.iter().all(|is_number| *is_number))
    };
    lines.len() >= 10 && lines[..10].iter().map(numbers).eq([1, 1, 3, 3, 3, 3, 4, 4, 4, 4])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two cells of a scan that is turned by 90 degrees about z and moved, with these points.
    fn file(points: &str) -> String {
        format!("1\n2\n9 9 9\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n{points}")
    }

    fn read(text: &str, strict: bool) -> Result<Particles> {
        super::read(Source::of_text(text), &Request { strict, ..Request::of(&["intensity"]) })
            .map(Particles::linearized)
    }

    #[test]
    fn scans_are_moved_into_the_world_and_cells_without_a_return_are_left_out() {
        let text =
            file("1 2 3 0.5 255 0 0\n0 0 0 0.5 0 0 0\n") + "\n" + &file("0.1 -0.0 0 0.25 0 255 0\n-0 0.0 0 0 0 0 0\n");
        let found = read(&text, false).expect("scans");
        // (x, y) becomes (-y, x); -y of -0.0 is 0.0, and adding does not change the other numbers.
        assert_eq!(found.positions, [[8.0, 21.0, 33.0], [10.0, 0.1 + 20.0, 30.0]]);
        assert_eq!(found.columns[0].values, [0.5, 0.25]);
        assert_eq!(found.colors, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(found.skipped.kinds, [("cell without a return", 2)]);
        let error = read(&text, true).map(drop).expect_err("strict").to_string();
        assert!(error.contains(":12:1: expected a sphere, found a cell without a return"), "{error}");
    }

    #[test]
    fn products_are_added_in_the_order_of_the_coordinates() {
        // 2^53 + 1 - 2^53 is 0 in this order of f64, and 1 in others.
        let matrix = [[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [1.0, 0.0, 1.0, 0.0], [0.25, 0.0, 0.0, 1.0]];
        let big = 2f64.powi(53);
        assert_eq!(placed([big, 1.0, -big], &matrix)[0], 0.25);
        assert_eq!(placed([big, -big, 1.0], &matrix)[0], 1.25);
    }

    #[test]
    fn errors_are_reported() {
        for (text, expected) in [
            ("1\n", ":1:1: rows: the file ends"),
            ("one\n2\n", ":1:1: columns: `one` is not a number"),
            ("1\n2\n0 0\n", ":3:4: scanner: expected 3 numbers, found 2"),
            (&file("").replace("0 1 0 0", "0 1 0 0 0"), ":7:9: matrix: expected 4 numbers, found more"),
            (&file("").replace("10 20", "inf 20"), ":10:1: matrix: `inf` is not finite"),
            (&file(""), ":10:1: point: the file ends within a frame"),
            (&file("1 2 3\n"), ":11:1: point: the point has neither 4 nor 7 numbers"),
            (&file("1 2 3 4\n"), "point: the file ends within a frame"),
            (&file("1 2 3 4\n1 2 3\n"), ":12:6: intensity: expected 4 fields, found 3"),
            (&file("1 2 3 4\n1 2 3 4 5\n"), ":12:9: point: the point has more than the 4 numbers"),
            (&file("1 2 3 4\n1 2 nan 4\n"), ":12:5: z: `nan` is not finite"),
            (&file("1 2 3 4\n1 2 3 4\n5 6 7 8\n"), ":13:1: columns: `5 6 7 8` is not a number"),
            (&file("1 2 3 4\n").replacen("1\n2", "4294967296\n4294967296", 1), "ids"),
        ] {
            let error = read(text, false).map(drop).expect_err(expected).to_string();
            assert!(error.contains(expected), "{expected}: {error}");
        }
    }
}
