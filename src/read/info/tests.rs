//! The content of files that are written here.

use super::*;
use crate::read::input::Input;

/// The content of a text, counted in parts of `part` particles.
fn counted(name: &str, text: &str, part: usize) -> Result<FileInfo> {
    let (path, options) = (Path::new(name), ReadOptions::default());
    let source = SceneSource::of(Input::of_bytes(text.as_bytes()), path, &options)?;
    of_source(source, path, &options, Survey::with_part(part))
}

#[test]
fn the_extent_of_scaled_coordinates_is_that_of_the_placed_particles() {
    let head = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp pp pp\n-1 3\n0 8\n10 26\n";
    for columns in ["xs ys zs", "xsu ysu zsu"] {
        let text = format!("{head}ITEM: ATOMS {columns}\n0.25 0.5 1\n0.5 0.125 0\n1 0 0.25\n");
        for part in [1, 2, usize::MAX] {
            let extent = counted("a.dump", &text, part).expect("a dump").extent.expect("particles");
            assert_eq!((extent.min, extent.max), ([0.0, 0.0, 10.0], [3.0, 4.0, 26.0]), "{columns} {part}");
        }
    }
}
