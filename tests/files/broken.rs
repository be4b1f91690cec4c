//! The promise of the readers about broken files: they are refused with the position, the field and a remedy.

use crate::damage::damage;
use crate::numpy::{little, npy, npy_of};
use crate::rng::Rng;
use crate::scenes::{CAMERA, CSV, NFF, TOML, assert_refused, folder, read, read_spheres};
use halfline::error::Error;
use halfline_files::read::{Format, ParticleOptions, ReadOptions, Sequence};
use std::io::{Cursor, Read};
use std::path::Path;
use std::time::{Duration, Instant};

#[test]
fn a_broken_toml_is_refused_at_its_place() {
    // (text in TOML, its replacement, place, field)
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
        ("# a comment", "spheres = [{file = 'é.txt'}]", ":1:20", "spheres 0 file"),
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
    // (text in NFF, its replacement, place, field)
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
fn a_broken_light_is_refused_at_its_place() {
    // (lines after [[light]] or [occlusion], place, field, a part of the message)
    let cases = [
        ("[[light]]\n", ":17:1", "light 0 direction", "add direction ="),
        ("[[light]]\ndirection = [0, 0, 0]", ":18:13", "light 0 direction", "length zero"),
        ("[[light]]\ndirection = [0, 0]", ":18:13", "light 0 direction", "expected 3 values"),
        ("[[light]]\ndirection = [0, 0, inf]", ":18:20", "light 0 direction", "finite"),
        ("[[light]]\ndirection = 1", ":18:13", "light 0 direction", "expected an array"),
        ("[[light]]\ndirection = [0, 0, 1]\nposition = [0, 0, 1]", ":19:12", "light 0 position", "exclude each other"),
        ("[[light]]\nsphere = 0\nposition = [0, 0, 1]", ":19:12", "light 0 position", "exclude each other"),
        ("[[light]]\ndirection = [0, 0, 1]\nradius = 1", ":19:10", "light 0 radius", "no radius"),
        ("[[light]]\nsphere = 1\nradius = 1", ":19:10", "light 0 radius", "no radius"),
        ("[[light]]\nradius = 1", ":17:1", "light 0 direction", "position ="),
        ("[[light]]\nposition = [0, 9, 0]\nradius = 0", ":19:10", "light 0 radius", "positive"),
        ("[[light]]\nposition = [0, nan, 0]\nradius = 1", ":18:16", "light 0 position", "finite"),
        ("[[light]]\nposition = [0, 9, 0]\nradius = inf", ":19:10", "light 0 radius", "finite"),
        ("[[light]]\nposition = [0, 9, 0]\nradius = nan", ":19:10", "light 0 radius", "finite"),
        ("[[light]]\nposition = [0, 9, 0]\nradius = '1'", ":19:10", "light 0 radius", "expected a number"),
        ("[[light]]\nsphere = 2", ":18:10", "light 0 sphere", "there is no sphere 2"),
        ("[[light]]\nsphere = -1", ":18:10", "light 0 sphere", "there is no sphere -1"),
        ("[[light]]\nsphere = 4294967296", ":18:10", "light 0 sphere", "there is no sphere 4294967296"),
        ("[[light]]\nsphere = 1.0", ":18:10", "light 0 sphere", "sphere = 0"),
        ("[[light]]\nsphere = 1\n[[light]]\nsphere = 7", ":20:10", "light 1 sphere", "from 0"),
        ("[[light]]\nsphere = 1\ncolor = [1, -1, 1]", ":19:9", "light 0 color", "0 or more"),
        ("[[light]]\nsphere = 1\nintensity = -1", ":19:13", "light 0 intensity", "0 or more"),
        ("[[light]]\nsphere = 1\nintensity = 1e300", ":19:13", "light 0 intensity", "finite"),
        ("[[light]]\nsphere = 1\npower = 2", ":19:1", "light 0 power", "intensity"),
        ("[light]\nsphere = 1", ":17:1", "light", "expected an array"),
        ("[[occlusion]]\nrays = 1", ":17:1", "occlusion", "expected a table"),
        ("[occlusion]\nrays = 0", ":18:8", "occlusion.rays", "between 1 and"),
        ("[occlusion]\nrays = 5000000000", ":18:8", "occlusion.rays", "5000000000 rays"),
        ("[occlusion]\nrays = 16.0", ":18:8", "occlusion.rays", "rays = 16"),
        ("[occlusion]\nreach = 0", ":18:9", "occlusion.reach", "positive"),
        ("[occlusion]\nreach = inf", ":18:9", "occlusion.reach", "reach = 5.0"),
        ("[occlusion]\ndepth = 1", ":18:1", "occlusion.depth", "rays, reach"),
    ];
    assert_lines_refused(&cases);
}

/// Adds lines to [`TOML`]: each is refused at its place and field, with a part of the message.
fn assert_lines_refused(cases: &[(&str, &str, &str, &str)]) {
    for (lines, place, field, part) in cases {
        let content = format!("{TOML}{lines}\n");
        let error = read("s.toml", &content).expect_err(lines).to_string();
        assert!(error.contains(part), "{error}");
        assert_refused(read("s.toml", &content), &format!("s.toml{place}"), field, &content);
    }
}

#[test]
fn a_broken_material_is_refused_at_its_place() {
    // (lines after the last [[sphere]], place, field, a part of the message)
    let cases = [
        (
            "material = 'wood'",
            ":17:12",
            "sphere 1 material",
            "\"phong\", \"matte\", \"plastic\", \"metal\" or \"glass\"",
        ),
        ("material = 1", ":17:12", "sphere 1 material", "material = \"metal\""),
        ("material = 'metal'\nindex = 1.5", ":18:9", "sphere 1 index", "the keys of metal are fuzz"),
        ("material = 'metal'\ndiffuse = 1", ":18:11", "sphere 1 diffuse", "remove it"),
        ("material = 'glass'\nfuzz = 0", ":18:8", "sphere 1 fuzz", "the keys of glass are index"),
        ("fuzz = 0", ":17:8", "sphere 1 fuzz", "change the material"),
        ("material = 'metal'\nfuzz = 1.5", ":18:8", "sphere 1 fuzz", "from 0 to 1"),
        ("material = 'metal'\nfuzz = true", ":18:8", "sphere 1 fuzz", "fuzz = 0.1"),
        ("material = 'glass'\nindex = 0", ":18:9", "sphere 1 index", "from 0.1 to 10"),
        ("diffuse = -1", ":17:11", "sphere 1 diffuse", "from 0 to 1"),
        ("specular = 1.5", ":17:12", "sphere 1 specular", "from 0 to 1"),
        ("shine = 1e300", ":17:9", "sphere 1 shine", "found inf"),
        ("transmission = inf", ":17:16", "sphere 1 transmission", "transmission = 0.5"),
        ("transmission = 1\nindex = 100", ":18:9", "sphere 1 index", "from 0.1 to 10"),
        ("metal = 1", ":17:1", "sphere 1 metal", "material, diffuse"),
    ];
    assert_lines_refused(&cases);
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
        (npy_of("<c8", "False", "(1, 4)", one), "dtype"),
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
    assert!(begun.elapsed() < Duration::from_secs(5), "a header of 2^60 rows takes no time");
}

/// Files of spheres, which a scene names; tests/corpus.rs damages files of all formats by themselves.
#[test]
fn a_damaged_file_of_spheres_is_read_or_refused() {
    let npy = npy_of("<f8", "False", "(2, 4)", &little(&[0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0]));
    let mut rng = Rng::new(0x9e37_79b9_7f4a_7c15);
    for (name, good) in [("a.csv", CSV.as_bytes()), ("a.npy", &npy)] {
        let folder = folder(&[("scene.toml", format!("{CAMERA}[[spheres]]\nfile = '{name}'\n").as_bytes())]);
        let mut refused = 0;
        for round in 0..2000 {
            let mut bytes = good.to_vec();
            (0..=rng.below(3)).for_each(|_| damage(&mut bytes, good, &mut rng));
            std::fs::write(folder.path().join(name), &bytes).expect("a temporary file");
            match halfline_files::read::scene(&folder.path().join("scene.toml"), &ReadOptions::default()) {
                Ok(frame) => frame.scene.check().unwrap_or_else(|e| panic!("{name} {round}: read, but {e}: {bytes:?}")),
                Err(Error::Scene { .. } | Error::Io { .. }) => refused += 1,
                Err(other) => panic!("{name} {round}: {other}: {bytes:?}"),
            }
        }
        assert!((200..2000).contains(&refused), "{name}: {refused} of 2000 refused");
    }
}

/// A line that repeats after a beginning; an error where it is read further than any reader needs to know that there is nothing.
struct Idle {
    bytes: Cursor<Vec<u8>>,
    line: &'static str,
    left: u32,
}

impl Read for Idle {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        if self.bytes.position() == self.bytes.get_ref().len() as u64 {
            self.left = self.left.checked_sub(1).ok_or_else(|| std::io::Error::other("it is read on and on"))?;
            self.bytes = Cursor::new(self.line.repeat(1 << 16).into_bytes());
        }
        self.bytes.read(to)
    }
}

/// A stream without content ends, whatever format it is said to have: after 2^20 lines, and what a reader has ahead.
#[test]
fn lines_without_content_are_not_read_for_long() {
    let formats = [Format::CSV, Format::XYZ, Format::PDB, Format::CIF, Format::GRO, Format::NFF, Format::DUMP];
    for (format, head) in formats.into_iter().map(|format| (format, "")).chain([
        (Format::CSV, "x,y,z\n0,0,0\n"),
        (Format::PDB, "REMARK\n"),
        (Format::PQR, "HEADER\n"),
        (Format::XYZ, "1\n\nC 0 0 0\n"),
        (Format::CIF, "data_x\nloop_\n"),
        (Format::DATA, "title\n\n1 atoms\n"),
        (Format::PCD, "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 9\nDATA ascii\n"),
        (Format::PTS, "2\n1 2 3\n"),
        (Format::PTX, ""),
        (Format::PLY, "ply\nformat ascii 1.0\nelement face 99999999\nelement vertex 1\nproperty float x\nend_header\n"),
    ]) {
        let has_comments = head.is_empty() && [Format::CSV, Format::NFF].contains(&format);
        for line in ["\n", "# \n"].into_iter().take(if has_comments { 2 } else { 1 }) {
            let idle = Idle { bytes: Cursor::new(head.into()), line, left: 3 * 16 };
            let options = ReadOptions {
                particles: ParticleOptions { format: Some(format), ..Default::default() },
                ..ReadOptions::default()
            };
            let read = Sequence::from_reader(idle, Path::new("a"), &options);
            let error = read.and_then(|mut read| read.next_scene()).map(drop).expect_err(head);
            assert!(matches!(error, Error::Limits { .. } | Error::Scene { .. }), "{format:?} {head}: {error}");
        }
    }
}

/// The lines that are counted are those in a row.
#[test]
fn many_blank_lines_between_rows_are_no_fault() {
    let text = "x,y,z,radius\n".to_owned() + &["\n".repeat(1 << 19), "0,0,0,1\n".into()].concat().repeat(3);
    assert_eq!(read("a.csv", text).expect("three rows").spheres.len(), 3);
}
