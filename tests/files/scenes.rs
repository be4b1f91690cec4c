//! Small scenes in the formats that describe spheres, and how tests read them.

use halfline::error::{Error, Result};
use halfline::scene::Scene;
use halfline_files::read::SceneFrame;
use halfline_files::read::{self, ParticleOptions, ReadOptions};

pub(crate) fn strict() -> ReadOptions {
    ReadOptions { particles: ParticleOptions { strict: true, ..Default::default() }, ..ReadOptions::default() }
}

pub(crate) const TOML: &str = r#"# a comment
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

pub(crate) const NFF: &str = "# a comment
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

pub(crate) const CSV: &str = "# atoms
radius, z,y,x ,r,g,b

1,-1e-3,1,0,0.5,0.5,0.5
# another
\"2.5\", 3, 2,0.1,1,0.5,0
";

pub(crate) const CAMERA: &str = "[camera]\neye = [0, 0, 5]\nview = [0, 0, -1]\nup = [0, 1, 0]\nviewport = [1, 1]\n";

/// A folder with these files.
pub(crate) fn folder(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).expect("a temporary file");
    }
    folder
}

/// The scene of a file and what its reader says of it.
pub(crate) fn read_frame(name: &str, content: &[u8], options: &ReadOptions) -> Result<SceneFrame> {
    let folder = folder(&[(name, content)]);
    read::scene(&folder.path().join(name), options)
}

pub(crate) fn read_with(name: &str, content: &[u8], options: &ReadOptions) -> Result<Scene> {
    read_frame(name, content, options).map(|frame| frame.scene)
}

pub(crate) fn read(name: &str, content: impl AsRef<[u8]>) -> Result<Scene> {
    read_with(name, content.as_ref(), &ReadOptions::default())
}

/// A scene of the canonical camera and the spheres of one file.
pub(crate) fn read_spheres(name: &str, content: &[u8]) -> Result<Scene> {
    let scene = format!("{CAMERA}[[spheres]]\nfile = '{name}'\n");
    let folder = folder(&[("scene.toml", scene.as_bytes()), (name, content)]);
    read::scene(&folder.path().join("scene.toml"), &ReadOptions::default()).map(|frame| frame.scene)
}

/// An NPY file of version 1 with this header text, from numpy's description of the format.
pub(crate) fn npy(header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16 + 1).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.push(b'\n');
    bytes.extend(data);
    bytes
}

pub(crate) fn npy_of(descr: &str, fortran: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    npy(&format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}"), data)
}

pub(crate) fn little(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Checks that reading fails with an error of the scene at this position and field, and with a remedy.
pub(crate) fn assert_refused(read: Result<Scene>, place: &str, field: &str, content: &str) {
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
