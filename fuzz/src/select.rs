//! Selections and lists of cameras.

use super::check::{Allowed, PER_BYTE_OF_TOML, allowed, check_error};
use halfline::scene::{ImagePlane, Lighting, Scene, Spheres};
use halfline::{Aov, Backend, Camera, Settings};
use halfline_files::read::cameras::ListedCamera;
use halfline_files::read::{ParticleOptions, ReadOptions, Selection, Sequence, cameras};
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
            let options = ReadOptions {
                particles: ParticleOptions { select: vec![selection.clone()], ..Default::default() },
                ..ReadOptions::default()
            };
            let others = ReadOptions {
                particles: ParticleOptions { hide: vec![selection], ..Default::default() },
                ..ReadOptions::default()
            };
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
            list.iter().take(2).enumerate().for_each(|(n, camera)| see(n, camera));
        }
    }
    allowed(data.len(), PER_BYTE_OF_TOML)
}

/// Renders a sphere with a camera of a list, if its lens is curved; other lenses are checked.
fn see(index: usize, listed: &ListedCamera) {
    let (width, height) = (8, 6);
    let Some(lens) = listed.lens(None, None) else { return };
    let camera = match lens.for_image(index, width, height) {
        Ok(lens) => Camera { lens, ..listed.camera },
        Err(error) => return drop(check_error(&error)),
    };
    let image = ImagePlane { width, height, background: [0.0; 3] };
    let mut spheres = Spheres::default();
    spheres.push([0.0; 3], 1.0, None);
    let scene = Scene { camera, image, spheres, lighting: Lighting::default() };
    let settings = Settings { backend: Backend::Cpu, aovs: vec![Aov::Distance, Aov::Position], ..Settings::default() };
    let result = if camera.lens.is_curved() { halfline::render(&scene, &settings).map(drop) } else { scene.check() };
    if let Err(error) = result {
        drop(check_error(&error));
    }
}
