//! The promises of `--cryptomatte`: layers of an .exr by the specification, with the shares that the picture's own means have; tiles
//! merge to the whole file, `--resume` keeps it for the same names only.

use crate::test_dir::TestDir;
use halfline_files::write::buffers::FrameFile;
use halfline_measure::ArrayValue;
use std::collections::BTreeMap;

/// Six atoms in two chains, and one without a chain; of residue 7 one with the insertion code A.
const ATOMS: &str = "\
ATOM      1  CA  ALA A   7      -2.000   0.300   0.000  1.00 10.25           C  
ATOM      2  CB  ALA A   7      -0.800   1.000   1.000  1.00 11.50           C  
ATOM      3  CA  GLY A   7A      0.300  -0.700   0.500  1.00 12.00           C  
ATOM      4  CA  SER B   8       1.300   0.600   1.500  1.00 13.00           C  
ATOM      5  O   SER B   8       2.100  -0.800   0.200  1.00 14.00           O  
ATOM      6  O   HOH     9       0.500   1.900  -0.500  1.00 15.00           O  
";

/// A flat picture of it with 16 samples, whose shares are exact, from the front.
const PICTURE: &str = "atoms.pdb --size 60x40 --samples 16 --shade flat --view front --background black";

/// The ranks of a layer: the id in hexadecimal and the coverage of each object of each pixel.
fn ranks(dir: &TestDir, file: &str, layer: &str) -> Vec<Vec<(String, f64)>> {
    let buffers = FrameFile::read(&dir.path(file)).expect("a frame").buffers;
    let mut pixels = vec![Vec::new(); 60 * 40];
    for part in 0..3 {
        let name = format!("{layer}{part:02}");
        let found = buffers.iter().find(|buffer| buffer.name.as_ref() == Some(&name));
        let array = &found.unwrap_or_else(|| panic!("no {name}")).array;
        assert_eq!(array.shape(), [40, 60, 4], "{name}");
        for (n, pixel) in pixels.iter_mut().enumerate() {
            let at = |k: usize| array.values().get(4 * n + k).map_or(f64::NAN, ArrayValue::to_f64);
            let two = [0, 2].map(|k| (format!("{:08x}", (at(k) as f32).to_bits()), at(k + 1)));
            pixel.extend(two.into_iter().filter(|(_, coverage)| *coverage > 0.0));
        }
    }
    pixels
}

/// The manifests in the header of a file by the names of their layers.
fn manifests(dir: &TestDir, file: &str) -> BTreeMap<String, BTreeMap<String, String>> {
    let bytes = dir.get(file);
    // name, 0, type, 0, size, value.
    let value = |field: &str| {
        let mark = format!("/{field}\0string\0");
        let at = bytes.windows(mark.len()).enumerate().filter(|(_, part)| *part == mark.as_bytes());
        at.map(|(at, _)| {
            let from = at + mark.len();
            let size = u32::from_le_bytes(bytes[from..from + 4].try_into().expect("four")) as usize;
            String::from_utf8(bytes[from + 4..from + 4 + size].to_vec()).expect("UTF-8")
        })
        .collect::<Vec<_>>()
    };
    let layers = value("name").into_iter().zip(value("manifest"));
    assert!(value("hash").iter().all(|hash| hash == "MurmurHash3_32"));
    assert!(value("conversion").iter().all(|conversion| conversion == "uint32_to_float32"));
    layers.map(|(name, manifest)| (name, serde_json::from_str(&manifest).expect("JSON"))).collect()
}

fn dir() -> TestDir {
    TestDir::new(&[("atoms.pdb", ATOMS)])
}

#[test]
fn a_matte_has_the_share_that_the_colour_of_its_object_has() {
    let dir = dir();
    // Red, green and blue: in each channel the mean of the samples.
    let colors = [("chain A", "#f00"), ("chain B", "#0f0"), ("resname HOH", "#00f")];
    let mut words: Vec<&str> = PICTURE.split_whitespace().chain(["-o", "a.exr", "--cryptomatte", "chain"]).collect();
    let rules = colors.map(|(what, color)| format!("{what}={color}"));
    rules.iter().for_each(|rule| words.extend(["--color", rule]));
    dir.render(&words);
    let names = manifests(&dir, "a.exr").remove("CryptoChain").expect("the layer");
    assert_eq!(names.keys().collect::<Vec<_>>(), ["(blank)", "A", "B"]);
    let frame = FrameFile::read(&dir.path("a.exr")).expect("a frame");
    let color = frame.buffers.iter().find(|buffer| buffer.name.as_deref() == Some("color")).expect("a colour");
    let mut partly = 0;
    for (n, pixel) in ranks(&dir, "a.exr", "CryptoChain").iter().enumerate() {
        assert!(pixel.is_sorted_by(|a, b| a.1 >= b.1), "{pixel:?}");
        for (k, name) in ["A", "B", "(blank)"].into_iter().enumerate() {
            let share: f64 = pixel.iter().filter(|(id, _)| *id == names[name]).map(|(_, coverage)| coverage).sum();
            let mean = color.array.values().get(3 * n + k).map(ArrayValue::to_f64);
            assert_eq!(Some(share), mean, "{name} in pixel {n}");
            partly += usize::from(share > 0.0 && share < 1.0);
        }
    }
    assert!(partly > 100, "{partly} edges");
}

#[test]
fn objects_are_named_by_numbers_residues_and_columns() {
    let dir = dir();
    let layers =
        "--cryptomatte id --cryptomatte Residue --cryptomatte bfactor --cryptomatte element --cryptomatte serial";
    dir.render(&format!("{PICTURE} -o a.exr {layers}"));
    let all = manifests(&dir, "a.exr");
    let names: Vec<(&str, Vec<&str>)> =
        all.iter().map(|(layer, names)| (&layer[..], names.keys().map(String::as_str).collect())).collect();
    let expected = [
        ("CryptoBfactor", vec!["10.25", "11.5", "12", "13", "14", "15"]),
        ("CryptoElement", vec!["C", "O"]),
        ("CryptoId", vec!["0", "1", "2", "3", "4", "5"]),
        ("CryptoResidue", vec!["A/ALA/7", "A/GLY/7A", "B/SER/8", "HOH/9"]),
        ("CryptoSerial", vec!["1", "2", "3", "4", "5", "6"]),
    ];
    assert_eq!(names, expected);
    // Every sample that hits is in each layer.
    let covers = |layer: &str| -> Vec<f64> {
        ranks(&dir, "a.exr", layer).iter().map(|pixel| pixel.iter().map(|(_, coverage)| coverage).sum()).collect()
    };
    dir.render(&format!("{PICTURE} -o b.png --aov alpha=alpha.npy"));
    let (alpha, _) = dir.array("alpha.npy");
    for (layer, _) in expected {
        assert_eq!(covers(layer), alpha, "{layer}");
    }
}

#[test]
fn tiles_merge_and_resume_keeps_files_of_the_same_names() {
    let dir = dir();
    let layers = "--cryptomatte chain --cryptomatte id";
    dir.render(&format!("{PICTURE} -o whole.exr {layers}"));
    (1..=6).for_each(|tile| _ = dir.render(&format!("{PICTURE} -o {tile}.exr {layers} --tile {tile}/6")));
    assert!(manifests(&dir, "1.exr") != manifests(&dir, "whole.exr"), "a tile shows a part");
    dir.good("merge 1.exr 2.exr 3.exr 4.exr 5.exr 6.exr -o merged.exr");
    assert!(dir.get("merged.exr") == dir.get("whole.exr"), "the same bytes");
    let rendered =
        |words: &str| dir.render(&format!("{PICTURE} -o whole.exr {words} --resume")).err.contains("rendering on");
    assert!(!rendered(layers) && rendered("--cryptomatte chain") && rendered("") && rendered(layers));
    // Another chain changes no sphere.
    dir.put("atoms.pdb", ATOMS.replace("SER B", "SER C"));
    assert!(rendered(layers) && manifests(&dir, "whole.exr")["CryptoChain"].contains_key("C"));
    // A manifest is part of what the file's hash covers.
    let bytes = dir.get("whole.exr");
    let at = bytes.windows(4).position(|part| part == b"\"C\":").expect("a manifest");
    dir.put("whole.exr", [&bytes[..at], b"\"D\":", &bytes[at + 4..]].concat());
    dir.refused(3, "merge whole.exr -o other.exr", &["whole.exr", "changed or cut"]);
    assert!(rendered(layers));
}

#[test]
fn what_has_no_layers_is_refused() {
    let dir = dir();
    for (words, mend) in [
        ("-o a.png --cryptomatte chain", ".exr"),
        ("--aov id=a.exr --cryptomatte chain", "-o FILE.exr"),
        ("-o a.exr --cryptomatte color", "use id, or a column: name, resname"),
        ("-o a.exr --cryptomatte chain --cryptomatte Chain", "each column once"),
        ("-o a.exr --cryptomatte chain --opacity 0.5", "remove --opacity"),
        ("-o a.exr --cryptomatte chain --stream", "remove --cryptomatte"),
    ] {
        dir.refused_render(2, &format!("{PICTURE} {words}"), &[mend]);
    }
    dir.put("bare.xyz", "1\n\nC 0 0 0\n");
    dir.refused_render(2, "bare.xyz -o a.exr --cryptomatte residue", &["`resid`", "use id"]);
    dir.refused_render(2, "--visible part.npz -o a.exr --cryptomatte id", &["parts have no columns"]);
}
