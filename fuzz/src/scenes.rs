//! Scenes in every format.

use super::check::{
    Allowed, IMAGES, PER_BYTE, PER_BYTE_OF_CRYSTAL, PER_BYTE_OF_TOML, POINTS_OF_LAZ, Pieces, Unpacked, allowed,
    allowed_points, check_error, check_words, unpacked,
};
use halfline_files::read::style::{Coloring, Scale, Style};
use halfline_files::read::{Format, ParticleOptions, ReadOptions, SceneFrame, Sequence, info_from_reader};
use std::io::{Cursor, Read};
use std::path::Path;

/// Reads all frames of a scene.
pub(super) fn scene(format: Option<Format>, data: &[u8]) -> Allowed {
    let Some((choice, content)) = data.split_first() else { return allowed(0, 0) };
    let Some(Unpacked { length, whole }) = unpacked(content) else { return allowed(0, 0) };
    let options = options(format, *choice);
    let at_once = read(Cursor::new(content.to_vec()), &options, length);
    // The same bytes in pieces must give the same scene. For a damaged stream, a decompressor delivers more or fewer
    // bytes before its error, depending on the pieces.
    if choice & 0x80 != 0 {
        let in_pieces = read(Pieces::new(content), &options, length);
        assert!(at_once == in_pieces || !whole, "at once {at_once:?}, in pieces {in_pieces:?}");
    }
    if choice & 0x10 != 0 {
        check_info(format, content);
    }
    match format.map(Format::name) {
        Some("toml" | "pcd") => allowed(length, PER_BYTE_OF_TOML),
        Some("cif") => allowed(length, PER_BYTE_OF_CRYSTAL),
        Some("las" | "vtk") | None => allowed_points(length),
        _ => allowed(length, PER_BYTE),
    }
}

/// Checks that the examination of a file says what a rendering without options does: the same error, or the same spheres.
fn check_info(format: Option<Format>, content: &[u8]) {
    let options = ReadOptions { particles: ParticleOptions { format, ..Default::default() }, ..ReadOptions::default() };
    let (path, bytes) = (Path::new("fuzzed"), || Cursor::new(content.to_vec()));
    let rendered = Sequence::from_reader(bytes(), path, &options).and_then(|mut sequence| sequence.next_scene());
    match (info_from_reader(bytes(), path, &options), rendered) {
        (Ok(info), Ok(Some(frame))) => assert_eq!(info.spheres, frame.scene.spheres.len() as u64),
        // Another error may come from a column; a rendering reads few columns.
        (Err(error), Err(_)) => drop(check_error(&error)),
        // A file without a frame is refused by the command.
        (Err(error), Ok(None)) => drop(check_error(&error)),
        // The image flags of LAMMPS data and most arrays of VTK are columns that a rendering does not read.
        (Err(error), Ok(Some(_))) if [Some(Format::DATA), Some(Format::VTK)].contains(&format) => {
            drop(check_error(&error));
        }
        (Err(error), Ok(Some(frame))) => panic!("{error}, but {:?} are read", frame.scene.spheres.len()),
        // A default camera may be beyond f64; one that is given may not.
        (Ok(_), Err(error)) if error.to_string().contains("beyond the range of f64") => {}
        (Ok(info), Err(error)) => panic!("info has {} spheres, and a rendering {error}", info.spheres),
        (Ok(info), Ok(None)) => panic!("info has {} spheres, and a rendering no frame", info.spheres),
    }
}

/// Options that select other paths of the readers, by the bits of a byte.
fn options(format: Option<Format>, choice: u8) -> ReadOptions {
    let columns: &[&str] = match choice & 3 {
        0 => &[],
        1 => &["x"],
        2 => &["vx", "vy"],
        _ => &["chain"],
    };
    let mut options = ReadOptions {
        particles: ParticleOptions { format, frames: "1-".parse().expect("frames"), ..Default::default() },
        ..ReadOptions::default()
    };
    if !columns.is_empty() {
        let columns = columns.iter().map(|name| (*name).to_owned()).collect();
        let scale = Scale { log: choice & 0x40 != 0 && choice & 3 == 1, ..Scale::of(columns) };
        options.style = Style { coloring: Coloring::Column(scale), ..Style::default() };
    }
    if [Some(Format::PDB), Some(Format::CIF)].contains(&format) {
        match choice >> 2 & 7 {
            1 => options.particles.assembly = Some("1".into()),
            2 => options.particles.altloc = "highest".parse().expect("an alternate location"),
            3 => options.particles.altloc = "A".parse().expect("an alternate location"),
            4 => options.particles.model = Some(2),
            5 => {
                options.particles.assembly = Some("1".into());
                options.particles.frames = "1".parse().expect("frames");
            }
            _ => {}
        }
    } else if choice & 4 != 0 {
        options.particles.frames = "2-3".parse().expect("frames");
    } else if choice & 8 != 0 {
        options.particles.frames = "1".parse().expect("frames");
    }
    options.particles.strict = choice & 0x20 != 0;
    options
}

/// The result of reading: a line for every frame, and one for the error that ended them.
fn read(reader: impl Read + Send + 'static, options: &ReadOptions, length: usize) -> Vec<String> {
    let mut lines = Vec::new();
    let mut sequence = match Sequence::from_reader(reader, Path::new("fuzzed"), options) {
        Ok(sequence) => sequence,
        Err(error) => return vec![check_error(&error)],
    };
    loop {
        match sequence.next_scene() {
            Ok(None) => return lines,
            Ok(Some(shot)) => lines.push(check_shot(&shot, options, length)),
            Err(error) => {
                lines.push(check_error(&error));
                return lines;
            }
        }
    }
}

/// Checks that a scene can be rendered; returns its description in a line.
fn check_shot(shot: &SceneFrame, options: &ReadOptions, length: usize) -> String {
    let (scene, spheres) = (&shot.scene, &shot.scene.spheres);
    scene.check().expect("a scene that was read can be rendered");
    assert!(spheres.radii.iter().all(|radius| *radius > 0.0 && radius.is_finite()));
    assert!(spheres.centers.iter().flatten().all(|x| x.is_finite()));
    if let Some(colors) = &spheres.colors {
        assert_eq!(colors.len(), spheres.len());
        assert!(colors.iter().flatten().all(|c| *c >= 0.0 && c.is_finite()), "colours are light");
    }
    // A sphere has three coordinates of at least one byte each; an assembly repeats spheres. In compressed formats it has
    // at least two bits (XTC), and three bytes decompress to at most 264 (PCD), in which a point has at least three. A
    // point like the one before takes 0.0075 bits of LAZ.
    let most = match options.particles.format.map(Format::name) {
        Some("xtc") => 4 * length,
        Some("pcd") => 30 * length,
        // A space group repeats an atom.
        Some("cif") => IMAGES * length / 3,
        // Blocks of VTK decompress to many equal points.
        Some("las" | "vtk") | None => POINTS_OF_LAZ * length,
        _ => length / 3,
    };
    assert!(
        options.particles.assembly.is_some() || spheres.len() <= most,
        "{} spheres of {length} bytes",
        spheres.len()
    );
    if let Some(cell) = &shot.cell {
        assert!(cell.origin.iter().chain(cell.edges.iter().flatten()).all(|x| x.is_finite()), "{cell:?}");
    }
    if let Some(legend) = &shot.legend {
        assert!(
            legend.categories.is_empty()
                || legend.categories.iter().map(|c| c.count).sum::<u64>() <= spheres.len() as u64
        );
        assert!(legend.range[0] <= legend.range[1], "{:?}", legend.range);
    }
    let warnings = shot.skipped.warnings();
    warnings.iter().for_each(|warning| check_words(warning));
    format!("{} {} {} {warnings:?}", shot.number, scene.fingerprint(), spheres.len())
}
