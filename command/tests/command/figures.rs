//! The promise of `-o FILE.svg` and `FILE.pdf`: the visible part of each sphere as a path that says the same as the buffer of ids, with the
//! names of its columns; what only pixels show is refused with the mend.

use crate::test_dir::TestDir;

const ATOMS: &str = "\
ATOM      1  N   GLY A   1       0.000   0.000   0.000  1.00  9.00           N
ATOM      2  CA  GLY A   1       1.200   0.300   0.100  1.00  9.00           C
ATOM      3  O   GLY B   2       0.300   1.500   0.900  1.00  9.00           O
ATOM      4  C   GLY B   2       1.900   1.700   0.200  1.00  9.00           C
";

fn dir() -> TestDir {
    TestDir::new(&[("a.pdb", ATOMS), ("t.xyz", "1\n\nC 0 0 0\n1\n\nO 1 2 3\n")])
}

fn attributes(dir: &TestDir, file: &str, tag: &str, name: &str) -> Vec<String> {
    let text = String::from_utf8(dir.get(file)).expect("text");
    let document = roxmltree::Document::parse(&text).expect("well-formed XML");
    let tags = document.descendants().filter(|node| node.has_tag_name(tag));
    tags.filter_map(|node| node.attribute(name).map(str::to_owned)).collect()
}

#[test]
fn paths_are_those_of_the_visible_spheres() {
    let dir = dir();
    let output = dir.render("a.pdb --size 240x160 --legend-in --label {file} -o a.svg --aov id=id.npy --json");
    let figure = &output.json()["figure"];
    assert_eq!(figure["joined"], 0);
    assert_eq!(figure["bytes"], dir.get("a.svg").len());
    let paths = attributes(&dir, "a.svg", "path", "id");
    let (ids, _) = dir.array("id.npy");
    for id in 0..4 {
        assert_eq!(paths.contains(&format!("s{id}")), ids.contains(&f64::from(id)), "{id}");
    }
    let mut names = attributes(&dir, "a.svg", "path", "data-residue");
    names.sort();
    names.dedup();
    assert_eq!(names, ["A/GLY/1", "B/GLY/2"]);
    let texts = String::from_utf8(dir.get("a.svg")).expect("text");
    assert!(texts.contains(">a.pdb</text>") && texts.contains(">element</text>"), "{texts}");
    assert!(
        output.err.contains("a.svg has ") && output.err.contains("look soft: a figure has its lines"),
        "{}",
        output.err
    );
    // The same file again, and as PDF.
    dir.render("a.pdb --size 240x160 --legend-in --label {file} -o b.svg");
    assert!(dir.get("a.svg") == dir.get("b.svg"));
    dir.render("a.pdb --size 240x160 --legend-in --label {file} -o a.PDF");
    assert!(dir.get("a.PDF").starts_with(b"%PDF-1.7"));
}

#[test]
fn groups_are_those_of_columns() {
    let dir = dir();
    dir.render("a.pdb --size 60x40 -o a.svg --group chain --group element");
    let mut groups = attributes(&dir, "a.svg", "g", "id");
    groups.retain(|id| id != "spheres");
    assert_eq!(groups, ["chain-A-element-C", "chain-A-element-N", "chain-B-element-C", "chain-B-element-O"]);
    dir.render("a.pdb --size 60x40 -o b.svg --group chain --color-by chain --shade flat");
    assert_eq!(attributes(&dir, "b.svg", "path", "id").len(), 2);
    dir.render("a.pdb --size 60x40 -o c.svg --group sphere --shade flat");
    assert_eq!(attributes(&dir, "c.svg", "path", "id").len(), 4);
    // All is smaller than 90 pixels.
    let output = dir.render("a.pdb --size 60x40 -o d.svg --detail 90");
    assert!(output.err.contains("4 parts are smaller than --detail"), "{}", output.err);
}

#[test]
fn cuts_have_faces() {
    let dir = dir();
    dir.render("a.pdb --size 60x40 --cut 0,0,1,0.2 --view 0,0,-1 -o a.svg");
    let paths = attributes(&dir, "a.svg", "path", "id");
    assert!(paths.iter().any(|id| id.ends_with("-cut0")), "{paths:?}");
    // A normal has any length.
    for plane in ["0,0,1e-300,2e-301", "0,0,1e200,2e199"] {
        dir.render(&format!("a.pdb --size 60x40 --cut {plane} --view 0,0,-1 -o b.svg"));
        assert_eq!(attributes(&dir, "b.svg", "path", "id"), paths, "{plane}");
    }
}

#[test]
fn each_frame_has_a_figure() {
    let dir = dir();
    dir.render("t.xyz --frames 1-2 --size 20x20 -o f%d.svg");
    assert!(!dir.get("f1.svg").is_empty() && !dir.get("f2.svg").is_empty());
}

#[test]
fn what_only_pixels_show_is_refused() {
    let dir = dir();
    dir.put("glass.toml", "[camera]\neye=[0,0,9]\nview=[0,0,-1]\nup=[0,1,0]\nvfov=40\n[[sphere]]\ncenter=[0,0,0]\nradius=1\nmaterial='glass'\n");
    for (words, mend) in [
        ("a.pdb -o a.svg --opacity 0.5", "remove the opacity, or write a PNG"),
        ("a.pdb -o a.svg --sun 1,1,1", "remove the suns"),
        ("a.pdb -o a.svg --shadows", "remove the suns, the shadows"),
        ("a.pdb -o a.svg --occlusion", "remove the occlusion"),
        ("a.pdb -o a.svg --depth-cue", "depth cue"),
        ("a.pdb -o a.svg --shade normal", "flat or headlight"),
        ("a.pdb -o a.svg --aperture 0.1", "aperture"),
        ("a.pdb -o a.svg --samples 4", "--samples are of pixels"),
        ("a.pdb -o a.svg --crop 0,0,4,4", "parts of a picture"),
        ("a.pdb -o a.svg --trim", "--trim cuts pixels off"),
        ("a.pdb -o a.svg --resume", "use .png, or remove --resume"),
        ("a.pdb -o a.svg --cryptomatte id", "-o FILE.exr"),
        ("a.pdb -o a.svg --group nothing", "use id, or a column"),
        ("a.pdb -o a.svg --eye 0,0,0 --at 1,0,0", "move the eye away, or write a PNG"),
        ("a.pdb -o a.svg --eye 0,0,30 --at 0,0,0 --lens fisheye", "perspective or parallel camera"),
        ("glass.toml -o a.svg", "remove the materials"),
        ("a.pdb -o a.png --group chain", "use -o with the file name extension .svg or .pdf"),
        ("a.pdb -o a.png --detail 1", "use -o with the file name extension .svg or .pdf"),
        ("a.pdb -o a.svg --detail=-1", "from 0 to 100"),
        ("t.xyz -o a.svg --stream", "use a picture, or remove --stream"),
        ("--visible part.npz -o a.svg", "use a picture"),
        ("t.xyz --frames 1-2 -o a.svg", "a.%04d.svg"),
    ] {
        dir.refused_render(2, words, &[mend]);
    }
    dir.refused_render(8, "a.pdb -o none/a.svg", &["none"]);
    dir.put("same.svg", ATOMS);
    dir.refused_render(2, "same.svg --format pdb -o same.svg", &["is an input"]);
    assert!(!dir.path("a.svg").exists(), "nothing is written");
}
