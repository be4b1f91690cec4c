//! Several files in one frame: the spheres of each equal the spheres of the file alone.

use halfline_files::read::{ColumnValue, Hold, Keep, ParticleOptions, Periodic, ReadOptions, SceneFrame, Sequence};
use std::path::{Path, PathBuf};

fn file(folder: &tempfile::TempDir, name: &str, text: &str) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("a file");
    path
}

fn options(frames: &str, added: &[&Path]) -> ReadOptions {
    let added = added.iter().map(|path| path.to_path_buf()).collect();
    let frames = frames.parse().expect("frames");
    let particles = ParticleOptions { frames, added, keep: Keep::All, ..ParticleOptions::default() };
    ReadOptions { particles, hold: Hold::None, ..ReadOptions::default() }
}

fn read(path: &Path, options: &ReadOptions) -> Vec<SceneFrame> {
    let mut sequence = Sequence::open(path, options).expect("a file");
    std::iter::from_fn(|| sequence.next_scene().expect("a frame")).collect()
}

/// A file of each kind: with radii and colours of bytes, with elements and names, with linear colours, in frames.
fn files(folder: &tempfile::TempDir) -> Vec<PathBuf> {
    let atom = |serial: usize, name: &str, chain: char, x: f64| {
        format!(
            "ATOM  {serial:>5}  {name:<3} ALA {chain}   1    {x:8.3}   1.000   2.000  1.00  0.00           {}\n",
            &name[..1]
        )
    };
    vec![
        file(folder, "cloud.csv", "x,y,z,radius,r,g,b,mass\n0,0,0,0.5,255,0,0,2\n1,0,0,0.25,0,128,0,3\n"),
        file(folder, "mol.pdb", &[atom(1, "N", 'A', 4.0), atom(2, "CA", 'A', 5.5), atom(3, "O", 'B', 7.0)].concat()),
        file(folder, "light.csv", "x,y,z,radius,r,g,b,chain\n9,0,0,1,0.25,0.5,0.125,7\n9,3,0,1,1,0.5,0.125,8\n"),
        file(folder, "film.xyz", "1\n\nH 0 0 5\n1\n\nH 0 0 6\n1\n\nH 0 0 7\n"),
    ]
}

#[test]
fn spheres_of_several_files_are_those_of_each() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = files(&folder);
    let alone: Vec<SceneFrame> = files.iter().map(|path| read(path, &options("1", &[])).remove(0)).collect();
    // Every order of three of them, from all that there are.
    let orders = (0..4).flat_map(|a| (0..4).flat_map(move |b| (0..4).map(move |c| [a, b, c])));
    for order in orders {
        let [first, others @ ..] = order.map(|k| files[k].as_path());
        let all = read(first, &options("1", &others)).remove(0);
        let mut start = 0;
        let has_colors = order.iter().any(|k| [0, 2].contains(k));
        for (place, k) in order.into_iter().enumerate() {
            let (own, spheres) = (&alone[k].scene.spheres, &all.scene.spheres);
            let range = start..start + own.len();
            start = range.end;
            assert_eq!(spheres.centers[range.clone()], own.centers[..], "{order:?} {place}");
            assert_eq!(spheres.radii[range.clone()], own.radii[..], "{order:?} {place}");
            let [of_all, of_own] = [spheres, own].map(|spheres| spheres.colors.as_ref().expect("colours"));
            assert_eq!(of_all[range.clone()], of_own[..], "{order:?} {place}, colours in a file: {has_colors}");
            let name = ["cloud", "mol", "light", "film"][k];
            let again = order[..place].iter().filter(|before| **before == k).count();
            let name = if again == 0 { name.to_owned() } else { format!("{name}-{}", again + 1) };
            for n in range.clone() {
                let value = |column: &str| all.columns.get(column).ok().map(|(_, values)| values.value(n));
                assert_eq!(value("file"), Some(ColumnValue::Text(&name)), "{order:?} {n}");
                // A column that some files lack is missing there; one of numbers and of names has names.
                let chain = match k {
                    1 => {
                        if n - range.start < 2 {
                            "A"
                        } else {
                            "B"
                        }
                    }
                    2 => {
                        if n == range.start {
                            "7"
                        } else {
                            "8"
                        }
                    }
                    _ => "",
                };
                if order.contains(&1) {
                    assert_eq!(value("chain"), Some(ColumnValue::Text(chain)), "{order:?} {n}");
                }
            }
        }
        assert_eq!(start, all.scene.spheres.len());
    }
}

#[test]
fn frames_of_several_files_go_in_step_and_a_still_is_in_all() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = files(&folder);
    let [still, film] = [&files[1], &files[3]];
    let short = file(&folder, "short.xyz", "1\n\nO 0 0 1\n1\n\nO 0 0 2\n");
    let depths = |path: &Path, frames: &str, added: &[&Path]| -> Vec<Vec<f64>> {
        let depths = |frame: &SceneFrame| frame.scene.spheres.centers.iter().map(|center| center[2]).collect();
        read(path, &options(frames, added)).iter().map(depths).collect()
    };
    for (path, added, expected) in [
        (
            still,
            vec![film.as_path()],
            vec![vec![2.0, 2.0, 2.0, 5.0], vec![2.0, 2.0, 2.0, 6.0], vec![2.0, 2.0, 2.0, 7.0]],
        ),
        (film, vec![still], vec![vec![5.0, 2.0, 2.0, 2.0], vec![6.0, 2.0, 2.0, 2.0], vec![7.0, 2.0, 2.0, 2.0]]),
        (film, vec![&short], vec![vec![5.0, 1.0], vec![6.0, 2.0]]),
        (&short, vec![film], vec![vec![1.0, 5.0], vec![2.0, 6.0]]),
        (still, vec![still], vec![vec![2.0; 6]]),
    ] {
        assert_eq!(depths(path, "1-", &added), expected, "{} and {added:?}", path.display());
        // A frame read alone equals the film's frame.
        for (number, frame) in expected.iter().enumerate() {
            assert_eq!(depths(path, &(number + 1).to_string(), &added), vec![frame.clone()], "frame {number}");
        }
        let behind = (expected.len() + 1).to_string();
        assert!(depths(path, &behind, &added).is_empty());
    }
}

#[test]
fn residues_and_cells_are_those_of_their_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = files(&folder);
    let mol = files[1].as_path();
    // The same residue of another file is another one.
    let select = |words: &str| ParticleOptions {
        select: vec![words.parse().expect("a selection")],
        ..options("1", &[mol]).particles
    };
    for (words, count) in [
        ("same residue as (file mol and name N)", 2),
        ("same residue as name N", 4),
        ("file mol-2", 3),
        ("file mol*", 6),
    ] {
        let options = ReadOptions { particles: select(words), ..ReadOptions::default() };
        assert_eq!(read(mol, &options)[0].scene.spheres.len(), count, "{words}");
    }
    let cell = |name: &str, edge: f64, x: f64| {
        let text =
            format!("1\nLattice=\"{edge} 0 0 0 {edge} 0 0 0 {edge}\" Properties=species:S:1:pos:R:3\nC {x} 0 0\n");
        file(&folder, name, &text)
    };
    let [small, large] = [cell("small.xyz", 2.0, 5.0), cell("large.xyz", 3.0, 7.0)];
    let mut options = options("1", &[&large, mol]);
    options.particles.periodic = Periodic::Wrap;
    let frame = read(&small, &options).remove(0);
    let x: Vec<f64> = frame.scene.spheres.centers.iter().map(|center| center[0]).collect();
    assert_eq!(x, [1.0, 1.0, 4.0, 5.5, 7.0], "each in its own cell; without a cell, none is moved");
    assert_eq!(frame.cell.expect("a cell").edges[0], [2.0, 0.0, 0.0], "the cell of the first");
}

#[test]
fn errors_name_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = files(&folder);
    let scene =
        file(&folder, "w.nff", "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 40\nhither 1\nresolution 8 8\ns 0 0 0 1\n");
    let bad = file(&folder, "bad.csv", "x,y,z,radius\n0,0,0,1\n1,0,0,-1\n");
    let far = file(&folder, "far.xyz", "2\n\nH 0 0 0\nH 1e308 0 0\n");
    let dash = Path::new("-");
    for (path, added, words) in [
        (&files[0], vec![scene.as_path()], vec!["w.nff is a whole scene (nff)", "file ="]),
        (&scene, vec![files[0].as_path()], vec!["w.nff is a whole scene"]),
        (&files[0], vec![&files[1], &bad], vec!["bad.csv:3:7: radius"]),
        (&files[0], vec![&far], vec!["far.xyz", "particle 1", "inf"]),
        (&files[0], vec![Path::new("none.csv")], vec!["none.csv"]),
        (&files[0], vec![dash, dash], vec!["standard input"]),
    ] {
        let mut options = options("1", &added);
        options.style.moves = vec![("x > 1e307".parse().expect("a selection"), [1e308, 0.0, 0.0])];
        let found = Sequence::open(path, &options).and_then(|mut sequence| sequence.next_scene());
        let error = found.map(drop).expect_err(words[0]).to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
}

#[test]
fn messages_name_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = files(&folder);
    let own = file(&folder, "own.csv", "x,y,z,radius,file\n0,0,0,1,7\n");
    let frame = read(&files[0], &options("1", &[&own])).remove(0);
    let message = frame.skipped.assumed.iter().find(|message| message.contains("the column file"));
    assert!(message.is_some_and(|message| message.starts_with("own: ")), "{:?}", frame.skipped.assumed);
}
