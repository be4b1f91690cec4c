//! BinaryCIF: the categories of CIF as columns of encoded bytes in MessagePack (Sehnal et al., PLoS Comput. Biol. 16, e1008247 (2020);
//! github.com/molstar/BinaryCIF, version 0.3). It is read as the words that the same file has in text: each category is a loop.
//! The columns are decoded row by row, so that the memory is as large as the encoded bytes.

mod column;
mod values;

use super::token::{Token, Want};
use crate::lines::Spot;
use crate::source::Source;
use column::Column;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::unquoted;
use rmpv::Value;
use rmpv::decode::{Error as PackError, read_value_with_max_depth};
use std::io::ErrorKind;
use std::path::PathBuf;
use std::vec::IntoIter;
use values::{array, field, text};

/// The remedy for a damaged file.
const DAMAGED: &str = "the file is damaged; copy or write it again, or use the entry as mmCIF";

/// The most levels of maps and arrays; an encoded column of strings has about twenty.
const DEPTH: usize = 64;

/// The most values, and the most bytes of their words, for each byte of the file: entries of the PDB have about 10.
const MOST_TIMES: u64 = 64;

/// A file's words.
pub(super) struct BinaryTokens {
    /// The file, until it is read.
    source: Option<Source>,
    path: PathBuf,
    is_used: fn(&str) -> bool,
    /// Bytes of the file, and of the values that were returned.
    length: u64,
    returned: u64,
    blocks: IntoIter<Value>,
    categories: IntoIter<Value>,
    category: Category,
    /// The current word.
    word: Vec<u8>,
    /// The current value, where it is a number that has no word.
    number: Option<f64>,
    /// A word that was put back.
    kept: Option<Token>,
}

/// A category whose words are being returned.
#[derive(Default)]
struct Category {
    name: String,
    rows: u64,
    columns: Vec<Column>,
    /// Tags that were returned.
    tags: usize,
    /// The row and the column of the next value.
    row: u64,
    at: usize,
}

impl BinaryTokens {
    pub(super) fn new(source: Source, is_used: fn(&str) -> bool) -> Self {
        let path = source.path.clone();
        let none = || Vec::new().into_iter();
        Self {
            source: Some(source),
            path,
            is_used,
            length: 0,
            returned: 0,
            blocks: none(),
            categories: none(),
            category: Category::default(),
            word: Vec::new(),
            number: None,
            kept: None,
        }
    }

    /// Moves to the next word.
    pub(super) fn next(&mut self) -> Result<Token> {
        self.next_as(Want::Word)
    }

    /// Moves to the next word; `want` is the part that is needed.
    pub(super) fn next_as(&mut self, want: Want) -> Result<Token> {
        if let Some(token) = self.kept.take() {
            return Ok(token);
        }
        self.read()?;
        let category = &mut self.category;
        self.word.clear();
        self.number = None;
        if let Some(column) = category.columns.get(category.tags) {
            self.word.extend([category.name.as_bytes(), b".", column.name.as_bytes()].concat());
            category.tags += 1;
            return Ok(Token::Tag);
        }
        if category.row < category.rows {
            return self.next_value(want);
        }
        while let Some(next) = self.categories.next() {
            if self.begin(next)? {
                return Ok(Token::Loop);
            }
        }
        self.category = Category::default();
        let Some(block) = self.blocks.next() else { return Ok(Token::End) };
        let categories = array(block, "categories").map_err(|problem| self.damaged("dataBlocks", problem))?;
        self.categories = categories.into_iter();
        Ok(Token::Block)
    }

    /// Reads the file, if it was not read yet.
    fn read(&mut self) -> Result<()> {
        let Some(mut source) = self.source.take() else { return Ok(()) };
        let file = match read_value_with_max_depth(&mut source.reader, DEPTH) {
            Ok(file) => file,
            Err(PackError::DepthLimitExceeded) => {
                return Err(self.damaged("MessagePack", format!("more than {DEPTH} levels")));
            }
            Err(PackError::InvalidMarkerRead(error) | PackError::InvalidDataRead(error)) => {
                let is_end = error.kind() == ErrorKind::UnexpectedEof;
                let cut = || self.damaged("MessagePack", "the file ends within it".to_owned());
                return Err(if is_end { cut() } else { Error::read(&self.path, error) });
            }
        };
        self.length = source.reader.position();
        let blocks = array(file, "dataBlocks").map_err(|problem| self.damaged("dataBlocks", problem))?;
        self.blocks = blocks.into_iter();
        Ok(())
    }

    /// Begins a category, if it is used.
    fn begin(&mut self, mut category: Value) -> Result<bool> {
        let name = text(field(&mut category, "name"));
        let rows = field(&mut category, "rowCount").and_then(|rows| rows.as_u64());
        let (Some(name), Some(rows)) = (name, rows) else {
            return Err(self.damaged("categories", "a category has no name or no rowCount".to_owned()));
        };
        // Some writers leave the underscore out.
        let name = format!("_{}", name.trim_start_matches('_'));
        let listed = array(category, "columns").map_err(|problem| self.damaged(&name, problem))?;
        let mut columns = Vec::new();
        let mut is_used = false;
        for mut column in listed {
            let Some(own) = text(field(&mut column, "name")) else {
                return Err(self.damaged(&name, "a column has no name".to_owned()));
            };
            is_used |= (self.is_used)(&format!("{name}.{own}").to_ascii_lowercase());
            columns.push((own, column));
        }
        if !is_used || rows == 0 || columns.is_empty() {
            return Ok(false);
        }
        // Rows that differ are more bytes than rows; such as do not could be any number.
        let values = rows.saturating_mul(columns.len() as u64);
        if rows > self.length || values > MOST_TIMES * self.length {
            let problem = format!("{rows} rows of {} columns in a file of {} bytes", columns.len(), self.length);
            return Err(self.damaged(&name, problem));
        }
        let mut decoded = Vec::new();
        for (own, column) in columns {
            let place = format!("{name}.{own}");
            decoded.push(Column::new(own, column, rows).map_err(|problem| self.damaged(&place, problem))?);
        }
        self.category = Category { name, rows, columns: decoded, ..Category::default() };
        Ok(true)
    }

    /// Moves to the next value of the category.
    fn next_value(&mut self, want: Want) -> Result<Token> {
        let category = &mut self.category;
        let column = &mut category.columns[category.at];
        let moved = match want {
            Want::Word => column.next(&mut self.word),
            Want::Number => column.next_number(&mut self.word).map(|number| self.number = number),
            Want::Nothing => column.pass(),
        };
        if let Err(problem) = moved {
            let (place, row) = (format!("{}.{}", category.name, column.name), category.row + 1);
            return Err(self.damaged(&place, format!("row {row} of {}: {problem}", self.category.rows)));
        }
        // A value is once in the file, and is returned for each row that has it.
        self.returned += self.word.len() as u64;
        if self.returned > MOST_TIMES * self.length {
            let (place, row, length) = (format!("{}.{}", category.name, column.name), category.row + 1, self.length);
            let problem =
                format!("the values up to row {row} have more than {MOST_TIMES} times the {length} bytes of the file");
            return Err(self.damaged(&place, problem));
        }
        category.at += 1;
        if category.at == category.columns.len() {
            (category.at, category.row) = (0, category.row + 1);
        }
        Ok(Token::Value)
    }

    fn damaged(&self, field: &str, problem: String) -> Error {
        // Names of the file may be of any length.
        let field: String = field.chars().take(100).collect();
        Error::scene(self.file().named(unquoted(&field).to_string()), problem, DAMAGED)
    }

    pub(super) fn give_back(&mut self, token: Token) {
        self.kept = Some(token);
    }

    /// The current value, where it was moved to as a number and is one.
    pub(super) fn number(&self) -> Option<f64> {
        self.number
    }

    pub(super) fn word(&self) -> &[u8] {
        &self.word
    }

    /// The current value, which is empty where there is none.
    pub(super) fn value(&self) -> &[u8] {
        &self.word
    }

    pub(super) fn string(&self) -> Result<String> {
        Ok(String::from_utf8_lossy(&self.word).trim().to_owned())
    }

    /// The row of the category and the column of the current value, from 1.
    pub(super) fn spot(&self) -> Spot {
        let Category { row, at, columns, .. } = &self.category;
        match *at {
            0 => Spot::new(*row, columns.len() as u64),
            at => Spot::new(row + 1, at as u64),
        }
    }

    pub(super) fn file(&self) -> Place {
        Place::file(self.path.display().to_string())
    }
}

#[cfg(test)]
mod tests;
