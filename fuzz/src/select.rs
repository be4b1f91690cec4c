//! Selections and lists of cameras.

use super::{Allowed, PER_BYTE_OF_TOML, allowed, check_error};
use halfline_files::read::{ReadOptions, Selection, Sequence, cameras};
use std::io::Cursor;
use std::path::Path;

/// Three atoms with every kind of column.
const ATOMS: &str = "\
ATOM      1  N   ALA A   1       0.000   0.000   0.000  1.00 10.00      SEG  N
ATOM      2  CA AALA A   1A      1.500   0.000   0.000  0.50 20.00      SEG  C
HETATM    3  O   HOH B  -2       9.000   0.000   0.000  1.00               O
";

/// Parses an expression; one that is valid is applied to three atoms.
pub(super) fn select(data: &[u8]) -> Allowed {
    let Ok(text) = std::str::from_utf8(data) else { return allowed(0, 0) };
    match text.parse::<Selection>() {
        Err(error) => drop(check_error(&error)),
        Ok(selection) => {
            // The text of a selection is an expression with the same meaning.
            assert!(selection.to_string().parse::<Selection>().is_ok_and(|again| again == selection));
            let options = ReadOptions { select: vec![selection.clone()], ..ReadOptions::default() };
            let others = ReadOptions { hide: vec![selection], ..ReadOptions::default() };
            let count = |options: &ReadOptions| {
                let mut sequence =
                    Sequence::from_reader(Cursor::new(ATOMS), Path::new("a.pdb"), options).expect("atoms");
                match sequence.next_scene() {
                    Ok(scene) => Some(scene.expect("a frame").scene.spheres.len()),
                    Err(error) => {
                        check_error(&error);
                        None
                    }
                }
            };
            let (taken, left) = (count(&options), count(&others));
            assert_eq!(taken.map(|taken| 3 - taken), left, "what is selected, and the rest");
        }
    }
    allowed(data.len(), PER_BYTE_OF_TOML)
}

/// Reads a list of cameras.
pub(super) fn cameras(data: &[u8]) -> Allowed {
    match cameras::of_bytes(data, "fuzzed") {
        Err(error) => drop(check_error(&error)),
        Ok(list) => {
            assert!(!list.is_empty() && list.iter().all(|camera| camera.camera.eye.is_finite()));
        }
    }
    allowed(data.len(), PER_BYTE_OF_TOML)
}
