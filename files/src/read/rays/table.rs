//! Rays from text: one per line, separated by commas, semicolons, tabs or blanks. A header, also behind `#`, may name
//! the columns in any order; without one they are in the order of a row. Blank lines and lines that begin with `#` are
//! ignored.

use super::block::{COLUMNS, REQUIRED, RayBlock, RayOptions, Row, flaw, mend_row};
use halfline::error::{Error, Result};
use halfline::parallel;
use halfline_particles::formats::table::fields::{declared_delimiter, delimiter, each_number, fields, named_columns};
use halfline_particles::input::Input;
use halfline_particles::lines::{Block, Lines, has_content};
use std::io::BufRead;
use std::path::Path;

const MEND: &str = "use the columns ox, oy, oz, dx, dy, dz and optionally tmax";

pub(super) struct RayTable {
    lines: Lines<Input>,
    form: Form,
    /// Whether the current line is a row that has not been parsed yet.
    ahead: bool,
    text: Block,
}

/// The form of the rows.
struct Form {
    /// For each column of the file, its index in [`COLUMNS`].
    places: Vec<usize>,
    delimiter: u8,
}

impl RayTable {
    pub(super) fn open(reader: Input, path: &Path) -> Result<Self> {
        let mut lines = Lines::new(reader, path);
        let (mut places, mut ahead, mut declared) = (None, false, None);
        while !ahead && lines.advance()? {
            if let (None, None, Some(delimiter)) = (&places, declared, declared_delimiter(lines.text())) {
                declared = Some(delimiter);
                continue;
            }
            let of_line = |text: &str| declared.unwrap_or_else(|| delimiter(text));
            let is_row = has_content(lines.text());
            if places.is_some() {
                // The row after the header shows the delimiter: numpy.savetxt uses any one in its header.
                ahead = is_row;
            } else if is_row && fields(&lines, 0, of_line(lines.text())).next().is_some_and(|word| is_number(word.text))
            {
                ahead = true;
            } else {
                let mark = lines.text().find(|c: char| c != '#' && !c.is_whitespace());
                let start = if is_row { 0 } else { mark.unwrap_or_default() };
                let header = named(&lines, start, of_line(&lines.text()[start..]));
                places = if is_row { Some(header?) } else { header.ok() };
            }
        }
        if !ahead && places.is_none() {
            return Err(Error::scene(lines.file(), "the file has no rays", MEND));
        }
        let delimiter = declared.unwrap_or_else(|| delimiter(lines.text()));
        let places = match places {
            Some(places) => places,
            None => match fields(&lines, 0, delimiter).count() {
                count @ (6 | 7) => (0..count).collect(),
                count => {
                    let problem = format!("found {count} numbers in a row, expected 6 or 7");
                    return Err(Error::scene(lines.place(0), problem, MEND));
                }
            },
        };
        Ok(Self { lines, form: Form { places, delimiter }, ahead, text: Block::default() })
    }

    /// The next rows, at most `most`, counting those that are left out as invalid; an empty block after the last.
    pub(super) fn block(&mut self, most: usize, options: &RayOptions) -> Result<RayBlock> {
        let mut block = RayBlock::default();
        if std::mem::take(&mut self.ahead) {
            self.form.read(&self.lines, options, &mut block)?;
        }
        while block.rows() < most {
            options.watch.check()?;
            self.lines.block((most - block.rows()) as u64, &mut self.text)?;
            if self.text.is_empty() {
                break;
            }
            let before = block.rows();
            let mut parts = self.text.parts();
            let parts = parallel::blocks(&mut parts[..], 1, &|_, part| self.form.part(&mut part[0], options));
            parts.into_iter().try_for_each(|part| part.map(|part| block.append(part)))?;
            if block.rows() > before {
                self.lines.found();
            }
        }
        Ok(block)
    }
}

impl Form {
    /// The rows of some lines.
    fn part(&self, lines: &mut Lines<&[u8]>, options: &RayOptions) -> Result<RayBlock> {
        let mut block = RayBlock::default();
        while lines.advance()? {
            if has_content(lines.text()) {
                self.read(lines, options, &mut block)?;
            }
        }
        Ok(block)
    }

    /// Adds the row in the current line.
    fn read<R: BufRead>(&self, lines: &Lines<R>, options: &RayOptions, block: &mut RayBlock) -> Result<()> {
        match self.row(lines) {
            Ok(row) => block.push(row, self.places.len() > REQUIRED),
            Err(Error::Scene { place, problem, source, .. }) => {
                block.leave_out(options, || Error::Scene { place, problem, mend: mend_row(), source })?
            }
            Err(other) => return Err(other),
        }
        Ok(())
    }

    fn row<R: BufRead>(&self, lines: &Lines<R>) -> Result<Row> {
        let mut row = [f64::INFINITY; 7];
        each_number(lines, self.delimiter, (&self.places, &COLUMNS), MEND, |column, word| {
            row[column] = word.number(COLUMNS[column])?;
            Ok(())
        })?;
        match flaw(&row) {
            None => Ok(row),
            Some((field, problem)) => Err(Error::scene(lines.place(0).named(field), problem, MEND)),
        }
    }
}

fn is_number(text: &str) -> bool {
    text.parse::<f64>().is_ok()
}

/// For each name in the header that begins at byte `start` of the current line, its index in [`COLUMNS`].
fn named<R: BufRead>(lines: &Lines<R>, start: usize, delimiter: u8) -> Result<Vec<usize>> {
    let places = named_columns(lines, (start, delimiter), &COLUMNS, MEND)?;
    match (0..REQUIRED).find(|place| !places.contains(place)) {
        Some(missing) => {
            let problem = format!("column `{}` is missing", COLUMNS[missing]);
            Err(Error::scene(lines.place(start).named("header"), problem, MEND))
        }
        None => Ok(places),
    }
}
