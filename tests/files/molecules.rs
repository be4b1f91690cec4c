//! The promise of the molecules' readers on entries of the Protein Data Bank: they read the atoms, positions and elements that
//! gemmi 0.7.5 (github.com/project-gemmi/gemmi) reads, and build the assemblies that it builds.
//!
//! The entries come from ../shared/data and from the package MDAnalysisTests (`tests/real_files`), as far as present.

use crate::data::real_or_skip;
use halfline::quote::setting::ASSEMBLY;
use halfline::scene::Scene;
use halfline_files::read::SceneFrame;
use halfline_files::read::style::{Coloring, Scale, Style};
use halfline_files::read::{Altloc, ParticleOptions, ReadOptions, Sequence, elements};
use std::path::Path;

fn read(path: &Path, options: &ReadOptions) -> Scene {
    read_frame(path, options).scene
}

fn read_frame(path: &Path, options: &ReadOptions) -> SceneFrame {
    halfline_files::read::scene(path, options).unwrap_or_else(|error| panic!("{error}"))
}

/// The number of spheres with the van der Waals radius of an element, which differs among those that are counted.
fn count(scene: &Scene, symbol: &str) -> usize {
    let radius = elements::element(elements::atomic_number(symbol)).and_then(|element| element.vdw).expect("a radius");
    scene.spheres.radii.iter().filter(|r| **r == radius).count()
}

fn sums(scene: &Scene) -> [f64; 3] {
    [0, 1, 2].map(|k| scene.spheres.centers.iter().map(|center| center[k]).sum())
}

/// Whether sums of `n` coordinates below 400 are equal within rounding: each of n additions rounds by half an ulp of a partial
/// sum below 400 n, in either program. The sums of the table are rounded to three decimals.
fn close(sums: [f64; 3], expected: [f64; 3], n: usize) -> bool {
    let rounding = n as f64 * n as f64 * 400.0 * f64::EPSILON + 0.5e-3;
    sums.iter().zip(expected).all(|(a, b)| (a - b).abs() <= rounding)
}

/// The file, its atoms, the atoms of carbon, nitrogen, oxygen and sulphur, and the sums of the coordinates, by gemmi.
type Entry = (&'static str, usize, [usize; 4], [f64; 3]);

const ENTRIES: [Entry; 7] = [
    ("1tii.pdb", 5684, [3405, 956, 1278, 45], [293_665.511, 65_472.824, 57_952.418]),
    ("1IHM.pdb", 11_284, [7205, 1905, 2120, 54], [-378_733.682, -266_262.802, 1_708_248.941]),
    ("3SN6.cif", 10_274, [6519, 1777, 1914, 64], [293_760.751, 92_890.603, 291_736.353]),
    ("1BD2.cif.gz", 6378, [4008, 1087, 1257, 26], [32_115.058, 223_965.256, 138_888.490]),
    ("1BD2.pdb.gz", 6378, [4008, 1087, 1257, 26], [32_115.058, 223_965.256, 138_888.490]),
    ("3KPR.cif.gz", 13_434, [8356, 2320, 2714, 44], [-101_984.385, -102_314.393, 466_722.625]),
    ("3KPR.pdb.gz", 13_434, [8356, 2320, 2714, 44], [-101_984.385, -102_314.393, 466_722.625]),
];

#[test]
fn entries_have_the_atoms_that_gemmi_reads() {
    for (name, path) in real_or_skip(&ENTRIES.map(|entry| entry.0)) {
        let (_, atoms, each, expected) = ENTRIES.into_iter().find(|entry| entry.0 == name).expect("an entry");
        let scene = read(&path, &ReadOptions::default());
        assert_eq!(scene.spheres.len(), atoms, "{name}");
        assert_eq!(["C", "N", "O", "S"].map(|symbol| count(&scene, symbol)), each, "{name}");
        assert!(close(sums(&scene), expected, atoms), "{name}: {:?}", sums(&scene));
        scene.check().expect("a scene that can be rendered");
        // None of the entries has alternate locations, so each choice of them is all atoms.
        for altloc in [Altloc::Highest, Altloc::Named("A".into())] {
            let chosen = read(
                &path,
                &ReadOptions { particles: ParticleOptions { altloc, ..Default::default() }, ..ReadOptions::default() },
            );
            assert_eq!(chosen.spheres, scene.spheres, "{name}");
        }
    }
}

/// An assembly, by gemmi.
struct Assembly {
    file: &'static str,
    id: &'static str,
    copies: usize,
    atoms: usize,
    sums: [f64; 3],
    /// Atoms by their number, and their positions.
    some: &'static [(usize, [f64; 3])],
}

const ASSEMBLIES: [Assembly; 7] = [
    // A virus capsid: the first atom of the second copy, one of the eighteenth, the last of the forty-third and of all.
    Assembly {
        file: "1IHM.pdb",
        id: "1",
        copies: 60,
        atoms: 677_040,
        sums: [0.0; 3],
        some: &[
            (11_284, [-70.80891288, 15.746693383999997, 112.401219496]),
            (196_828, [94.58352747, -43.57149875099999, -83.854028719]),
            (485_211, [95.557140162, 114.063464126, 79.701604288]),
            (677_039, [95.557140162, -114.063464126, -79.701604288]),
        ],
    },
    // Two copies about an axis.
    Assembly {
        file: "1YJP.cif.gz",
        id: "1",
        copies: 2,
        atoms: 132,
        sums: [0.0, 442.998, 0.0],
        some: &[(0, [-9.009, 4.612, 6.102]), (131, [1.5, 3.1149999999999998, -10.967])],
    },
    // The whole file.
    Assembly { file: "3SN6.cif", id: "1", copies: 1, atoms: 10_274, sums: ENTRIES[2].3, some: &[] },
    // Half of the chains each.
    Assembly {
        file: "3KPR.cif.gz",
        id: "1",
        copies: 1,
        atoms: 6718,
        sums: [70_742.536, -127_473.146, 115_793.150],
        some: &[],
    },
    Assembly {
        file: "3KPR.cif.gz",
        id: "2",
        copies: 1,
        atoms: 6716,
        sums: [-172_726.921, 25_158.753, 350_929.475],
        some: &[],
    },
    Assembly {
        file: "3KPR.pdb.gz",
        id: "1",
        copies: 1,
        atoms: 6718,
        sums: [70_742.536, -127_473.146, 115_793.150],
        some: &[],
    },
    Assembly {
        file: "3KPR.pdb.gz",
        id: "2",
        copies: 1,
        atoms: 6716,
        sums: [-172_726.921, 25_158.753, 350_929.475],
        some: &[],
    },
];

#[test]
fn assemblies_are_those_that_gemmi_makes() {
    for (name, path) in real_or_skip(&["1IHM.pdb", "1YJP.cif.gz", "3SN6.cif", "3KPR.cif.gz", "3KPR.pdb.gz"]) {
        let unit = read(&path, &ReadOptions::default());
        for assembly in ASSEMBLIES.iter().filter(|assembly| assembly.file == name) {
            let columns = vec!["copy".to_owned()];
            let scale = Scale::of(columns);
            let style = Style { coloring: Coloring::Column(scale), ..Style::default() };
            let options = ReadOptions {
                particles: ParticleOptions { assembly: Some(assembly.id.into()), ..Default::default() },
                style,
                ..ReadOptions::default()
            };
            let mut sequence = Sequence::open(&path, &options).expect("the file");
            let shot = sequence.next_scene().expect("a scene").expect("a frame");
            let whole = shot.scene;
            assert_eq!(whole.spheres.len(), assembly.atoms, "{name}");
            assert!(close(sums(&whole), assembly.sums, assembly.atoms), "{name}: {:?}", sums(&whole));
            assert_eq!(shot.legend.expect("copies are numbered").range, [0.0, (assembly.copies - 1) as f64], "{name}");
            if assembly.atoms == assembly.copies * unit.spheres.len() {
                // The first operator is the identity.
                assert_eq!(whole.spheres.centers[..unit.spheres.len()], unit.spheres.centers[..], "{name}");
            }
            // A coordinate is three products and three sums of numbers below 400, in either program.
            for (n, expected) in assembly.some {
                let found = whole.spheres.centers[*n];
                let close = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 12.0 * 400.0 * f64::EPSILON);
                assert!(close, "{name}, atom {n}: {found:?}, expected {expected:?}");
            }
        }
        let ids = ASSEMBLIES.iter().filter(|assembly| assembly.file == name).count();
        let missing = (ids + 1).to_string();
        let refused = |options: ReadOptions, words: &[&str]| {
            let error = halfline_files::read::scene(&path, &options).expect_err("it is missing").to_string();
            assert!(words.iter().all(|word| error.contains(word)), "{name}: {error}");
        };
        refused(
            ReadOptions {
                particles: ParticleOptions { assembly: Some(missing), ..Default::default() },
                ..ReadOptions::default()
            },
            &["the file has 1"],
        );
        refused(
            ReadOptions {
                particles: ParticleOptions { model: Some(2), ..Default::default() },
                ..ReadOptions::default()
            },
            &["no model 2", "the file has 1"],
        );
        let copies = ASSEMBLIES.iter().find(|assembly| assembly.file == name).map_or(1, |assembly| assembly.copies);
        let offer = format!("{copies} copies; use {ASSEMBLY} 1");
        let warnings = read_frame(&path, &ReadOptions::default()).skipped.warnings();
        assert!(copies == 1 || warnings.iter().any(|warning| warning.contains(&offer)), "{name}: {warnings:?}");
    }
}

/// Files of other programs, and their numbers of particles in the first frame: of the 47,681 of the first file, 11,084 are
/// virtual sites of water, which are left out.
#[test]
fn files_of_other_programs_have_their_particles() {
    const FILES: [(&str, usize); 8] = [
        ("adk_oplsaa.gro", 36_597),
        ("2r9r-1b.xyz", 1284),
        ("1A2C.pqr", 5313),
        ("adk_open.pqr", 3341),
        ("pdbqt_inputpdbqt.pdbqt", 1805),
        ("albite_triclinic.data", 17),
        ("albite_triclinic.dump", 17),
        ("chain_initial.data", 22),
    ];
    for (name, path) in real_or_skip(&FILES.map(|(name, _)| name)) {
        let (_, particles) = FILES.into_iter().find(|file| file.0 == name).expect("one of them");
        let SceneFrame { scene, skipped, .. } = read_frame(&path, &ReadOptions::default());
        assert_eq!(scene.spheres.len(), particles, "{name}: {skipped:?}");
        scene.check().expect("a scene that can be rendered");
    }
}
