//! Tables: comma-, semicolon-, tab- or space-separated values under a header that names the columns. One reader with
//! two modes: tolerant for particle files, strict for `[[spheres]]`.
//!
//! The csv crate is not used: its record positions count the comments and blank lines before a record, and errors here
//! have the exact column. A number that spans lines is an error anyway.

mod names;

use super::layout::{Layout, Role, wanted};
use super::rows::rows;
use super::{ParticleFrames, Particles, Survey};
use crate::error::{Error, Result};
use crate::quote::quote;
use crate::read::input::Input;
use crate::read::lines::{Lines, Word};
use crate::read::options::ReadOptions;
use crate::read::source::SceneSource;
use names::{Axes, split};
use std::io::BufRead;

pub(crate) use names::axes;

/// Rows under a header.
pub(crate) struct Table<R> {
    lines: Lines<R>,
    layout: Layout,
    delimiter: u8,
    /// Whether the current line is a row that has not been parsed yet.
    ahead: bool,
}

impl<R: BufRead> Table<R> {
    /// A comma-separated table whose header is the first line with content; `role` gives the meaning of its names.
    pub(crate) fn strict(mut lines: Lines<R>, allowed: &str, role: impl Fn(&str) -> Option<Role>) -> Result<Self> {
        if !next(&mut lines)? {
            return Err(Error::scene(lines.file(), "the file is empty", format!("add a header: {allowed}")));
        }
        let mut layout = Layout::default();
        for word in fields(&lines, 0, b',') {
            let fail = |problem: String| Error::scene(lines.place(word.at).named("header"), problem, allowed);
            let role = role(word.text).ok_or_else(|| fail(format!("unknown column {}", quote(word.text))))?;
            layout.add(word.text, role, &[]).map_err(fail)?;
        }
        Ok(Self { lines, layout, delimiter: b',', ahead: false })
    }

    /// A table with any delimiter, other columns, and a header that may be a comment.
    fn tolerant(mut lines: Lines<R>, wanted: &[String]) -> Result<Self> {
        let mut header = None;
        let ahead = loop {
            if !lines.advance()? {
                break false;
            }
            let text = lines.text().trim_start();
            if text.is_empty() {
                continue;
            }
            let comment = text.len() - text.trim_start_matches('#').len();
            let start = lines.text().len() - text.len() + comment;
            if let Some(found) = TableHeader::of(&lines, start)? {
                header = Some(found);
                if comment == 0 {
                    // A second header line can only be a row; its first row shows which columns are text.
                    break next(&mut lines)?;
                }
            } else if comment == 0 {
                break true;
            }
        };
        let Some(mut header) = header else {
            let place = if ahead { lines.place(0) } else { lines.file() };
            let mend = "add a header that names x, y and z, such as x,y,z,radius";
            return Err(Error::scene(place.named("header"), "the columns x, y and z are missing", mend));
        };
        if ahead {
            // numpy.savetxt uses any separator between names.
            if header.comment && fields(&lines, 0, header.delimiter).count() < header.names.len() {
                header.delimiter = delimiter(lines.text());
            }
            for (word, (_, role)) in fields(&lines, 0, header.delimiter).zip(&mut header.names) {
                if *role == Role::Other && !word.text.is_empty() && word.text.parse::<f64>().is_err() {
                    *role = Role::Text;
                }
            }
        }
        let mut layout = Layout::default();
        for (name, role) in &header.names {
            let mend = "use each column name once";
            layout
                .add(name, *role, wanted)
                .map_err(|problem| Error::scene(header.place.clone().named("header"), problem, mend))?;
        }
        Ok(Self { lines, layout, delimiter: header.delimiter, ahead })
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
        row(&self.lines, self.delimiter, &self.layout, particles)?;
        Ok(true)
    }
}

impl Table<Input> {
    /// Adds all rows.
    fn all(mut self, survey: Option<&Survey>) -> Result<Particles> {
        let (layout, delimiter) = (self.layout, self.delimiter);
        let mut particles = layout.begin(survey);
        if self.ahead {
            row(&self.lines, delimiter, &layout, &mut particles)?;
        }
        rows(&mut self.lines, u64::MAX, &layout, &mut particles, |line, found| match has_content(line.text()) {
            true => row(line, delimiter, &layout, found),
            false => Ok(()),
        })?;
        particles.settle_texts();
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
            Err(Error::scene(lines.place(word.at).named("row"), problem, "use one field per column"))
        }
    }
}

/// Whether a line is neither blank nor a comment.
pub(crate) fn has_content(line: &str) -> bool {
    let text = line.trim_start();
    !text.is_empty() && !text.starts_with('#')
}

/// Moves to the next line with content.
fn next<R: BufRead>(lines: &mut Lines<R>) -> Result<bool> {
    while lines.advance()? {
        if has_content(lines.text()) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// A header that names the coordinates.
struct TableHeader {
    names: Vec<(String, Role)>,
    delimiter: u8,
    comment: bool,
    place: crate::error::Place,
}

impl TableHeader {
    /// The header that begins at this byte of the current line, if it is one.
    fn of<R: BufRead>(lines: &Lines<R>, start: usize) -> Result<Option<Self>> {
        let likely = delimiter(&lines.text()[start..]);
        for delimiter in [likely, b' '] {
            let names: Vec<String> = fields(lines, start, delimiter).map(|word| word.text.to_owned()).collect();
            let Some(axes) = axes(&names) else { continue };
            let place = lines.place(start);
            let mut roles: Vec<Role> = names.iter().map(|name| role(name, &axes)).collect();
            // Three components or none: an `r` alone is not a colour.
            let all = (0..3).all(|k| roles.contains(&Role::Color(k)));
            roles.iter_mut().filter(|role| matches!(role, Role::Color(_)) && !all).for_each(|r| *r = Role::Other);
            let lengths = |role| !matches!(role, Role::Radius | Role::Diameter);
            let odd = names.iter().find(|name| ["radius", "diameter"].contains(&split(name).0.as_str()));
            if let Some(odd) = odd.filter(|_| roles.iter().copied().all(lengths)) {
                let problem = format!("{} has another unit than the positions", quote(odd));
                let mend = "use the same unit for radii and positions, and the same name for it";
                return Err(Error::scene(place.named("header"), problem, mend));
            }
            let comment = start > 0 && lines.text()[..start].ends_with('#');
            return Ok(Some(Self { names: names.into_iter().zip(roles).collect(), delimiter, comment, place }));
        }
        Ok(None)
    }
}

/// The meaning of a column, where lengths have the unit of these axes.
fn role(name: &str, axes: &Axes) -> Role {
    if let Some(axis) = axes.of(name) {
        return Role::Position(axis);
    }
    let (base, unit) = split(name);
    match (base.as_str(), name.to_lowercase().as_str()) {
        ("radius", _) if unit == axes.unit => Role::Radius,
        ("diameter", _) if unit == axes.unit => Role::Diameter,
        (_, "r" | "red") => Role::Color(0),
        (_, "g" | "green") => Role::Color(1),
        (_, "b" | "blue") => Role::Color(2),
        (_, "element" | "symbol") => Role::Symbol,
        _ => Role::Other,
    }
}

/// The delimiter of a line.
pub(crate) fn delimiter(line: &str) -> u8 {
    [b'\t', b';', b','].into_iter().find(|delimiter| line.as_bytes().contains(delimiter)).unwrap_or(b' ')
}

/// The fields of the current line from a byte on, without padding and quotes.
pub(crate) fn fields<R: BufRead>(lines: &Lines<R>, start: usize, delimiter: u8) -> impl Iterator<Item = Word<'_, R>> {
    let text = lines.text().as_bytes();
    let blank = move |byte: &u8| byte.is_ascii_whitespace() && (*byte != delimiter || delimiter == b' ');
    let ends = move |byte: &u8| if delimiter == b' ' { byte.is_ascii_whitespace() } else { *byte == delimiter };
    let mut start = Some(start);
    std::iter::from_fn(move || {
        let raw = start?;
        let at = raw + text[raw..].iter().take_while(|byte| blank(byte)).count();
        if delimiter == b' ' && at == text.len() {
            return None;
        }
        let quoted = quoted(&text[at..]).filter(|length| {
            let after = text[at + length..].iter().find(|byte| !blank(byte) || ends(byte));
            after.is_none_or(ends)
        });
        let from = at + quoted.unwrap_or(0);
        let end = from + text[from..].iter().position(ends).unwrap_or(text.len() - from);
        start = (end < text.len()).then_some(end + 1);
        let (mut first, mut last) = match quoted {
            Some(length) => (at + 1, at + length - 1),
            None => (at, end),
        };
        while first < last && text[first].is_ascii_whitespace() {
            first += 1;
        }
        while first < last && text[last - 1].is_ascii_whitespace() {
            last -= 1;
        }
        let mut word = lines.word(first, last);
        word.at = at;
        Some(word)
    })
}

/// The length of the quoted text that begins here; a doubled quote is a quote.
fn quoted(text: &[u8]) -> Option<usize> {
    let mut at = 1;
    if text.first() != Some(&b'"') {
        return None;
    }
    loop {
        at += text[at..].iter().position(|byte| *byte == b'"')? + 1;
        if text.get(at) != Some(&b'"') {
            return Some(at);
        }
        at += 1;
    }
}

/// The single frame of a table, and where it is counted.
pub(super) struct OneTable(Option<Table<Input>>, Option<Survey>);

impl OneTable {
    pub(super) fn new(source: SceneSource, options: &ReadOptions) -> Result<Self> {
        let lines = Lines::new(source.reader, &source.path);
        Ok(Self(Some(Table::tolerant(lines, &wanted(&options.columns())?)?), options.survey.clone()))
    }
}

impl ParticleFrames for OneTable {
    fn next(&mut self) -> Result<Option<Particles>> {
        self.0.take().map(|table| table.all(self.1.as_ref())).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_frames;
    use super::*;

    fn read(text: &str, columns: &[&str]) -> Result<Particles> {
        Ok(read_frames(text, columns, OneTable::new)?.remove(0))
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

    #[test]
    fn errors_are_reported_with_line_and_column() {
        for (text, told) in [
            ("", "text: header: the columns x, y and z are missing"),
            ("1,2,3\n", ":1:1: header: the columns x, y and z are missing"),
            ("x_au,y_au,z_au,radius_km\n1,2,3,4\n", ":1:1: header: `radius_km` has another unit"),
            ("x,y,z,x\n1,2,3,4\n", ":1:1: header"),
            ("Points:0,Points:1,Points_2\n1,2,3\n", ":1:1: header: the columns x, y and z are missing"),
            ("Points:0,Points:1,Points:2,points:0\n1,2,3,4\n", ":1:1: header: `points:0` occurs twice"),
            ("x,y,z\n1,2\n", ":2:4: z: expected 3 fields, found 2"),
            ("x,y,z\n1,2,3,4\n", ":2:7: row: the row has more than"),
            ("x,y,z\n1,,3\n", ":2:3: y"),
            ("x,y,z,radius\n1,2,3,-4\n", ":2:7: radius: `-4`"),
            ("x,y,z,r,g,b\n1,2,3,0,-1,0\n", ":2:7: color"),
            ("x,y,z,t\n1,2,3,4\n1,2,3,n/a\n", ":3:7: t: `n/a`"),
        ] {
            let error = read(text, &["t"]).map(drop).expect_err(text).to_string();
            assert!(error.contains(told), "{error}");
        }
    }
}
