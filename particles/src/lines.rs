//! Text line by line, with the place of every byte. The line-based formats share it for line ends and
//! bytes that are not UTF-8, and tables for records of several lines.

mod quotes;
mod text;

use super::input::Input;
use crate::blocks;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::check_ids;
use halfline_ground::quote::quote;
use halfline_ground::quote::setting::FORMAT;
pub(super) use quotes::{DELIMITERS, Quotes, ends};
use std::borrow::Cow;
use std::collections::VecDeque;
use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};
use text::{IDLE, UTF8, not_utf8_text, too_idle};
pub use text::{check_idle, comment, has_content, mend_number, not_utf8};

/// The most bytes in a line, so that a file without lines does not fill the memory.
const LONGEST: u64 = 1 << 20;

/// The most bytes in a record of several lines.
const LONGEST_RECORD: usize = 1 << 16;

/// The approximate bytes in a block of lines, and in one of its parts. They are constants, so that results do not
/// depend on the number of cores.
const BLOCK: usize = 2 << 20;
const PART: usize = 64 << 10;

/// Reads one line at a time into a reused buffer.
pub struct Lines<R> {
    reader: R,
    path: PathBuf,
    text: String,
    number: u64,
    /// Whether columns are bytes.
    fixed: bool,
    /// The byte that ends a line.
    end: u8,
    /// The separator of the fields of records of several lines, 0 where it is not known yet; `None` for lines.
    records: Option<u8>,
    /// The first byte of the line that was not UTF-8.
    invalid: Option<usize>,
    /// Bytes that were read too far.
    ahead: VecDeque<u8>,
    /// Whether the current line is the next one too.
    again: bool,
    /// The lines before that are blank or comments.
    idle: u64,
}

impl<R: BufRead> Lines<R> {
    pub fn new(reader: R, path: &Path) -> Self {
        let (path, text) = (path.to_path_buf(), String::new());
        Self {
            reader,
            path,
            text,
            number: 0,
            fixed: false,
            end: b'\n',
            records: None,
            invalid: None,
            ahead: VecDeque::new(),
            again: false,
            idle: 0,
        }
    }

    /// Columns are bytes: a line that is not UTF-8 has a question mark for each byte that is not ASCII, so that columns stay in
    /// place. Other lines then have the letter of ISO 8859-1 for each such byte, so that words that differ stay different.
    /// Formats older than UTF-8 contain names of people in such encodings, and otherwise ASCII.
    pub(super) fn of_columns(mut self) -> Self {
        self.fixed = true;
        self
    }

    /// A record is of all lines that a quoted field goes on in, unless they have more than 65,536 bytes. What separates the fields
    /// is 0 where it is not known yet.
    pub(super) fn set_records(&mut self, separator: u8) {
        self.records = Some(separator);
    }

    /// Carriage returns end lines.
    pub(super) fn of_returns(mut self) -> Self {
        self.end = b'\r';
        self
    }

    /// Lets the next [`Lines::advance`], or [`Lines::block`], find the current line again.
    pub(super) fn give_back(&mut self) {
        self.again = true;
    }

    /// Reads the next line; returns false at the end of the file, where the last line is kept.
    pub fn advance(&mut self) -> Result<bool> {
        if std::mem::take(&mut self.again) {
            return Ok(true);
        }
        let mut bytes = std::mem::take(&mut self.text).into_bytes();
        bytes.clear();
        let lines = self.record(&mut bytes)?;
        if lines == 0 {
            return Ok(false);
        }
        self.number += lines;
        if bytes.len() as u64 == LONGEST && !bytes.ends_with(&[self.end]) {
            let problem = format!("the line is longer than {LONGEST} bytes");
            return Err(Error::scene(
                self.file().at(self.number, 1),
                problem,
                format!("check the format of the file, or set it with {FORMAT}"),
            ));
        }
        self.invalid = None;
        self.text = String::from_utf8(bytes).unwrap_or_else(|error| {
            self.invalid = Some(error.utf8_error().valid_up_to());
            self.letters(error.as_bytes())
        });
        let kept = self.text.trim_end_matches(['\n', '\r']).len();
        self.text.truncate(kept);
        self.rest(u64::from(!has_content(&self.text)))?;
        Ok(true)
    }

    /// Counts lines without content, or for 0 one with content.
    ///
    /// # Errors
    /// [`Error::Limits`] for too many of them in a row.
    pub(super) fn rest(&mut self, lines: u64) -> Result<()> {
        self.idle = if lines == 0 { 0 } else { self.idle + lines };
        if self.idle <= IDLE { Ok(()) } else { Err(too_idle(&self.place(0))) }
    }

    /// The letters of bytes that are not UTF-8.
    fn letters(&self, bytes: &[u8]) -> String {
        if self.fixed {
            return bytes.iter().map(|byte| if byte.is_ascii() { char::from(*byte) } else { '?' }).collect();
        }
        let mut text = String::new();
        for chunk in bytes.utf8_chunks() {
            text.push_str(chunk.valid());
            text.extend(chunk.invalid().iter().map(|byte| char::from(*byte)));
        }
        text
    }

    /// Refuses the current line if it is not UTF-8 before a byte, where a comment may begin.
    ///
    /// # Errors
    /// [`Error::Scene`] at the first byte that is not.
    pub fn check_utf8(&self, end: usize) -> Result<()> {
        let Some(at) = self.invalid.filter(|at| *at < end) else { return Ok(()) };
        let byte = self.text[at..].chars().next().map_or(0, u32::from);
        Err(Error::scene(self.place(at), not_utf8_text(byte as u8), UTF8))
    }

    /// Appends the next line; returns its length.
    fn line(&mut self, bytes: &mut Vec<u8>) -> Result<usize> {
        if !self.ahead.is_empty() {
            let end = self.ahead.iter().position(|byte| *byte == self.end).map_or(self.ahead.len(), |at| at + 1);
            bytes.extend(self.ahead.drain(..end));
            return Ok(end);
        }
        let mut line = (&mut self.reader).take(LONGEST);
        line.read_until(self.end, bytes).map_err(|e| Error::read(&self.path, e))
    }

    /// Appends the next line, with those that it continues on; returns their number.
    fn record(&mut self, bytes: &mut Vec<u8>) -> Result<u64> {
        let begin = bytes.len();
        let first = self.line(bytes)?;
        let Some(separator) = self.records.filter(|_| bytes[begin..].contains(&b'"')) else {
            return Ok(u64::from(first > 0));
        };
        let is_record = has_content(&String::from_utf8_lossy(&bytes[begin..]));
        let (mut quotes, mut lines, mut last) = (is_record.then(|| Quotes::of(separator)), 1, begin);
        while let Some(quotes) = &mut quotes
            && bytes.len() - begin < LONGEST_RECORD
        {
            match quotes.are_open(&bytes[last..]) {
                Some(false) => return Ok(lines),
                Some(true) => last = bytes.len(),
                None => break,
            }
            if self.line(bytes)? == 0 {
                break;
            }
            lines += 1;
        }
        // No record of several lines begins here, so it is a line.
        for byte in bytes.drain(begin + first..).rev() {
            self.ahead.push_front(byte);
        }
        Ok(1)
    }

    /// Reads `most` lines into `block`, fewer where the file ends or the block is full. The last of them becomes the
    /// current line; whether lines contain data is determined when the parts are read.
    pub fn block(&mut self, most: u64, block: &mut Block) -> Result<()> {
        block.bytes.clear();
        block.parts.clear();
        (block.path, block.fixed, block.lines) = (self.path.clone(), self.fixed, 0);
        (block.end, block.records) = (self.end, self.records);
        let (mut part, mut last, mut before) = (0, 0, self.number);
        if most > 0 && std::mem::take(&mut self.again) {
            block.bytes.extend(self.text.as_bytes());
            block.bytes.push(self.end);
            block.lines = 1 + self.text.bytes().filter(|byte| *byte == self.end).count() as u64;
            before -= block.lines;
            block.parts.push((0, before));
        }
        while block.lines < most && block.bytes.len() < blocks::at_most(BLOCK) {
            if block.bytes.len() >= part + blocks::at_most(PART) || block.lines == 0 {
                part = block.bytes.len();
                block.parts.push((part, before + block.lines));
            }
            let begin = block.bytes.len();
            let lines = self.record(&mut block.bytes)?;
            if lines == 0 {
                break;
            }
            (last, block.lines) = (begin, block.lines + lines);
            if (block.bytes.len() - begin) as u64 >= LONGEST {
                break;
            }
        }
        if block.lines > 0 {
            self.number = before + block.lines;
            self.text = String::from_utf8_lossy(&block.bytes[last..]).trim_end_matches(['\n', '\r']).to_owned();
        }
        Ok(())
    }

    /// Skips `count` lines; returns the number skipped.
    pub(super) fn pass(&mut self, count: u64) -> Result<u64> {
        for passed in 0..count {
            let length = self.reader.skip_until(self.end).map_err(|e| Error::read(&self.path, e))?;
            if length == 0 {
                return Ok(passed);
            }
            self.number += 1;
            self.rest(u64::from(length == 1))?;
        }
        Ok(count)
    }

    /// Skips `count` lines that are not blank; returns the number skipped.
    pub(super) fn pass_filled(&mut self, count: u64) -> Result<u64> {
        let mut passed = 0;
        while passed < count {
            let (mut is_filled, mut is_whole, mut length) = (false, false, 0);
            while !is_whole {
                let bytes = self.reader.fill_buf().map_err(|e| Error::read(&self.path, e))?;
                if bytes.is_empty() {
                    break;
                }
                let end = bytes.iter().position(|byte| *byte == self.end);
                let more = end.map_or(bytes.len(), |at| at + 1);
                is_filled |= bytes[..more].iter().any(|byte| !byte.is_ascii_whitespace());
                (is_whole, length) = (end.is_some(), length + more);
                self.reader.consume(more);
            }
            if length == 0 {
                return Ok(passed);
            }
            self.number += 1;
            passed += u64::from(is_filled);
            self.rest(u64::from(!is_filled))?;
        }
        Ok(passed)
    }

    /// The input after the current line.
    pub(super) fn into_reader(self) -> R {
        self.reader
    }

    /// A part of the line.
    pub(super) fn word(&self, at: usize, end: usize) -> Word<'_, R> {
        Word { text: &self.text[at..end], at, is_quoted: false, lines: self }
    }

    /// The line without its line ending.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The place with the file name alone.
    pub fn file(&self) -> Place {
        Place::file(self.path.display().to_string())
    }

    /// Line and column of a byte of this line.
    pub fn spot(&self, byte: usize) -> Spot {
        // `self.number` is the number of the last line of a record.
        let behind = self.text.get(byte..).map_or(0, |rest| rest.matches('\n').count() as u64);
        Spot { line: self.number.saturating_sub(behind), column: column(&self.text, byte) }
    }

    /// The place of a byte of this line.
    pub fn place(&self, byte: usize) -> Place {
        self.spot(byte).of(self.file())
    }
}

impl<R: BufRead> Lines<R> {
    /// An error at a byte of this line.
    pub(super) fn fail(&self, byte: usize, field: &str, problem: impl Into<String>, mend: impl Into<String>) -> Error {
        Error::scene(self.place(byte).named(field), problem, mend)
    }

    /// An error at the end of this line.
    pub(super) fn ends(&self, field: &str, problem: impl Into<String>, mend: impl Into<String>) -> Error {
        self.fail(self.text.len(), field, problem, mend)
    }

    /// The error for a file that ends within a frame.
    pub(super) fn cut(&self, field: &str, mend: &str) -> Error {
        self.ends(field, "the file ends within a frame", mend)
    }

    /// Reads the next line of a frame; its absence is an error.
    pub(super) fn need(&mut self, field: &str, mend: &str) -> Result<()> {
        if self.advance()? { Ok(()) } else { Err(self.cut(field, mend)) }
    }

    /// The number of atoms that is this line.
    pub(super) fn count(&self, field: &str, mend: impl Into<String>) -> Result<u64> {
        let text = self.text.trim();
        let wrong = |_| self.fail(0, field, format!("{} is not a number of atoms", quote(text)), mend);
        let count = text.parse().map_err(wrong)?;
        check_ids(count).map(|()| count)
    }
}

impl Lines<Input> {
    /// Reports that the current line contains a particle.
    pub fn found(&self) {
        self.reader.found();
    }

    /// Skips `count` lines of particles; false where the file ends before, or within the last of them, which has so many words.
    pub(super) fn pass_rows(&mut self, count: u64, words: usize) -> Result<bool> {
        let mut left = count.saturating_sub(1);
        while left > 0 {
            self.found();
            let more = left.min(1 << 10);
            if self.pass(more)? < more {
                return Ok(false);
            }
            left -= more;
        }
        Ok(count == 0 || self.advance()? && (Words::of(self).count() >= words || !self.is_last()?))
    }

    /// Whether the file ends with the current line; otherwise the next one is the current line.
    pub(super) fn is_last(&mut self) -> Result<bool> {
        let more = self.advance()?;
        self.again = more;
        Ok(!more)
    }
}

/// Lines that were read together and are parsed on all cores.
#[derive(Default)]
pub struct Block {
    bytes: Vec<u8>,
    /// The first byte of each part, and the number of lines before it.
    parts: Vec<(usize, u64)>,
    lines: u64,
    path: PathBuf,
    fixed: bool,
    end: u8,
    records: Option<u8>,
}

impl Block {
    /// The number of lines.
    pub fn len(&self) -> u64 {
        self.lines
    }

    /// Whether it has no lines.
    pub fn is_empty(&self) -> bool {
        self.lines == 0
    }

    /// Parts of whole lines, in order.
    pub fn parts(&self) -> Vec<Lines<&[u8]>> {
        let ends = self.parts.iter().skip(1).map(|(start, _)| *start).chain([self.bytes.len()]);
        let part = |((start, number), end): (&(usize, u64), usize)| Lines {
            number: *number,
            fixed: self.fixed,
            end: self.end,
            records: self.records,
            ..Lines::new(&self.bytes[*start..end], &self.path)
        };
        self.parts.iter().zip(ends).map(part).collect()
    }
}

/// A word of a line.
pub struct Word<'a, R> {
    /// Its bytes in the line; see `Word::content`.
    pub text: &'a str,
    /// The position of its first byte.
    pub(super) at: usize,
    /// Whether it stood in quotes.
    pub(super) is_quoted: bool,
    lines: &'a Lines<R>,
}

impl<'a, R: BufRead> Word<'a, R> {
    /// The text: a doubled quote within quotes is one (RFC 4180, section 2).
    pub(super) fn content(&self) -> Cow<'a, str> {
        if self.is_quoted && self.text.contains("\"\"") {
            return self.text.replace("\"\"", "\"").into();
        }
        self.text.into()
    }

    /// Parses a finite number; errors name `field`.
    pub fn finite(&self, field: &str) -> Result<f64> {
        let number = self.number(field)?;
        if number.is_finite() { Ok(number) } else { Err(self.wrong(field, "is not finite")) }
    }

    /// Parses a positive finite number.
    pub(super) fn positive(&self, field: &str) -> Result<f64> {
        let number = self.finite(field)?;
        if number > 0.0 { Ok(number) } else { Err(self.wrong(field, "is not positive")) }
    }

    /// Parses any number, including infinities and NaN.
    pub fn number(&self, field: &str) -> Result<f64> {
        self.text.parse().map_err(|_| self.wrong(field, "is not a number"))
    }

    /// Parses a whole number.
    pub(super) fn whole(&self, field: &str) -> Result<i64> {
        let problem = || format!("{} is not a whole number", quote(self.text));
        let place = || self.lines.place(self.at).named(field);
        self.text.parse().map_err(|_| Error::scene(place(), problem(), "use a whole number such as 7"))
    }

    fn wrong(&self, field: &str, what: &str) -> Error {
        let problem = match self.text {
            "" => "the field is blank".to_owned(),
            text => format!("{} {what}", quote(text)),
        };
        Error::scene(
            self.lines.place(self.at).named(field),
            problem,
            mend_number(self.text, "use a finite number such as 0.5"),
        )
    }
}

/// The words of a line, separated by white space.
pub(super) struct Words<'a, R> {
    lines: &'a Lines<R>,
    at: usize,
}

impl<R> Clone for Words<'_, R> {
    fn clone(&self) -> Self {
        Self { lines: self.lines, at: self.at }
    }
}

impl<'a, R: BufRead> Words<'a, R> {
    /// The words of the current line.
    pub(super) fn of(lines: &'a Lines<R>) -> Self {
        Self { lines, at: 0 }
    }
}

impl<'a, R: BufRead> Iterator for Words<'a, R> {
    type Item = Word<'a, R>;

    fn next(&mut self) -> Option<Self::Item> {
        // Splitting by bytes is safe, because the separators are ASCII and no part of another character.
        let bytes = self.lines.text.as_bytes();
        let at = self.at + bytes.get(self.at..)?.iter().position(|b| !b.is_ascii_whitespace())?;
        let end = bytes[at..].iter().position(u8::is_ascii_whitespace).map_or(bytes.len(), |length| at + length);
        self.at = end;
        Some(self.lines.word(at, end))
    }
}

/// Line and column, from 1, stored for a later error.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Spot {
    line: u64,
    column: u64,
}

impl Spot {
    pub(super) fn new(line: u64, column: u64) -> Self {
        Self { line, column }
    }

    /// This spot of `file`.
    pub fn of(self, file: Place) -> Place {
        file.at(self.line, self.column)
    }
}

/// The characters before `byte` in its line, plus one.
fn column(record: &str, byte: usize) -> u64 {
    let before = record.get(..byte).unwrap_or(record);
    before.rsplit('\n').next().unwrap_or_default().chars().count() as u64 + 1
}
