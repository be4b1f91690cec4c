//! The promise of the readers: a scene is read to its exact values, or refused with the place and the mend.

use glam::DVec3;
use halfline::camera::{Lens, Look};
use halfline::error::{Error, Result};
use halfline::scene::{DEFAULT_COLOR, ReadOptions, Scene};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn strict() -> ReadOptions {
    ReadOptions { strict: true, ..ReadOptions::default() }
}

const TOML: &str = r#"# a comment
[camera]
eye = [0, 0, 5.5]
at = [0.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
vfov = 20
[image]
size = [120, 67]
background = [0.5, 0.25, 1.0]
[[sphere]]
center = [0.0, 1.0, -1e-3]
radius = 1
[[sphere]]
center = [0.1, 0x10, 9007199254740993]
radius = 2.5
color = [1, 0.5, 0]
"#;

const NFF: &str = "# a comment
b 0.5 0.25 1
v
from 0 0 5.5
at 0 0 0
up 0 1 0
angle 20
hither 0.01
resolution 120 67
l 4 3 2
l 4 3 2 1 1 1
s 0 1 -1e-3 1
f 1 0.5 0 0.8 0 100 0 1 # a fill
p 3
0 0 0
1 0 0
0 1 0
c
0 0 0 1
1 1 1 0
pp 3
0 0 0 0 0 1
1 0 0 0 0 1
0 1 0 0 0 1
c 0 0 0 1 1 1 1 1
s 0.1 16 9007199254740993
  2.5
";

const CSV: &str = "# atoms
radius, z,y,x ,r,g,b

1,-1e-3,1,0,0.5,0.5,0.5
# another
\"2.5\", 3, 2,0.1,1,0.5,0
";

const CAMERA: &str = "[camera]\neye = [0, 0, 5]\nview = [0, 0, -1]\nup = [0, 1, 0]\nviewport = [1, 1]\n";

/// A folder with these files.
fn folder(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).expect("a temporary file");
    }
    folder
}

fn read_with(name: &str, content: &[u8], options: &ReadOptions) -> Result<Scene> {
    let folder = folder(&[(name, content)]);
    Scene::read(&folder.path().join(name), options)
}

fn read(name: &str, content: impl AsRef<[u8]>) -> Result<Scene> {
    read_with(name, content.as_ref(), &ReadOptions::default())
}

/// A scene of the canonical camera and the spheres of one file.
fn read_spheres(name: &str, content: &[u8]) -> Result<Scene> {
    let scene = format!("{CAMERA}[[spheres]]\nfile = '{name}'\n");
    let folder = folder(&[("scene.toml", scene.as_bytes()), (name, content)]);
    Scene::read(&folder.path().join("scene.toml"), &ReadOptions::default())
}

/// An NPY file of version 1 with this header text, from numpy's description of the format.
fn npy(header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16 + 1).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.push(b'\n');
    bytes.extend(data);
    bytes
}

fn npy_of(descr: &str, fortran: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    npy(&format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}"), data)
}

fn little(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

#[test]
fn the_same_scene_in_toml_and_nff_has_its_exact_values() {
    let crlf = |text: &str| text.replace('\n', "\r\n");
    let marked = |text: &str| format!("\u{feff}{text}");
    // Names without a known ending are told by their content.
    let files = [
        ("s.toml", TOML.to_owned()),
        ("s.TOML", crlf(TOML)),
        ("s.txt", marked(TOML)),
        ("s", TOML.to_owned()),
        ("s.nff", NFF.to_owned()),
        ("s.NFF", crlf(NFF)),
        ("s.txt", marked(NFF)),
        ("s", crlf(NFF)),
    ];
    for (name, content) in files {
        let scene = read(name, &content).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(scene.camera.eye, DVec3::new(0.0, 0.0, 5.5), "{name}");
        assert_eq!((scene.camera.look, scene.camera.up), (Look::At(DVec3::ZERO), DVec3::Y), "{name}");
        let nff = content.contains("hither");
        let lens = if nff { Lens::RowCentres { degrees: 20.0 } } else { Lens::Vfov { degrees: 20.0, distance: 1.0 } };
        assert_eq!(scene.camera.lens, lens, "{name}");
        let image = scene.image;
        assert_eq!((image.width, image.height, image.background), (120, 67, [0.5, 0.25, 1.0]), "{name}");
        assert_eq!(scene.spheres.centers, [[0.0, 1.0, -1e-3], [0.1, 16.0, 9007199254740992.0]], "{name}");
        assert_eq!(scene.spheres.radii, [1.0, 2.5], "{name}");
        assert_eq!(scene.spheres.colors, Some(vec![DEFAULT_COLOR, [1.0, 0.5, 0.0]]), "{name}");
        let kinds = [("polygon", 1), ("cone", 2), ("polygonal patch", 1)];
        assert_eq!(scene.skipped.kinds, if nff { kinds.to_vec() } else { Vec::new() }, "{name}");
        scene.check().expect("what is read can be rendered");
    }
}

#[test]
fn defaults_and_the_other_camera_keys() {
    let scene = read("s.toml", CAMERA).expect("no sphere is a scene too");
    assert_eq!((scene.image.width, scene.image.height, scene.image.background), (512, 512, [0.0; 3]));
    assert_eq!(scene.camera.look, Look::View(DVec3::NEG_Z));
    assert_eq!(scene.camera.lens, Lens::Viewport { vw: 1.0, vh: 1.0, distance: 1.0 });
    assert!(scene.spheres.is_empty() && scene.spheres.colors.is_none());
    let far = read("s.toml", CAMERA.to_owned() + "distance = 2\n").expect("a distance");
    assert_eq!(far.camera.lens, Lens::Viewport { vw: 1.0, vh: 1.0, distance: 2.0 });
    let vfov = CAMERA.replace("viewport = [1, 1]", "distance = 2.0\nvfov = 40.5");
    assert_eq!(read("s.toml", vfov).expect("vfov").camera.lens, Lens::Vfov { degrees: 40.5, distance: 2.0 });
    let height = CAMERA.replace("viewport = [1, 1]", "height = 12.5");
    assert_eq!(read("s.toml", height).expect("height").camera.lens, Lens::Orthographic { height: 12.5 });
    let bare = "v\nangle 9\nresolution 3 2\nup 0 1 0\nat 0 0 0\nfrom 0 0 1\ns 0 0 0 1";
    let scene = read("s.nff", bare).expect("no hither, any order, no last line end");
    assert_eq!((scene.spheres.len(), scene.spheres.colors, scene.image.background), (1, None, [0.0; 3]));
}

#[test]
fn csv_and_npy_have_their_exact_values() {
    let rows = [[0.0, 1.0, -1e-3, 1.0, 0.5, 0.5, 0.5], [0.1, 2.0, 3.0, 2.5, 1.0, 0.5, 0.0]];
    let flat = rows.concat();
    let columns: Vec<f64> = (0..7).flat_map(|k| rows.iter().map(move |row| row[k])).collect();
    let big: Vec<u8> = flat.iter().flat_map(|x| x.to_be_bytes()).collect();
    let single = |x: &f64| (*x as f32).to_le_bytes();
    let files = [
        ("a.csv", CSV.as_bytes().to_vec()),
        ("a.CSV", CSV.replace('\n', "\r\n").into_bytes()),
        ("a.csv", format!("\u{feff}{}", &CSV[8..]).into_bytes()),
        ("a.npy", npy_of("<f8", "False", "(2, 7)", &little(&flat))),
        ("a.npy", npy_of(">f8", "False", "(2, 7)", &big)),
        ("a.npy", npy_of("<f8", "True", "(2, 7)", &little(&columns))),
        ("a.npy", npy_of("<f4", "False", "(2, 7)", &flat.iter().flat_map(single).collect::<Vec<_>>())),
        ("a.npy", npy_of("<f4", "True", "(2, 7)", &columns.iter().flat_map(single).collect::<Vec<_>>())),
    ];
    for (index, (name, content)) in files.iter().enumerate() {
        let spheres = read_spheres(name, content).unwrap_or_else(|e| panic!("{index}: {e}")).spheres;
        let wide = |x: f64| if index >= 6 { f64::from(x as f32) } else { x };
        assert_eq!(spheres.centers, rows.map(|r| [r[0], r[1], r[2]].map(wide)), "{index}");
        assert_eq!(spheres.radii, rows.map(|r| wide(r[3])), "{index}");
        assert_eq!(spheres.colors, Some(rows.map(|r| [r[4], r[5], r[6]].map(|c| c as f32)).to_vec()), "{index}");
    }
    let empty = [("a.csv", b"x,y,z,radius\n".to_vec()), ("a.npy", npy_of("<f8", "True", "(0, 4)", b""))];
    for (name, content) in empty {
        assert!(read_spheres(name, &content).expect("no rows").spheres.is_empty());
    }
}

#[test]
fn ids_count_inline_spheres_first_and_files_stand_beside_the_scene() {
    let scene = format!(
        "{CAMERA}[[spheres]]\nfile = 'a.csv'\n[[sphere]]\ncenter = [9, 9, 9]\nradius = 9\n[[spheres]]\nfile = \"b.npy\"\n"
    );
    let b = npy_of("<f8", "False", "(1, 4)", &little(&[3.0, 3.0, 3.0, 3.0]));
    let folder = folder(&[("s.toml", scene.as_bytes()), ("a.csv", b"x,y,z,radius\n1,1,1,1\n2,2,2,2"), ("b.npy", &b)]);
    let path = folder.path().join("s.toml");
    let scene = Scene::read(&path, &strict()).expect("three kinds of spheres");
    assert_eq!(scene.spheres.radii, [9.0, 1.0, 2.0, 3.0]);
    assert_eq!(scene.spheres.colors, None);
    std::fs::remove_file(folder.path().join("b.npy")).expect("removed");
    match Scene::read(&path, &ReadOptions::default()) {
        Err(Error::Io { path, .. }) => assert_eq!(path, folder.path().join("b.npy")),
        other => panic!("a missing file is an Io error: {other:?}"),
    }
}

#[test]
fn a_file_of_spheres_alone_is_framed() {
    let npy = npy_of("<f8", "False", "(2, 4)", &little(&[0.0, 1.0, -1e-3, 1.0, 0.1, 2.0, 3.0, 2.5]));
    for (name, content) in [("s.csv", CSV.as_bytes()), ("s", CSV.as_bytes()), ("s.npy", &npy), ("s", &npy)] {
        let scene = read(name, content).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(scene.spheres.centers, [[0.0, 1.0, -1e-3], [0.1, 2.0, 3.0]], "{name}");
        assert_eq!(scene.spheres.radii, [1.0, 2.5], "{name}");
        scene.check().expect("from a camera that shows all of it");
        assert!(scene.skipped.warnings().is_empty(), "{:?}", scene.skipped);
    }
}

#[test]
fn what_cannot_be_read_is_io() {
    let folder = folder(&[]);
    for name in ["missing.toml", "missing.nff", "missing", "."] {
        let path = folder.path().join(name);
        match Scene::read(&path, &ReadOptions::default()) {
            Err(Error::Io { path: named, action: "read", .. }) => assert_eq!(named, path),
            other => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn lights_and_materials_are_counted_or_refused() {
    let scene =
        |lines: &str| format!("v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 20\nresolution 9 9\n{lines}\ns 0 0 0 1\n");
    for (lines, warnings, refused) in [
        ("f 1 0.5 0", vec![], None),
        ("f 1 0.5 0 1 0 30 0 1.5", vec![], None),
        ("l 1 2 3", vec!["1 light left out"], Some(":7:1: light: a light is not modelled")),
        ("f 1 1 1\nl 1 2 3\nl 4 5 6 1 1 1", vec!["2 lights left out"], Some(":8:1: light: ")),
        ("f 1 0.5 0 0.8 0 0 0 0", vec!["1 material reduced to the colour"], Some(":7:1: fill: a material")),
        ("f 1 0.5 0 1 0.5 3 0 0", vec!["1 material reduced"], Some(":7:1: fill: ")),
        ("f 1 0.5 0 1 0 0 0.5 1.5\nf 1 1 1 0 0 0 0 0\nl 0 0 0", vec!["1 light ", "2 materials "], Some(":7:1: fill: ")),
    ] {
        let found = read("s.nff", scene(lines)).expect("lenient").skipped;
        assert_eq!(found.total(), 0, "lights and materials are no things");
        let said = found.warnings();
        assert!(
            said.len() == warnings.len() && said.iter().zip(&warnings).all(|(said, start)| said.starts_with(start)),
            "{said:?}"
        );
        match (read_with("s.nff", scene(lines).as_bytes(), &strict()), refused) {
            (Ok(_), None) => {}
            (Err(error), Some(place)) => assert!(error.to_string().contains(&format!("s.nff{place}")), "{error}"),
            (found, _) => panic!("{lines}: {found:?}"),
        }
    }
}

#[test]
fn strict_refuses_what_lenient_counts() {
    for (line, place, kind) in [("p 3\n0 0 0 1 0 0 0 1 0", ":9:1", "polygon"), ("c 0 0 0 1 0 0 1 1", ":9:1", "cone")] {
        let scene = format!("v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 20\nresolution 9 9\ns 0 0 0 1\n\n{line}\n");
        assert_eq!(read("s.nff", &scene).expect("lenient").skipped.kinds, [(kind, 1)]);
        let error = read_with("s.nff", scene.as_bytes(), &strict()).expect_err("strict").to_string();
        assert!(error.contains(&format!("s.nff{place}: {kind}: ")), "{error}");
    }
    read_with("s.toml", TOML.as_bytes(), &strict()).expect("nothing to skip");
}

/// What every refusal must be: a fault of the scene, at this place, of this field, with a mend.
fn assert_refused(read: Result<Scene>, place: &str, field: &str, content: &str) {
    match read.map(drop) {
        Err(Error::Scene { place: found, problem, mend, .. }) => {
            let text = found.to_string();
            let line = format!("{text}: {problem}; {mend}");
            let tail = if field.is_empty() { place.to_owned() } else { format!("{place}: {field}") };
            assert!(text.ends_with(&tail), "wanted {place}: {field}, got {line}\n{content}");
            assert!(!problem.is_empty() && !mend.is_empty(), "{line}");
            assert!(!line.contains('\n'), "one line: {line}");
        }
        other => panic!("wanted a refusal at {place} {field}, got {other:?}\n{content}"),
    }
}

#[test]
fn a_broken_toml_is_refused_at_its_place() {
    // (what stands in TOML, what is put there, place, field)
    let cases = [
        ("radius = 1\n", "radius = -1\n", ":12:10", "sphere 0 radius"),
        ("radius = 2.5", "radius = 0", ":15:10", "sphere 1 radius"),
        ("radius = 2.5", "radius = nan", ":15:10", "sphere 1 radius"),
        ("radius = 2.5", "radius = 1e999", ":15:10", "sphere 1 radius"),
        ("radius = 2.5", "radius = '2'", ":15:10", "sphere 1 radius"),
        ("radius = 2.5", "radius = 0xfffffffffffffffffffffffffffffffff", ":15:10", "sphere 1 radius"),
        ("radius = 2.5\n", "", ":13:1", "sphere 1 radius"),
        ("radius = 2.5", "radius = 2.5\nrdius = 1", ":16:1", "sphere 1 rdius"),
        ("radius = 2.5", "radius = 2.5\nradius = 1", ":16:1", "radius"),
        ("radius = 2.5", "radius = 2.5.5", ":15:13", ""),
        ("[0.0, 1.0, -1e-3]", "[0.0, inf, 0.0]", ":11:16", "sphere 0 center"),
        ("[0.0, 1.0, -1e-3]", "[0.0, 1.0]", ":11:10", "sphere 0 center"),
        ("[0.0, 1.0, -1e-3]", "[0.0, 1.0, 2.0, 3.0]", ":11:10", "sphere 0 center"),
        ("[0.0, 1.0, -1e-3]", "[0.0, 1.0, true]", ":11:21", "sphere 0 center"),
        ("[0.0, 1.0, -1e-3]", "3", ":11:10", "sphere 0 center"),
        ("[1, 0.5, 0]", "[1, -0.5, 0]", ":16:9", "sphere 1 color"),
        ("[1, 0.5, 0]", "[1, 1e300, 0]", ":16:9", "sphere 1 color"),
        ("size = [120, 67]", "size = [0, 67]", ":8:8", "image.size"),
        ("size = [120, 67]", "size = [120, 67.0]", ":8:14", "image.size"),
        ("size = [120, 67]", "size = [120, 99999999999999999999]", ":8:14", "image.size"),
        ("size = [120, 67]", "size = [120, 9999999999]", ":8:8", "image.size"),
        ("background = [0.5", "background = [-0.5", ":9:14", "image.background"),
        ("background", "backgruond", ":9:1", "image.backgruond"),
        ("at = [0.0, 0.0, 0.0]", "at = [0, 0, 5.5]", ":4:6", "camera.at"),
        ("at = [0.0, 0.0, 0.0]", "view = [0, 0, 0]", ":4:8", "camera.view"),
        ("at = [0.0, 0.0, 0.0]", "at = [0, 0, 0]\nview = [0, 0, 1]", ":5:8", "camera.view"),
        ("at = [0.0, 0.0, 0.0]\n", "", ":2:1", "camera.at"),
        ("up = [0.0, 1.0, 0.0]", "up = [0, 0, 1]", ":5:6", "camera.up"),
        ("up = [0.0, 1.0, 0.0]", "\"up\" = [0, 0, 0]", ":5:8", "camera.up"),
        ("eye = [0, 0, 5.5]\n", "", ":2:1", "camera.eye"),
        ("vfov = 20", "vfov = 180", ":6:8", "camera.vfov"),
        ("vfov = 20", "vfov = 0", ":6:8", "camera.vfov"),
        ("vfov = 20", "vfov = 20\nviewport = [1, 1]", ":7:12", "camera.viewport"),
        ("vfov = 20", "viewport = [1, -1]", ":6:12", "camera.viewport"),
        ("vfov = 20", "vfov = 20\ndistance = 0", ":7:12", "camera.distance"),
        ("vfov = 20", "vfov = 179\ndistance = 1e308", ":6:8", "camera.viewport"),
        ("vfov = 20\n", "", ":2:1", "camera.vfov"),
        ("vfov = 20", "height = 0", ":6:10", "camera.height"),
        ("vfov = 20", "height = 1\nvfov = 20", ":7:8", "camera.vfov"),
        ("vfov = 20", "vfov = 20\nheight = 1", ":7:10", "camera.height"),
        ("vfov = 20", "height = 1\nviewport = [1, 1]", ":7:12", "camera.viewport"),
        ("vfov = 20", "height = 1\ndistance = 1", ":7:12", "camera.distance"),
        ("[camera]", "[cámera]", ":2:3", ""),
        ("[camera]", "[sphere]", ":10:3", "sphere"),
        ("[image]", "[imagé]", ":7:6", ""),
        ("[image]", "[[image]]", ":7:1", "image"),
        ("[image]", "[lights]", ":7:2", "lights"),
        ("# a comment", "# a \u{0} comment", ":1:5", ""),
        ("# a comment", "spheres = 1", ":1:11", "spheres"),
        ("# a comment", "spheres = [{}]", ":1:12", "spheres 0 file"),
        ("# a comment", "spheres = [{file = 'é.pdb'}]", ":1:20", "spheres 0 file"),
        ("# a comment", "spheres = [{file = 1}]", ":1:20", "spheres 0 file"),
        ("# a comment", "spheres = [{file = 'a.csv', scale = 2}]", ":1:29", "spheres 0 scale"),
    ];
    for (old, new, place, field) in cases {
        assert!(TOML.contains(old), "{old}");
        let content = TOML.replacen(old, new, 1);
        for content in [content.replace('\n', "\r\n"), content] {
            assert_refused(read("s.toml", &content), &format!("s.toml{place}"), field, &content);
        }
    }
    assert_refused(read("s.toml", ""), "s.toml:1:1", "camera", "");
    let odd = format!("sphere = [1]\n{CAMERA}");
    assert_refused(read("s.toml", &odd), "s.toml:1:11", "sphere", &odd);
    assert_refused(read("s", ""), "s:1:1", "camera", "");
    assert_refused(read("s.toml", b"# \xc3\xa9\n# \xc3\xa9\xff\n"), "s.toml:2:4", "", "");
    let deep = "a = ".to_owned() + &"[".repeat(100_000);
    assert!(matches!(read("s.toml", deep), Err(Error::Scene { .. })));
    let dotted = "a".to_owned() + &".a".repeat(100_000) + " = 1";
    assert!(matches!(read("s.toml", dotted), Err(Error::Scene { .. })));
}

#[test]
fn a_broken_nff_is_refused_at_its_place() {
    // (what stands in NFF, what is put there, place, field)
    let cases = [
        ("s 0 1 -1e-3 1", "s 0 1 -1e-3 -1", ":12:13", "sphere 0 radius"),
        ("s 0 1 -1e-3 1", "s 0 1 -1e-3", ":12:1", "sphere 0"),
        ("s 0 1 -1e-3 1", "s 0 1 -1e-3 é 1", ":12:13", "sphere 0"),
        ("s 0 1 -1e-3 1", "s 0 1 -1e-3 1 1", ":12:15", ""),
        ("s 0 1 -1e-3 1", "s 0 1 -1e-3 1 s 0 0 0 1", ":12:15", ""),
        ("s 0 1 -1e-3 1", "s 0 nan -1e-3 1", ":12:5", "sphere 0"),
        ("s 0 1 -1e-3 1", "s 0 1 1e999 1", ":12:7", "sphere 0"),
        ("  2.5", "  0", ":27:3", "sphere 1 radius"),
        ("  2.5\n", "", ":26:1", "sphere 1"),
        ("b 0.5 0.25 1", "b 0.5 0.25 -1", ":2:3", "background"),
        ("b 0.5 0.25 1", "b 0.5 0.25 1\nb 1 1 1", ":3:1", ""),
        ("l 4 3 2\n", "l 4 3\n", ":10:1", "light"),
        ("l 4 3 2\n", "l 4 3 2 1\n", ":10:1", "light"),
        ("f 1 0.5", "f -1 0.5", ":13:3", "fill"),
        ("p 3\n0", "p 2\n0", ":14:3", "polygon"),
        ("p 3\n0", "p 3.5\n0", ":14:3", "polygon"),
        ("p 3\n0", "p 1e30\n0", ":14:1", "polygon"),
        ("pp 3", "pp 4", ":21:1", "polygonal patch"),
        ("c\n", "c 1\n", ":20:7", ""),
        ("c 0 0 0 1 1", "c 0 0 0 1", ":25:1", "cone"),
        ("l 4 3 2\n", "L 4 3 2\n", ":10:1", ""),
        ("l 4 3 2\n", "l 4 3 2\nhither 3\n", ":11:1", ""),
        ("l 4 3 2\n", "v\n", ":10:1", ""),
        ("from 0 0 5.5", "from 0 0", ":4:1", "camera.from"),
        ("from 0 0 5.5", "from 0 0 0", ":5:1", "camera.at"),
        ("from 0 0 5.5\n", "", ":3:1", "camera.from"),
        ("angle 20", "angle 180", ":7:1", "camera.angle"),
        ("angle 20\n", "", ":3:1", "camera.angle"),
        ("up 0 1 0", "up 0 0 1", ":6:1", "camera.up"),
        ("up 0 1 0", "up 0 1 0\nup 0 1 0", ":7:1", "camera.up"),
        ("resolution 120 67", "resolution 120 0", ":9:1", "camera.resolution"),
        ("resolution 120 67", "resolution 120 -6", ":9:16", "camera.resolution"),
        ("resolution 120 67", "resolution 120 6.5", ":9:16", "camera.resolution"),
        ("resolution 120 67", "resolution 120 1e99", ":9:1", "camera.resolution"),
    ];
    for (old, new, place, field) in cases {
        assert!(NFF.contains(old), "{old}");
        let content = NFF.replacen(old, new, 1);
        for content in [content.replace('\n', "\r\n"), content] {
            assert_refused(read("s.nff", &content), &format!("s.nff{place}"), field, &content);
        }
    }
    assert_refused(read("s.nff", "s 0 0 0 1"), "s.nff", "camera", "");
    assert_refused(read("s.nff", ""), "s.nff", "camera", "");
    assert_refused(read("s.nff", b"# \xc3\xa9\nb 1 \xff\n"), "s.nff:2:5", "", "");
}

#[test]
fn a_broken_csv_is_refused_at_its_place() {
    let cases: [(&[u8], &str, &str); 17] = [
        (b"", "", ""),
        (b"\n# nothing\n", "", ""),
        (b"x,y,z\n", ":1:1", "header"),
        (b"x,y,z,radius,r,g\n", ":1:1", "header"),
        (b"x,y,z, name,radius\n", ":1:8", "header"),
        (b"x,y,z,x,radius\n", ":1:7", "header"),
        (b"0,0,0,1\n", ":1:1", "header"),
        (b"x,y,z,radius\n0,0,0\n", ":2:6", "radius"),
        (b"x,y,z,radius\n0,0,0,1,\n", ":2:9", "row"),
        (b"x,y,z,radius\r\n#\r\n\r\n0,0, one,1\r\n", ":4:6", "z"),
        (b"x,y,z,radius\n0,,0,1\n", ":2:3", "y"),
        (b"x,y,z,radius\n0,0,0,nan\n", ":2:7", "radius"),
        (b"x,y,z,radius\n0,0,0,1\n0,0,0,-1\n", ":3:7", "radius"),
        (b"x,y,z,radius\n0,0,0,0", ":2:7", "radius"),
        (b"r,g,b,x,y,z,radius\n0,-1,0,0,0,0,1\n", ":2:1", "color"),
        (b"x,y,z,radius\n0,\xc3\xa9,0,\xff\n", ":2:7", ""),
        (b"x,y,z,radius\n0,\"0\n\",0,1\n", ":2:3", "y"),
    ];
    for (content, place, field) in cases {
        let text = String::from_utf8_lossy(content);
        assert_refused(read_spheres("a.csv", content), &format!("a.csv{place}"), field, &text);
    }
}

#[test]
fn a_broken_npy_is_refused_with_its_row() {
    let two = little(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]);
    let one = &two[..32];
    let huge = format!("({}, 4)", 1u64 << 60);
    let cases = [
        (Vec::new(), "header"),
        (b"x,y,z,radius\n0,0,0,1\n".to_vec(), "magic"),
        (npy("{'descr': ", b""), "header"),
        (npy_of("<f8", "False", "(1, 4)", one)[..40].to_vec(), "header"),
        (npy_of("<i8", "False", "(1, 4)", one), "dtype"),
        (npy_of("<f2", "False", "(1, 4)", one), "dtype"),
        (npy_of("|O", "False", "(1, 4)", one), "dtype"),
        (npy_of("<f8", "False", "(4,)", one), "shape"),
        (npy_of("<f8", "False", "(4, 1)", one), "shape"),
        (npy_of("<f8", "False", "(1, 1, 4)", one), "shape"),
        (npy_of("<f8", "False", "()", one), "shape"),
        (npy_of("<f8", "False", "(2, 4)", &two[..60]), "data"),
        (npy_of("<f8", "True", "(2, 4)", &two[..60]), "data"),
        (npy_of("<f8", "False", "(1, 4)", &two), "data"),
        (npy_of("<f8", "False", "(10000000000000000, 4)", one), "data"),
        (npy_of("<f8", "True", "(10000000000000000, 4)", one), "data"),
        (npy_of("<f8", "False", &huge, one), "header"),
        (npy_of("<f8", "False", "(0xffffffffffffffff, 0xffffffffffffffff)", one), "header"),
        (npy(&"(".repeat(9000), b""), "header"),
        (npy(&"9".repeat(20_000), b""), "header"),
        ([b"\x93NUMPY\x02\x00\xff\xff\xff\xff".as_slice(), one].concat(), "header"),
        ([b"\x93NUMPY\x09\x00\x01\x00\x00\x00".as_slice(), one].concat(), "header"),
        (npy_of("<f8", "False", "(2, 4)", &two), "row 1 radius"),
        (npy_of("<f8", "True", "(1, 4)", &little(&[0.0, f64::NAN, 0.0, 1.0])), "row 0 center"),
        (npy_of("<f8", "False", "(1, 7)", &little(&[0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0])), "row 0 color"),
    ];
    let begun = Instant::now();
    for (content, field) in cases {
        assert_refused(read_spheres("a.npy", &content), "a.npy", field, &String::from_utf8_lossy(&content));
    }
    assert!(begun.elapsed() < Duration::from_secs(5), "a claim of 2^60 rows costs nothing");
}

#[test]
fn standard_input_is_a_scene_too() {
    const CHILD: &str = "HALFLINE_TEST_STDIN";
    if let Ok(spheres) = std::env::var(CHILD) {
        let scene = Scene::read(Path::new("-"), &ReadOptions::default()).expect("the parent's scene");
        assert_eq!(scene.spheres.len().to_string(), spheres);
        return;
    }
    let folder = folder(&[("a.csv", CSV.as_bytes())]);
    let with_file = TOML.to_owned() + "[[spheres]]\nfile = 'a.csv'\n";
    for (content, spheres) in [(TOML, "2"), (NFF, "2"), (&with_file, "4")] {
        let mut child = Command::new(std::env::current_exe().expect("this test"))
            .args(["--exact", "standard_input_is_a_scene_too"])
            .env(CHILD, spheres)
            .current_dir(folder.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .expect("this test again");
        child.stdin.take().expect("piped").write_all(content.as_bytes()).expect("written");
        assert!(child.wait().expect("waited").success(), "{content}");
    }
}

/// Damages bytes in one of the ways that files are damaged; the seed is fixed.
struct Vandal(u64);

impl Vandal {
    fn below(&mut self, n: usize) -> usize {
        // xorshift64, Marsaglia 2003.
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n.max(1) as u64) as usize
    }

    fn damage(&mut self, good: &[u8]) -> Vec<u8> {
        const SCRAPS: [&[u8]; 16] = [
            b"\n",
            b"-",
            b"nan",
            b"1e999",
            b"[",
            b"]",
            b"\"",
            b"'",
            b"\xff",
            b"9999999999999999999",
            b"#",
            b",",
            b"p 3",
            b"[[",
            b"\0",
            b"(",
        ];
        let mut bytes = good.to_vec();
        for _ in 0..=self.below(3) {
            let at = self.below(bytes.len());
            let to = (at + self.below(12)).min(bytes.len());
            match self.below(6) {
                0 => bytes.truncate(at),
                1 => drop(bytes.drain(at..to)),
                2 => bytes.extend_from_within(at..to),
                3 if !bytes.is_empty() => bytes[at] ^= 1 << self.below(8),
                4 if !bytes.is_empty() => bytes[at] = b"0123456789 \n"[self.below(12)],
                _ => drop(bytes.splice(at..at, SCRAPS[self.below(SCRAPS.len())].iter().copied())),
            }
        }
        bytes
    }
}

#[test]
fn no_damage_makes_a_reader_panic() {
    let npy = npy_of("<f8", "False", "(2, 4)", &little(&[0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0]));
    let good: [(&str, &[u8]); 4] =
        [("s.toml", TOML.as_bytes()), ("s.nff", NFF.as_bytes()), ("a.csv", CSV.as_bytes()), ("a.npy", &npy)];
    let mut vandal = Vandal(0x9e37_79b9_7f4a_7c15);
    for (name, good) in good {
        let scene = if name.starts_with('a') { "scene.toml" } else { name };
        let folder = folder(&[("scene.toml", format!("{CAMERA}[[spheres]]\nfile = '{name}'\n").as_bytes())]);
        let (begun, mut refused) = (Instant::now(), 0);
        for round in 0..2000 {
            let bytes = vandal.damage(good);
            std::fs::write(folder.path().join(name), &bytes).expect("a temporary file");
            match Scene::read(&folder.path().join(scene), &ReadOptions::default()) {
                Ok(scene) => scene.check().unwrap_or_else(|e| panic!("{name} {round}: read, but {e}: {bytes:?}")),
                Err(Error::Scene { .. } | Error::Io { .. }) => refused += 1,
                Err(other) => panic!("{name} {round}: {other}: {bytes:?}"),
            }
        }
        assert!((200..2000).contains(&refused), "{name}: {refused} of 2000 refused");
        assert!(begun.elapsed() < Duration::from_secs(60), "{name}: {:?}", begun.elapsed());
    }
}

/// The scenes that nobody here wrote, where they are.
fn data() -> Option<PathBuf> {
    let beside = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data"));
    let folder = std::env::var_os("HALFLINE_DATA").map_or(beside, PathBuf::from);
    folder.is_dir().then_some(folder)
}

#[test]
fn real_nff_files_give_the_spheres_of_their_readme() {
    let Some(data) = data() else {
        eprintln!("SKIPPED: no ../shared/data here and HALFLINE_DATA names no folder");
        return;
    };
    for (name, spheres, kind, size) in [
        ("balls_s2.nff", 91, "polygon", 512),
        ("balls_s4.nff", 7381, "polygon", 512),
        ("shells.nff", 5761, "", 512),
        ("jacks.nff", 6, "cone", 256),
    ] {
        let path = data.join(name);
        let scene = Scene::read(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scene.spheres.len(), spheres, "{name}");
        assert_eq!((scene.image.width, scene.image.height), (size, size), "{name}");
        let text = std::fs::read_to_string(&path).expect("read once already");
        let count = |prefix: &str| text.lines().filter(|line| line.starts_with(prefix)).count() as u64;
        assert_eq!(count("s "), spheres as u64, "{name}");
        assert_eq!(scene.skipped.total(), count("c ") + count("p ") + count("pp "), "{name}");
        assert!(scene.skipped.kinds.iter().all(|(k, _)| *k == kind), "{name} {:?}", scene.skipped);
        // Each has lights, and fills that reflect.
        Scene::read(&path, &strict()).expect_err(name);
        let said = scene.skipped.warnings().join("; ");
        let (lights, fills) = (count("l "), count("f "));
        let plural = |n: u64| if n == 1 { "" } else { "s" };
        for told in
            [format!("{lights} light{} left out", plural(lights)), format!("{fills} material{} reduced", plural(fills))]
        {
            assert!(said.contains(&told), "{name}: {said}");
        }
        scene.check().expect("what is read can be rendered");
    }
    let csv = std::fs::read(data.join("solar_system.csv")).expect("the planets");
    assert_refused(read_spheres("a.csv", &csv), "a.csv:1:1", "header", "its columns have other names");
    let planets =
        Scene::read(&data.join("solar_system.csv"), &ReadOptions::default()).expect("the Sun and its planets");
    assert_eq!((planets.spheres.len(), planets.spheres.radii[0]), (11, 695700.0));
    assert_eq!(planets.spheres.centers[3], [76580651.925311, 114940047.833629, 49846795.759752], "the Earth");
}
