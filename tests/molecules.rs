//! The promise of the molecules' readers on entries of the Protein Data Bank: the atoms, their places and their elements are
//! those that gemmi 0.7.5 (github.com/project-gemmi/gemmi) reads, and an assembly is the one that it makes.

use halfline::error::Error;
use halfline::scene::style::{Coloring, Scale, Style, elements};
use halfline::scene::{Altloc, ReadOptions, Scene, Sequence};
use std::path::{Path, PathBuf};

/// The folder of entries, where it is; a test that has none says so.
fn data() -> Option<PathBuf> {
    let beside = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data"));
    let folder = std::env::var_os("HALFLINE_DATA").map_or(beside, PathBuf::from);
    if !folder.is_dir() {
        println!("SKIPPED: no ../shared/data here and HALFLINE_DATA names no folder");
        return None;
    }
    Some(folder)
}

fn read(path: &Path, options: &ReadOptions) -> Scene {
    Scene::read(path, options).unwrap_or_else(|error| panic!("{error}"))
}

/// How many spheres have the van der Waals radius of each element, which tells these elements apart.
fn count(scene: &Scene, symbol: &str) -> usize {
    let radius = elements::element(elements::atomic_number(symbol)).and_then(|element| element.vdw).expect("a radius");
    scene.spheres.radii.iter().filter(|r| **r == radius).count()
}

fn sums(scene: &Scene) -> [f64; 3] {
    [0, 1, 2].map(|k| scene.spheres.centers.iter().map(|center| center[k]).sum())
}

/// Adding n numbers of at most `largest` rounds n times by half an ulp of a partial sum, which n of them bound; so did the
/// other program's sum.
fn close(sums: [f64; 3], truth: [f64; 3], n: usize, largest: f64) -> bool {
    let off = n as f64 * n as f64 * largest * f64::EPSILON;
    sums.iter().zip(truth).all(|(a, b)| (a - b).abs() <= off)
}

/// File, atoms, of them carbon, nitrogen, oxygen and sulphur, and the sum of their places: as gemmi 0.7.5 counts them.
type Entry = (&'static str, usize, [usize; 4], [f64; 3]);

const ENTRIES: [Entry; 3] = [
    ("1tii.pdb", 5684, [3405, 956, 1278, 45], [293_665.511, 65_472.824, 57_952.418]),
    ("1IHM.pdb", 11_284, [7205, 1905, 2120, 54], [-378_733.682, -266_262.802, 1_708_248.941]),
    ("3SN6.cif", 10_274, [6519, 1777, 1914, 64], [293_760.751, 92_890.603, 291_736.353]),
];

#[test]
fn entries_hold_the_atoms_that_gemmi_reads() {
    let Some(data) = data() else { return };
    for (name, atoms, each, truth) in ENTRIES {
        let scene = read(&data.join(name), &ReadOptions::default());
        assert_eq!(scene.spheres.len(), atoms, "{name}");
        assert_eq!(["C", "N", "O", "S"].map(|symbol| count(&scene, symbol)), each, "{name}");
        assert!(close(sums(&scene), truth, atoms, 400.0), "{name}: {:?}", sums(&scene));
        scene.check().expect("what is read can be rendered");
        // None of the entries has alternate locations, so each choice of them is all atoms.
        for altloc in [Altloc::Highest, Altloc::Named("A".into())] {
            let chosen = read(&data.join(name), &ReadOptions { altloc, ..ReadOptions::default() });
            assert_eq!(chosen.spheres, scene.spheres, "{name}");
        }
    }
}

/// Atoms of the capsid by their number in gemmi's assembly, whose order is the same: the first of the second copy, one of the
/// eighteenth, the last of the forty-third and of all.
const CAPSID: [(usize, [f64; 3]); 4] = [
    (11_284, [-70.80891288, 15.746693383999997, 112.401219496]),
    (196_828, [94.58352747, -43.57149875099999, -83.854028719]),
    (485_211, [95.557140162, 114.063464126, 79.701604288]),
    (677_039, [95.557140162, -114.063464126, -79.701604288]),
];

#[test]
fn the_capsid_is_sixty_copies_of_its_chains() {
    let Some(data) = data() else { return };
    let path = data.join("1IHM.pdb");
    let unit = read(&path, &ReadOptions::default());
    assert!(unit.skipped.warnings().iter().any(|said| said.contains("60 copies; --assembly 1")), "{:?}", unit.skipped);
    let columns = vec!["copy".to_owned()];
    let scale = Scale { columns, map: None, range: None, log: false };
    let style = Style { coloring: Coloring::Column(scale), ..Style::default() };
    let options = ReadOptions { assembly: Some("1".into()), style, ..ReadOptions::default() };
    let mut sequence = Sequence::open(&path, &options).expect("the file");
    let shot = sequence.next_scene().expect("a scene").expect("a frame");
    let whole = shot.scene;
    assert_eq!(whole.spheres.len(), 677_040);
    assert_eq!(["C", "N", "O", "S"].map(|symbol| count(&whole, symbol)), [432_300, 114_300, 127_200, 3240]);
    assert_eq!(shot.legend.expect("copies are numbered").range, [0.0, 59.0]);
    // Operator 1 leaves every atom where it stands.
    assert_eq!(whole.spheres.centers[..11_284], unit.spheres.centers);
    // A place is three products and three sums of numbers below 400, in either program.
    for (n, truth) in CAPSID {
        let found = whole.spheres.centers[n];
        let close = found.iter().zip(truth).all(|(a, b)| (a - b).abs() <= 12.0 * 400.0 * f64::EPSILON);
        assert!(close, "atom {n}: {found:?} and not {truth:?}");
    }
}

#[test]
fn an_mmcif_assembly_of_one_operator_is_the_file() {
    let Some(data) = data() else { return };
    let path = data.join("3SN6.cif");
    let options = |id: &str| ReadOptions { assembly: Some(id.into()), ..ReadOptions::default() };
    assert_eq!(read(&path, &options("1")).spheres, read(&path, &ReadOptions::default()).spheres);
    let error = Scene::read(&path, &options("2")).expect_err("there is one");
    assert!(matches!(&error, Error::Settings { .. }) && error.to_string().contains("the file has 1"), "{error}");
    let error =
        Scene::read(&path, &ReadOptions { model: Some(2), ..ReadOptions::default() }).expect_err("there is one");
    assert!(error.to_string().contains("no model 2") && error.to_string().contains("it has 1"), "{error}");
}
