//! Damaged files.

use crate::rng::Rng;

/// Pieces of text and bytes on which readers have failed.
const SCRAPS: [&[u8]; 41] = [
    b"\n",
    b"\r\n",
    b" ",
    b"-",
    b"nan",
    b"inf",
    b"1e999",
    b"-1e308",
    b"1e-320",
    b"0",
    b"[",
    b"]",
    b"\"",
    b"'",
    b"\xff",
    b"\xc3",
    b"9999999999999999999",
    b"18446744073709551615",
    b"9223372036854775808",
    b"4294967296",
    b"-1",
    b"#",
    b",",
    b";",
    b"\t",
    b"\0",
    b"(",
    b"{",
    b"ITEM:",
    b"element vertex 99999999999",
    b"property list int int q",
    b"p 3",
    b"loop_",
    b"_atom_site.",
    b"ATOM",
    b"Atoms",
    b"MODEL",
    b"Properties=pos:R:4000000000",
    b"'",
    b"0x",
    b"[[",
];

/// Changes bytes in one of the ways in which files are damaged; `other` is a file to take pieces from.
pub(crate) fn damage(bytes: &mut Vec<u8>, other: &[u8], rng: &mut Rng) {
    let at = rng.below(bytes.len() + 1);
    let to = (at + rng.below(16)).min(bytes.len());
    let lines = |bytes: &[u8], from: usize| {
        bytes[from..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |k| from + k + 1)
    };
    match rng.below(12) {
        0 => bytes.truncate(at),
        1 => drop(bytes.drain(at..to)),
        2 => bytes.extend_from_within(at..to),
        3 if at < bytes.len() => bytes[at] ^= 1 << rng.below(8),
        4 if at < bytes.len() => bytes[at] = rng.below(256) as u8,
        5 => {
            // Another digit for a digit.
            let digits: Vec<usize> = (0..bytes.len()).filter(|k| bytes[*k].is_ascii_digit()).collect();
            if !digits.is_empty() {
                bytes[digits[rng.below(digits.len())]] = b'0' + rng.below(10) as u8;
            }
        }
        6 => {
            // One of the pieces for a number.
            let digit = (at..bytes.len()).find(|k| bytes[*k].is_ascii_digit()).unwrap_or(at);
            let end = (digit..bytes.len()).find(|k| !b"0123456789.+-eE".contains(&bytes[*k])).unwrap_or(bytes.len());
            drop(bytes.splice(digit..end, rng.pick(&SCRAPS).iter().copied()));
        }
        7 => {
            // A line many times over.
            let end = lines(bytes, at);
            let block = bytes[at..end].repeat(1 + rng.below(64));
            drop(bytes.splice(end..end, block));
        }
        8 => drop(bytes.drain(at..lines(bytes, at))),
        9 => {
            // A piece of another file.
            let from = rng.below(other.len() + 1);
            let piece = &other[from..(from + rng.below(200)).min(other.len())];
            drop(bytes.splice(at..at, piece.iter().copied()));
        }
        10 => {
            // The largest and smallest words.
            let word = rng.pick(&[&[0xff; 8][..], &[0; 8], &[0xff, 0xff, 0xff, 0x7f], &[0, 0, 0, 0x80]]);
            let end = (at + word.len()).min(bytes.len());
            bytes[at..end].copy_from_slice(&word[..end - at]);
        }
        _ => drop(bytes.splice(at..at, rng.pick(&SCRAPS).iter().copied())),
    }
}
