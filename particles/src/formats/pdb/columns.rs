//! The columns of a PDB record.

use crate::lines::Lines;
use halfline_ground::error::Result;
use halfline_ground::quote::quote;
use std::io::BufRead;
use std::ops::Range;

/// The kind of a line.
pub(super) enum PdbRecord {
    Atom,
    Model,
    /// The end of a model, or of the file.
    End,
    Other,
}

/// The columns of an atom's numbers, from 0.
pub(super) const RECORD: Range<usize> = 0..6;
pub(super) const SERIAL: Range<usize> = 6..11;
pub(super) const NAME: Range<usize> = 12..16;
pub(super) const LOCATION: Range<usize> = 16..17;
/// One column more than in the format, as used by CHARMM and NAMD: `TIP3`, `POPC`.
pub(super) const RESIDUE_NAME: Range<usize> = 17..21;
pub(super) const CHAIN: Range<usize> = 21..22;
pub(super) const RESIDUE: Range<usize> = 22..26;
/// Chain, number and insertion code.
pub(super) const RESIDUE_ID: Range<usize> = 21..27;
pub(super) const ICODE: Range<usize> = 26..27;
pub(super) const X: usize = 30;
pub(super) const COORDINATE: usize = 8;
pub(super) const OCCUPANCY: Range<usize> = 54..60;
pub(super) const BFACTOR: Range<usize> = 60..66;
/// The segment, of CHARMM and NAMD, which the format no longer has.
pub(super) const SEGMENT: Range<usize> = 72..76;
pub(super) const SYMBOL: Range<usize> = 76..78;
/// In PDBQT: the partial charge and AutoDock's type.
pub(super) const CHARGE: Range<usize> = 70..76;
pub(super) const TYPE: Range<usize> = 77..79;

pub(super) fn record(line: &[u8]) -> PdbRecord {
    match line {
        [b'A', b'T', b'O', b'M', ..] | [b'H', b'E', b'T', b'A', b'T', b'M', ..] => PdbRecord::Atom,
        [b'M', b'O', b'D', b'E', b'L', b' ', ..] | b"MODEL" => PdbRecord::Model,
        [b'E', b'N', b'D', b'M', b'D', b'L', ..] => PdbRecord::End,
        [b'E', b'N', b'D', rest @ ..] if rest.trim_ascii().is_empty() => PdbRecord::End,
        _ => PdbRecord::Other,
    }
}

/// The bytes of these columns, as far as the line goes.
pub(super) fn field(line: &[u8], columns: Range<usize>) -> &[u8] {
    line.get(columns.start..columns.end.min(line.len())).unwrap_or_default()
}

pub(super) fn text(field: &[u8]) -> &str {
    std::str::from_utf8(field).unwrap_or_default().trim()
}

pub(super) fn number(field: &[u8]) -> Option<f64> {
    text(field).parse().ok()
}

pub(super) fn coordinate<R: BufRead>(lines: &Lines<R>, columns: Range<usize>, axis: &str) -> Result<f64> {
    let line = lines.text().as_bytes();
    let found = field(line, columns.clone());
    if overruns(line, columns.clone(), DECIMALS) {
        let problem =
            format!("{} overruns its columns {} to {}", quote(around(line, &columns)), columns.start + 1, columns.end);
        return Err(lines.fail(
            columns.start,
            axis,
            problem,
            "write coordinates of more digits as mmCIF, or move the atoms",
        ));
    }
    number(found).filter(|x| x.is_finite()).ok_or_else(|| {
        let blanks = found.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let at = (columns.start + blanks % found.len().max(1)).min(lines.text().len());
        let problem = match found.trim_ascii() {
            [] => format!("columns {} to {} are empty", columns.start + 1, columns.end),
            word => format!("expected a finite number, found {}", quote(word)),
        };
        let mend = format!("write {axis} in columns {} to {}, such as -12.345", columns.start + 1, columns.end);
        lines.fail(at, axis, problem, mend)
    })
}

/// Decimals of a coordinate that fills its columns.
const DECIMALS: usize = 3;

/// Whether a number with other than so many decimals goes on behind its columns, so that these have only a part of it.
pub(crate) fn overruns(line: &[u8], columns: Range<usize>, decimals: usize) -> bool {
    let goes_on = line.get(columns.end).is_some_and(|next| next.is_ascii_digit() || *next == b'.');
    let found = field(line, columns);
    let point = found.iter().position(|byte| *byte == b'.').unwrap_or(found.len());
    goes_on && !found.ends_with(b" ") && found.len() != point + 1 + decimals
}

/// The word of a line that has these columns.
fn around<'a>(line: &'a [u8], columns: &Range<usize>) -> &'a [u8] {
    let blank = |byte: &u8| byte.is_ascii_whitespace();
    let (before, behind) = line.split_at(columns.end.min(line.len()));
    let start = before.iter().rposition(blank).map_or(0, |at| at + 1);
    &line[start..before.len() + behind.iter().position(blank).unwrap_or(behind.len())]
}

/// A whole number, in hybrid-36 where the columns are too narrow for decimal digits: `A0000` follows 99999, and `a0000`
/// `ZZZZZ` (Grosse-Kunstleve, cci.lbl.gov/hybrid_36). NaN for anything else.
pub(super) fn hybrid36(field: &[u8]) -> f64 {
    let digits = text(field);
    if let Ok(number) = digits.parse::<i64>() {
        return number as f64;
    }
    let width = digits.len() as u32;
    let (upper, lower) =
        (|c: u8| c.is_ascii_digit() || c.is_ascii_uppercase(), |c: u8| c.is_ascii_digit() || c.is_ascii_lowercase());
    let begins = digits.bytes().next().is_some_and(|c| c.is_ascii_alphabetic());
    let whole = field.len() == digits.len() && (1..=5).contains(&width);
    let value = i64::from_str_radix(digits, 36).ok().filter(|_| begins && whole);
    let Some(value) = value else { return f64::NAN };
    let (tens, power) = (10_i64.pow(width), 36_i64.pow(width - 1));
    if digits.bytes().all(upper) {
        (value - 10 * power + tens) as f64
    } else if digits.bytes().all(lower) {
        (value + 16 * power + tens) as f64
    } else {
        f64::NAN
    }
}
