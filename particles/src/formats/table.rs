//! Tables: comma-, semicolon-, tab- or space-separated values under a header that names the columns. One reader with
//! two modes: tolerant for particle files, strict for `[[spheres]]`.
//!
//! The csv crate is not used: its record positions count the comments and blank lines before a record, and errors here
//! have the exact column.

pub mod fields;
mod header;
pub(crate) mod names;
pub(crate) mod signs;

use crate::format::{FormatRow, Has, Open, Sign};
use crate::input::Input;
use crate::lines::{Lines, has_content};
use crate::particles::frame::OneFrame;
use crate::particles::frame::Particles;
use crate::particles::layout::Layout;
use crate::particles::mixed::is_text;
use crate::particles::request::Request;
use crate::particles::role::Role;
use crate::particles::rows::rows;
use crate::source::Source;
use fields::{delimiter, fields, next};
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::quote;
use header::{Bare, TableHeader};
use signs::{is_csv, is_points, is_scan};
use std::io::BufRead;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

pub(crate) const CSV: FormatRow = FormatRow {
    name: "csv",
    about: "comma- or space-separated values with named columns",
    endings: &["tsv"],
    signs: &[Sign::Lines(is_csv)],
    has: &[Has::Blocks, Has::AnyColumns, Has::NamedColumns],
    open: Open::Frames(|source, request, _| {
        let table = Table::open(source, &request)?;
        Ok(Box::new(OneFrame::new(move || table.all())))
    }),
    ..FormatRow::PLAIN
};

pub(crate) const PTS: FormatRow = FormatRow {
    name: "pts",
    about: "points in lines of numbers, as laser scanners export them",
    signs: &[Sign::Lines(is_scan)],
    fits: Some(is_points),
    has: &[Has::Blocks, Has::AnyColumns, Has::NamedColumns],
    open: Open::Frame(|source, request| Table::points(source, request)?.all()),
    ..FormatRow::PLAIN
};

/// Rows under a header.
pub(crate) struct Table<R> {
    lines: Lines<R>,
    layout: Layout,
    delimiter: u8,
    /// Whether the current line is a row that has not been parsed yet.
    ahead: bool,
    /// Warnings about assumed meanings of columns, and about columns that are not taken.
    assumed: Vec<String>,
    /// The number of rows that the file gives in a line above, and its place.
    counted: Option<(Place, u64)>,
    /// Whether further scans, with their numbers of rows, may follow.
    has_scans: bool,
}

/// The column of the names of rows, as R calls them.
const ROW_NAMES: &str = "row.names";

impl<R: BufRead> Table<R> {
    /// A comma-separated table whose header is the first line with content; `role` gives the meaning of its names.
    pub(crate) fn strict(mut lines: Lines<R>, allowed: &str, role: impl Fn(&str) -> Option<Role>) -> Result<Self> {
        if !next(&mut lines)? {
            return Err(Error::scene(lines.file(), "the file is empty", format!("add a header: {allowed}")));
        }
        let mut layout = Layout::default();
        for word in fields(&lines, 0, b',') {
            let (name, fail) = (word.content(), |problem: String| lines.fail(word.at, "header", problem, allowed));
            let role = role(&name).ok_or_else(|| fail(format!("unknown column {}", quote(&*name))))?;
            layout.add(&name, role).map_err(fail)?;
        }
        Ok(Self { lines, layout, delimiter: b',', ahead: false, assumed: Vec::new(), counted: None, has_scans: false })
    }

    /// A table with any delimiter, other columns, and a header that may be a comment or missing. Without one, `bare` is what its columns are.
    fn tolerant(mut lines: Lines<R>, request: &Request, bare: Bare) -> Result<Self> {
        // Texts may have line breaks; strict tables have none.
        lines.set_records(0);
        let (mut header, ahead) = TableHeader::find(&mut lines, &request.columns_named, bare)?;
        if ahead {
            // numpy.savetxt uses any separator between names.
            if header.comment && !header.is_declared && fields(&lines, 0, header.delimiter).count() < header.names.len()
            {
                header.delimiter = delimiter(lines.text());
            }
            // R gives the names of rows no header. They are texts where coordinates would be, or numbers in quotes.
            let row: Vec<_> = fields(&lines, 0, header.delimiter).map(|word| word.text.parse::<f64>()).collect();
            let (is_number, is_quoted) =
                (matches!(row.first(), Some(Ok(_))), lines.text().trim_start().starts_with('"'));
            let is_placed = header.names.first().is_some_and(|(_, role)| role.is_checked());
            let is_named = if is_number { is_quoted } else { is_placed };
            if is_named && !header.comment && row.len() == header.names.len() + 1 {
                header.names.insert(0, (ROW_NAMES.to_owned(), Role::Text));
            }
            for (word, (_, role)) in fields(&lines, 0, header.delimiter).zip(&mut header.names) {
                if *role == Role::Other && is_text(word.text) {
                    *role = Role::Text;
                }
            }
        }
        let mut layout = Layout::new(request);
        for (name, role) in &header.names {
            let mend = "use each column name once";
            layout
                .add(name, *role)
                .map_err(|problem| Error::scene(header.place.clone().named("header"), problem, mend))?;
        }
        lines.set_records(header.delimiter);
        Ok(Self {
            lines,
            layout,
            delimiter: header.delimiter,
            ahead,
            assumed: header.assumed,
            counted: header.counted,
            has_scans: bare == Bare::Points,
        })
    }

    /// The lines; the current one is the row just read.
    pub(crate) fn lines(&self) -> &Lines<R> {
        &self.lines
    }

    /// The columns.
    pub(crate) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Adds the next row; `false` after the last.
    pub(crate) fn row(&mut self, particles: &mut Particles) -> Result<bool> {
        if !std::mem::take(&mut self.ahead) && !next(&mut self.lines)? {
            return Ok(false);
        }
        self.lines.check_utf8(usize::MAX)?;
        row(&self.lines, self.delimiter, &self.layout, particles)?;
        Ok(true)
    }
}

impl Table<Input> {
    /// The table of a file of particles.
    ///
    /// # Errors
    /// [`Error::Scene`] for a header that is not understood.
    pub(crate) fn open(source: Source, request: &Request) -> Result<Self> {
        Self::tolerant(Lines::new(source.reader, &source.path), request, Bare::Spheres)
    }

    /// The table of a file of points: lines of x, y, z, perhaps an intensity and perhaps red, green and blue, perhaps behind their
    /// number. A file may have several such scans.
    ///
    /// # Errors
    /// As [`Table::open`].
    pub(crate) fn points(source: Source, request: &Request) -> Result<Self> {
        Self::tolerant(Lines::new(source.reader, &source.path), request, Bare::Points)
    }

    /// The particles of all rows.
    ///
    /// # Errors
    /// [`Error::Scene`] with line and column.
    pub(crate) fn all(mut self) -> Result<Particles> {
        let (layout, delimiter) = (self.layout, self.delimiter);
        let mut particles = layout.begin();
        particles.skipped.assumed.extend(self.assumed);
        if self.ahead {
            row(&self.lines, delimiter, &layout, &mut particles)?;
        }
        let (counts, count) = (self.counted.is_some(), AtomicU64::new(self.ahead.into()));
        let (has_scans, further) = (counts && self.has_scans, AtomicU64::new(0));
        rows(&mut self.lines, u64::MAX, &layout, &mut particles, |line, found| match has_content(line.text()) {
            true => {
                if let (true, Ok(rows)) = (has_scans, line.text().trim().parse()) {
                    further.fetch_add(rows, Relaxed);
                    return Ok(());
                }
                if counts {
                    count.fetch_add(1, Relaxed);
                }
                row(line, delimiter, &layout, found)
            }
            false => Ok(()),
        })?;
        let (count, further) = (count.into_inner(), further.into_inner());
        let counted = self.counted.map(|(place, rows)| (place, rows.saturating_add(further)));
        if let Some((place, rows)) = counted.filter(|(_, rows)| *rows != count) {
            let warning = match further {
                0 => format!("{place}: {rows} stands alone in its line, but the table has {count} rows"),
                _ => format!("{place}: the numbers of the scans add up to {rows}, but there are {count} rows"),
            };
            particles.skipped.assumed.push(warning);
        }
        particles.settle_texts()?;
        Ok(particles)
    }
}

/// Adds the particle of the current line.
fn row<R: BufRead>(lines: &Lines<R>, delimiter: u8, layout: &Layout, particles: &mut Particles) -> Result<()> {
    let mut words = fields(lines, 0, delimiter);
    layout.row(&mut words, lines, particles)?;
    match words.next() {
        None => Ok(()),
        Some(word) => {
            let problem = format!("the row has more than the {} fields of the header", layout.len());
            Err(lines.fail(word.at, "row", problem, "use one field per column"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline_ground::quote::setting::COLUMNS;

    fn read(text: &str, columns: &[&str]) -> Result<Particles> {
        Table::open(Source::of_text(text), &Request::of(columns))?.all()
    }

    #[test]
    fn columns_are_found_by_name_whatever_separates_them() {
        for text in [
            "Name,Z,y,X,Radius,speed\n# a comment\n\n\"a, b\",3,2,1,0.5,7\n \"c\"\"d\" , 6 ,5,\"4\",1.5,8\n",
            "name;z;y;x;radius;speed\na, b;3;2;1;0.5;7\nc;6;5;4;1.5;8",
            "name\tz\ty\tx\tradius\tspeed\r\na b\t3\t2\t1\t0.5\t7\r\n\t6\t5\t4\t1.5\t8\r\n",
            "# name z y x  radius speed\na 3 2 1 0.5 7\n  c 6  5 4 1.5 8 \n",
            "# made by hand\n#name,z,y,x,radius,speed\na 3 2 1 0.5 7\nc 6 5 4 1.5 8\n",
            "# x, y and z\nname,z,y,x,diameter,speed\na,3,2,1,1,7\nc,6,5,4,3,8\n",
            "name,z (km),y (km),x (km),radius_km,speed\na,3,2,1,0.5,7\nc,6,5,4,1.5,8\n",
            "\"name\",\"Points:2\",\"Points:1\",\"Points:0\",\"Radius\",\"speed\"\na,3,2,1,0.5,7\nc,6,5,4,1.5,8\n",
            "name,Points:2,Points:1,Points:0,radius,speed\na,3,2,1,0.5,7\nc,6,5,4,1.5,8\n",
            "name,\"Points_0\",\"Points_1\",\"Points_2\",Points_Magnitude,radius,speed\na,1,2,3,9,0.5,7\nc,4,5,6,9,1.5,8\n",
            "name,x,y,z,Points:0,Points:1,Points:2,radius,speed\na,1,2,3,9,9,9,0.5,7\nc,4,5,6,9,9,9,1.5,8\n",
            "name,x,Points:0,Points:1,Points:2,radius,speed\na,9,1,2,3,0.5,7\nc,9,4,5,6,1.5,8\n",
        ] {
            let found = read(text, &["Speed"]).unwrap_or_else(|e| panic!("{e}: {text}"));
            assert_eq!(found.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "{text}");
            assert_eq!((&found.radii[..], &found.columns[0].values[..]), (&[0.5, 1.5][..], &[7.0, 8.0][..]), "{text}");
            assert!(found.has.contains(&"name".to_owned()), "{text}");
        }
    }

    #[test]
    fn colours_elements_and_what_is_missing() {
        let found = read("x y z red green blue element t\n1 2 3 0.5 1 0 Fe nan\n", &["t"]).expect("a table");
        assert_eq!((found.colors[0], found.elements[0]), ([0.5, 1.0, 0.0], 26));
        assert!(found.columns[0].values[0].is_nan());
        let found = read("x,y,z,r,t\n1,2,3,9,\n1,2,3,9,4\n", &["t", "r"]).expect("a table");
        assert!(found.colors.is_empty() && found.radii.is_empty(), "r alone is neither colour nor radius");
        let t = found.columns.iter().find(|column| column.name == "t").expect("t");
        assert!(t.values[0].is_nan() && t.values[1] == 4.0);
        assert!(read("x,y,z\n", &[]).expect("no rows").positions.is_empty());
    }

    fn named(text: &str, columns: &str) -> Result<Particles> {
        let columns_named = columns.parse()?;
        let options = Request { columns_named, ..Request::default() };
        Table::open(Source::of_text(text), &options)?.all()
    }

    #[test]
    fn columns_have_the_meaning_that_is_given() {
        for (text, columns) in [
            ("pos_x,pos_y,pos_z,a\n1,2,3,0.5\n4,5,6,1.5\n", "x=pos_x,y=pos_y,z=pos_z,radius=a"),
            ("x,y,z,u,v,w,a\n9,9,9,1,2,3,0.5\n9,9,9,4,5,6,1.5\n", "x=u,y=v,z=w,radius=a"),
            ("radius,x,y,z,half\n9,1,2,3,0.5\n9,4,5,6,1.5\n", "radius=half"),
            ("x,y,w,radius\n1,2,3,0.5\n4,5,6,1.5\n", "z=W"),
            ("# a b c d\n1 2 3 0.5\n4 5 6 1.5\n", "x=a,y=b,z=c,radius=d"),
            ("# a b c d\n1 2 3 0.5\n4 5 6 1.5\n", "x=1,y=2,z=3,radius=4"),
            ("# by hand\n1 2 3 0.5\n4 5 6 1.5\n", "x=1,y=2,z=3,radius=4"),
            ("s,a,b,c,d\nFe,1,2,3,1\nX,4,5,6,3\n", "x=2,y=3,z=4,diameter=5"),
            ("Fe;1;2;3;1\nX;4;5;6;3", "x=2,y=3,z=4,diameter=5"),
            ("3\t2\t1\t0.5\n6\t5\t4\t1.5\n", "x=3,y=2,z=1,radius=4"),
            ("3 2 1 0.5\n6 5 4 1.5\n", "x=3,y=2,z=1,radius=4"),
        ] {
            let found = named(text, columns).unwrap_or_else(|e| panic!("{e}: {text}"));
            assert_eq!(found.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "{text}");
            assert_eq!((&found.radii[..], found.skipped.assumed.len()), (&[0.5, 1.5][..], 0), "{text}");
        }
        let found = named("Fe 1 2 3 0 1 0.5\n", "element=1,x=2,y=3,z=4,r=5,g=6,b=7").expect("a row");
        assert_eq!((found.elements[0], found.colors[0]), (26, [0.0, 1.0, 0.5]));
        for (text, columns, message) in [
            (
                "a,b,c\n1,2,3\n",
                "x=a,y=b,z=d",
                ":1:1: header: the table has no column `d`; correct `\u{2060}columns`; the columns are a, b, c",
            ),
            ("a,b,c\n1,2,3\n", "x=1,y=2,z=7", "column 7 is named, but the table has 3"),
            ("1,2,3\n", "x=1,y=2,z=7", "column 7 is named, but the table has 3"),
            ("1,2,3\n", "x=a,y=b,z=c", "no column `a`"),
            ("a,b,c\n1,2,3\n", "x=a,y=b", "the columns x, y and z are missing"),
            ("x,y,z,r\n1,2,3,4\n", "radius=size", "no column `size`"),
            ("1,2,n/a\n", "x=1,y=2,z=3", ":1:5: z: `n/a` is not a number"),
            ("", "x=1,y=2,z=3", "the columns x, y and z are missing"),
        ] {
            let error = named(text, columns).map(drop).expect_err(text).to_string();
            assert!(error.contains(message), "{error}");
        }
    }

    #[test]
    fn invalid_rows_are_left_out_and_counted() {
        let options = Request { skip_invalid: true, ..Request::default() };
        let read = |text: &str| -> Result<Particles> { Table::open(Source::of_text(text), &options)?.all() };
        let text = "name,x,y,z,radius\na,1,2,3,1\n\nb,nan,2,3,1\nc,4,5,6,0\nd,,5,6,1\ne,7,8,inf,1\nf,7,8,9,2\n";
        let found = read(text).expect("rows");
        assert_eq!(
            (&found.positions[..], &found.radii[..]),
            (&[[1.0, 2.0, 3.0], [7.0, 8.0, 9.0]][..], &[1.0, 2.0][..])
        );
        assert_eq!(found.skipped.assumed, ["4 rows left out, the first in line 4: x: `nan` is not finite"]);
        // Other faults are errors still.
        for (text, message) in [
            ("x,y,z,t\nnan,2,3\n", ":2:1: x: `nan` is not finite"),
            ("x,y,z\nnan,2,3,4\n", ":2:9: row: the row has more"),
            ("x,y,z,r,g,b\n1,2,3,-1,0,0\n", ":2:7: color"),
        ] {
            let error = read(text).map(drop).expect_err(text).to_string();
            assert!(error.contains(message), "{error}");
        }
    }

    #[test]
    fn three_or_four_numbers_without_a_header_are_assumed_to_be_coordinates_and_a_radius() {
        for (text, radii, what) in [
            ("1,2,3\n4,5,6\n", &[][..], "x, y and z"),
            ("# by hand\n1 2 3 0.5\n4 5 6 1.5\n", &[0.5, 1.5], "x, y, z and radius"),
        ] {
            let found = read(text, &[]).expect("rows");
            assert_eq!((&found.positions[..], &found.radii[..]), (&[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]][..], radii));
            let [warning] = &found.skipped.assumed[..] else { panic!("{:?}", found.skipped.assumed) };
            assert!(warning.contains(&format!("are read as {what}; name them with {COLUMNS}")), "{warning}");
        }
    }

    #[test]
    fn points_have_the_columns_of_their_number() {
        let read = |text: &str| {
            let request = Request::of(&["intensity", "column_4"]);
            Table::points(Source::of_text(text), &request).and_then(Table::all).map(Particles::linearized)
        };
        let colors = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        for (text, colored, column) in [
            ("1 2 3\n4 5 6\n", false, None),
            ("2\n1 2 3\n4 5 6\n", false, None),
            ("2\n1 2 3 -9\n4 5 6 7\n", false, Some("intensity")),
            ("1,2,3,-9\n4,5,6,7\n", false, Some("intensity")),
            ("2\n1 2 3 255 0 0\n4 5 6 0 0 255\n", true, None),
            ("2\n1 2 3 -9 255 0 0\n4 5 6 7 0 0 255\n", true, Some("intensity")),
            ("1\n1 2 3 -9 255 0 0\n1\n4 5 6 7 0 0 255\n", true, Some("intensity")),
            ("1 2 3 -9 0 0.5\n4 5 6 7 1 0\n", false, Some("column_4")),
            ("//X Y Z Intensity\n1 2 3 -9\n4 5 6 7\n", false, Some("intensity")),
        ] {
            let found = read(text).unwrap_or_else(|error| panic!("{error}: {text}"));
            assert_eq!(found.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "{text}");
            assert_eq!(found.colors, if colored { &colors[..] } else { &[] }, "{text}");
            let values = found.columns.iter().map(|found| (found.name.as_str(), &found.values[..]));
            assert!(values.eq(column.map(|name| (name, &[-9.0, 7.0][..]))), "{text}: {:?}", found.columns);
            assert!(found.radii.is_empty(), "the fourth number is no radius");
        }
        for text in ["1\n1 2 3 0 -1 0 0\n", "1 2 3 -1 0 0\n"] {
            let found = read(text).expect("a point");
            let [warning] = &found.skipped.assumed[..] else { panic!("{text}: {:?}", found.skipped.assumed) };
            assert!(found.colors.is_empty() && warning.contains("(-1 0 0) are no levels of a colour"), "{warning}");
        }
        for (text, warning) in [
            ("3\n1 2 3\n4 5 6\n", "3 stands alone in its line, but the table has 2 rows"),
            ("1\n1 2 3\n2\n4 5 6\n", "the numbers of the scans add up to 3, but there are 2 rows"),
        ] {
            let assumed = read(text).expect("rows").skipped.assumed;
            assert!(assumed.len() == 1 && assumed[0].contains(warning), "{assumed:?}");
        }
        for (text, message) in [
            ("1 2 3 4 5\n", ":1:1: header: the columns x, y and z are missing"),
            ("1 2 3\n4 5\n", ":2:4: z: expected 3 fields, found 2"),
            ("1 2 3\n4\n", ":2:2: y: expected 3 fields, found 1"),
            ("1 2 3 1 2 3\n4 5 6 -1 0 0\n", ":2:7: color"),
        ] {
            let error = read(text).map(drop).expect_err(text).to_string();
            assert!(error.contains(message), "{error}");
        }
    }

    #[test]
    fn errors_are_reported_with_line_and_column() {
        for (text, message) in [
            ("", "text: header: the columns x, y and z are missing"),
            ("1,2\n", ":1:1: header: the columns x, y and z are missing"),
            ("1,2,3,4,5\n", "or name the columns with `\u{2060}columns` x=1,y=2,z=3"),
            ("a,b,c\n1,2,3\n", ":1:1: header: the columns x, y and z are missing"),
            ("1,2,3\n4,5,6,7\n", ":2:7: row: the row has more than the 3 fields"),
            ("1 2 3 -1\n", ":1:7: radius: `-1`"),
            ("x_au,y_au,z_au,radius_km\n1,2,3,4\n", ":1:1: header: `radius_km` has another unit"),
            ("x,y,z,x\n1,2,3,4\n", ":1:1: header"),
            ("Points:0,Points:1,Points_2\n1,2,3\n", ":1:1: header: the columns x, y and z are missing"),
            ("Points:0,Points:1,Points:2,points:0\n1,2,3,4\n", ":1:1: header: `points:0` occurs twice"),
            ("x,y,z\n1,2\n", ":2:4: z: expected 3 fields, found 2"),
            ("x,y,z\n1,2,3,4\n", ":2:7: row: the row has more than"),
            ("x,y,z\n1,,3\n", ":2:3: y"),
            ("x,y,z,radius\n1,2,3,-4\n", ":2:7: radius: `-4`"),
            ("x,y,z,r,g,b\n1,2,3,0,-1,0\n", ":2:7: color"),
        ] {
            let error = read(text, &["t"]).map(drop).expect_err(text).to_string();
            assert!(error.contains(message), "{error}");
        }
    }
}
