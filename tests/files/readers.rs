//! The promise of the readers: a scene is read to its exact values, and what is not a sphere is counted.

use crate::data::{self, real_or_skip};
use crate::nff;
use crate::numpy::python_or_skip;
use crate::rng::Rng;
use crate::scenes::{
    CAMERA, CSV, NFF, TOML, assert_refused, folder, little, npy_of, read, read_frame, read_spheres, read_with, strict,
};
use glam::DVec3;
use halfline::camera::{Lens, Look};
use halfline::error::Error;
use halfline::scene::{DEFAULT_COLOR, Light, LightSource, Lighting, Material, Scene, Sky, SkyColors};
use halfline::settings::{FileLook, Look as PictureLook};
use halfline_files::read::SceneFrame;
use halfline_files::read::{Keep, ParticleOptions, ReadOptions, Sequence};
use std::io::{Cursor, Write};
use std::path::Path;
use std::process::{Command, Stdio};

#[test]
fn the_same_scene_in_toml_and_nff_has_its_exact_values() {
    let crlf = |text: &str| text.replace('\n', "\r\n");
    let marked = |text: &str| format!("\u{feff}{text}");
    // Without a known extension the format is recognised by the content.
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
        let found = read_frame(name, content.as_bytes(), &ReadOptions::default());
        let SceneFrame { scene, skipped, .. } = found.unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(scene.camera.eye, DVec3::new(0.0, 0.0, 5.5), "{name}");
        assert_eq!((scene.camera.look, scene.camera.up), (Look::At(DVec3::ZERO), DVec3::Y), "{name}");
        let nff = content.contains("hither");
        let lens = if nff { Lens::RowCentres { degrees: 20.0 } } else { Lens::Vfov { degrees: 20.0, distance: 1.0 } };
        assert_eq!(scene.camera.lens, lens, "{name}");
        let image = scene.image;
        assert_eq!((image.width, image.height, image.background), (120, 67, [0.5, 0.25, 1.0]), "{name}");
        assert_eq!(scene.spheres.centers, [[0.0, 1.0, -1e-3], [0.1, 16.0, 9007199254740992.0]], "{name}");
        assert_eq!(scene.spheres.radii, [1.0, 2.5], "{name}");
        assert_eq!(scene.spheres.colors, Some(vec![DEFAULT_COLOR, [1.0, 0.5, 0.0]].into()), "{name}");
        let kinds = [("polygon", 1), ("cone", 2), ("polygonal patch", 1)];
        assert_eq!(skipped.kinds, if nff { kinds.to_vec() } else { Vec::new() }, "{name}");
        scene.check().expect("a scene that can be rendered");
    }
}

#[test]
fn a_camera_has_its_defaults_and_its_other_keys() {
    let scene = read("s.toml", CAMERA).expect("a scene without spheres");
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
        assert_eq!(spheres.colors, Some(rows.map(|r| [r[4], r[5], r[6]].map(|c| c as f32)).to_vec().into()), "{index}");
    }
    let empty = [("a.csv", b"x,y,z,radius\n".to_vec()), ("a.npy", npy_of("<f8", "True", "(0, 4)", b""))];
    for (name, content) in empty {
        assert!(read_spheres(name, &content).expect("no rows").spheres.is_empty());
    }
}

#[test]
fn ids_begin_with_inline_spheres_and_files_are_found_next_to_the_scene() {
    let scene = format!(
        "{CAMERA}[[spheres]]\nfile = 'a.csv'\n[[sphere]]\ncenter = [9, 9, 9]\nradius = 9\n[[spheres]]\nfile = \"b.npy\"\n"
    );
    let b = npy_of("<f8", "False", "(1, 4)", &little(&[3.0, 3.0, 3.0, 3.0]));
    let folder = folder(&[("s.toml", scene.as_bytes()), ("a.csv", b"x,y,z,radius\n1,1,1,1\n2,2,2,2"), ("b.npy", &b)]);
    let path = folder.path().join("s.toml");
    let scene = halfline_files::read::scene(&path, &strict()).expect("three kinds of spheres").scene;
    assert_eq!(scene.spheres.radii, [9.0, 1.0, 2.0, 3.0]);
    assert_eq!(scene.spheres.colors, None);
    std::fs::remove_file(folder.path().join("b.npy")).expect("removed");
    match halfline_files::read::scene(&path, &ReadOptions::default()) {
        Err(Error::Io { path, .. }) => assert_eq!(path, folder.path().join("b.npy")),
        other => panic!("a missing file is an Io error: {other:?}"),
    }
}

#[test]
fn a_file_of_spheres_alone_is_framed() {
    let npy = npy_of("<f8", "False", "(2, 4)", &little(&[0.0, 1.0, -1e-3, 1.0, 0.1, 2.0, 3.0, 2.5]));
    for (name, content) in [("s.csv", CSV.as_bytes()), ("s", CSV.as_bytes()), ("s.npy", &npy), ("s", &npy)] {
        let found = read_frame(name, content, &ReadOptions::default());
        let SceneFrame { scene, skipped, .. } = found.unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(scene.spheres.centers, [[0.0, 1.0, -1e-3], [0.1, 2.0, 3.0]], "{name}");
        assert_eq!(scene.spheres.radii, [1.0, 2.5], "{name}");
        scene.check().expect("a scene that can be rendered");
        assert!(skipped.warnings().is_empty(), "{skipped:?}");
    }
}

#[test]
fn an_unreadable_file_is_an_io_error() {
    let folder = folder(&[]);
    for name in ["missing.toml", "missing.nff", "missing", "."] {
        let path = folder.path().join(name);
        match halfline_files::read::scene(&path, &ReadOptions::default()) {
            Err(Error::Io { path: named, action: "read", .. }) => assert_eq!(named, path),
            other => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn lights_of_a_scene_file_have_their_exact_values() {
    let lines = "[[light]]
direction = [-1, 2.5, 1e-3]
[[light]]
position = [4, 3, 2]
color = [1, 0.5, 0]
intensity = 2
[[light]]
position = [4, 3, 2]
radius = 0.5
[[light]]
sphere = 3
[occlusion]
reach = 2.5
";
    let folder = folder(&[("a.csv", CSV.as_bytes())]);
    let path = folder.path().join("s.toml");
    // The spheres that a light may name include the spheres of files, wherever the tables are.
    std::fs::write(&path, format!("{TOML}{lines}[[spheres]]\nfile = 'a.csv'\n")).expect("written");
    let Lighting { lights, shadows, sky, .. } =
        halfline_files::read::scene(&path, &ReadOptions::default()).expect("a scene").scene.lighting;
    let place = DVec3::new(4.0, 3.0, 2.0);
    let expected = [
        Light::white(LightSource::Direction(DVec3::new(-1.0, 2.5, 1e-3))),
        Light { color: [1.0, 0.5, 0.0], intensity: 2.0, ..Light::white(LightSource::Point(place)) },
        Light::white(LightSource::Ball { center: place, radius: 0.5 }),
        Light::white(LightSource::Sphere(3)),
    ];
    assert_eq!(lights, expected);
    assert!(shadows, "the lights of a file cast shadows");
    assert_eq!(sky, Some(Sky { rays: 16, reach: 2.5, ..Sky::default() }));
    assert_eq!(read("s.toml", TOML).expect("a scene").lighting, Lighting::default());
    let sky = read("s.toml", TOML.to_owned() + "[occlusion]\nrays = 0x40\n").expect("a sky").lighting;
    assert_eq!(sky, Lighting { sky: Some(Sky { rays: 64, ..Sky::default() }), ..Lighting::default() });
}

#[test]
fn the_colours_of_a_sky_and_the_look_of_a_scene_file_have_their_values() {
    let first = |lines: &str, image: &str| {
        let text = TOML.replace("[image]\n", &format!("[image]\n{image}")) + lines;
        let mut sequence = Sequence::from_reader(Cursor::new(text), Path::new("s.toml"), &ReadOptions::default())?;
        Ok::<_, halfline::Error>(sequence.next_scene()?.expect("a scene"))
    };
    let sky = "[sky]\nzenith = [0.25, 0.5, 1]\nhorizon = 'white'\n";
    let frame = first(sky, "samples = 9\nlook = 'soft'\n").expect("a sky");
    assert_eq!(frame.look, FileLook { is_particles: false, look: Some(PictureLook::Soft), samples: Some(9) });
    let colors = SkyColors { zenith: [0.25, 0.5, 1.0], horizon: [1.0; 3], is_shown: false };
    // The file has a background, which is seen.
    assert_eq!(frame.scene.lighting.sky, Some(Sky { colors: Some(colors), ..Sky::AT_CENTERS }));
    let text = TOML.lines().filter(|line| !line.starts_with("background")).map(|line| format!("{line}\n"));
    let scene = read("s.toml", text.collect::<String>() + sky + "[occlusion]\nrays = 5\n").expect("a sky");
    let shown = SkyColors { is_shown: true, ..colors };
    assert_eq!(scene.lighting.sky, Some(Sky { rays: 5, colors: Some(shown), ..Sky::default() }));
    assert_eq!(scene.image.background, [1.0; 3], "the colour of the horizon, where the sky's colours are not seen");
    let plain = first("", "").expect("a scene");
    assert_eq!((plain.look, plain.scene.lighting), (FileLook::default(), Lighting::default()));
    for (lines, image, words) in [
        ("[sky]\nzenith = [1, 1, 1]\n", "", &["sky.horizon", "missing", "horizon = "][..]),
        ("[sky]\nzenith = [1, 1, 1]\nhorizon = [1, -1, 1]\n", "", &["sky.horizon", "-1"]),
        ("[sky]\nzenith = 'blu'\nhorizon = [1, 1, 1]\n", "", &["sky.zenith", "blue"]),
        ("[sky]\nzenith = [1, 1, 1]\nhorizon = [1, 1, 1]\nground = [0, 0, 0]\n", "", &["sky.ground", "unknown key"]),
        ("[sky]\nzenith = [1, 1, 1]\nzenith = [1, 1, 1]\n", "", &["duplicate key"]),
        ("", "samples = 0\n", &["image.samples", "between 1 and"]),
        ("", "samples = 2.5\n", &["image.samples", "whole number"]),
        ("", "look = 'nice'\n", &["image.look", "nice", "plain, soft, figure"]),
        ("", "look = 3\n", &["image.look", "a string"]),
    ] {
        let error = first(lines, image).expect_err("a wrong value").to_string();
        assert!(words.iter().all(|word| error.contains(word)) && error.contains("s.toml:"), "{error}");
    }
}

#[test]
fn lights_of_an_nff_file_share_their_intensity_unless_they_have_a_colour() {
    let scene = read("s.nff", NFF).expect("a scene").lighting;
    let point = Light::white(LightSource::Point(DVec3::new(4.0, 3.0, 2.0)));
    assert_eq!(scene.lights, [Light { intensity: 0.5f32.sqrt(), ..point }, point], "in the order of the file");
    assert!(scene.shadows && scene.sky.is_none());
    let one = read("s.nff", NFF.replace("l 4 3 2 1 1 1\n", "")).expect("a scene").lighting;
    assert_eq!(one.lights, [point]);
    let colored = read("s.nff", NFF.replace("2 1 1 1", "2 0.5 0 1")).expect("a scene").lighting;
    assert_eq!(colored.lights[1], Light { color: [0.5, 0.0, 1.0], ..point });
    let none = NFF.replace("l 4 3 2 1 1 1\n", "").replace("l 4 3 2\n", "");
    assert_eq!(read("s.nff", none).expect("a scene").lighting, Lighting::default());
}

#[test]
fn materials_of_a_scene_file_have_their_exact_values() {
    let plain = read("s.toml", TOML.to_owned() + "material = 'phong'\ndiffuse = 1\n").expect("a scene").spheres;
    assert_eq!(plain.materials, None, "plain spheres have no list");
    for (lines, material) in [
        ("material = 'metal'", Material::Metal { fuzz: 0.0 }),
        ("fuzz = 0.25\nmaterial = 'metal'", Material::Metal { fuzz: 0.25 }),
        ("material = 'glass'", Material::Glass { index: 1.5 }),
        ("material = 'glass'\nindex = 1.33", Material::Glass { index: 1.33 }),
        ("specular = 0.5", phong([1.0, 0.5, 0.0, 0.0], 1.0)),
        ("material = 'phong'\nshine = 30", phong([1.0, 0.0, 30.0, 0.0], 1.0)),
        ("diffuse = 0\nspecular = 1\nshine = 3\ntransmission = 0.5\nindex = 2", phong([0.0, 1.0, 3.0, 0.5], 2.0)),
    ] {
        let spheres = read("s.toml", format!("{TOML}{lines}\n")).expect(lines).spheres;
        let materials = spheres.materials.expect("a list");
        assert_eq!((materials.of(0), materials.of(1)), (Material::default(), material), "{lines}");
    }
}

fn phong([diffuse, specular, shine, transmission]: [f32; 4], index: f64) -> Material {
    Material::Phong { diffuse, specular, shine, transmission, index }
}

#[test]
fn materials_of_an_nff_file_are_those_of_the_fill_before() {
    let scene =
        |lines: &str| format!("v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 20\nresolution 9 9\n{lines}\ns 0 0 0 1\n");
    let (left_out, limited) = ("Kd of 1 material is left out", "1 material out of range");
    for (lines, material, warnings) in [
        ("f 1 0.5 0", phong([1.0, 0.0, 0.0, 0.0], 1.0), vec![]),
        ("f 1 0.5 0 1 0 30 0 1.5", phong([1.0, 0.0, 30.0, 0.0], 1.0), vec![]),
        ("f 1 0.5 0 0.8 0 100000 0 0", phong([0.8, 0.0, 1e5, 0.0], 1.0), vec![left_out]),
        ("l 0 0 0\nf 1 0.5 0 0.8 0 100000 0 0", phong([0.8, 0.0, 1e5, 0.0], 1.0), vec![]),
        ("f 1 0.5 0 0.8", phong([0.8, 0.0, 0.0, 0.0], 1.0), vec![left_out]),
        ("f 1 0.5 0 0.8 0.5", phong([0.8, 0.5, 0.0, 0.0], 1.0), vec![]),
        ("f 1 0.5 0 0.8 0 9 0.5 1.5", phong([0.8, 0.0, 9.0, 0.5], 1.5), vec![]),
        ("f 1 1 1 0 0 0 1 9\nf 1 0.5 0 0 1 3 0 0", phong([0.0, 1.0, 3.0, 0.0], 1.0), vec![]),
        ("f 1 0.5 0 2 0 0 0 1", phong([1.0, 0.0, 0.0, 0.0], 1.0), vec![limited]),
        ("f 1 0.5 0 -1 7 -3 2 0", phong([0.0, 1.0, 0.0, 1.0], 0.1), vec![limited]),
        ("f 1 0.5 0 1 0 1e300 0 1", phong([1.0, 0.0, f32::MAX, 0.0], 1.0), vec![limited]),
    ] {
        let SceneFrame { scene: Scene { spheres, .. }, skipped, .. } =
            read_frame("s.nff", scene(lines).as_bytes(), &ReadOptions::default()).expect("lenient");
        assert_eq!(spheres.materials.map_or(Material::default(), |materials| materials.of(0)), material, "{lines}");
        assert_eq!(spheres.colors, Some(vec![[1.0, 0.5, 0.0]].into()));
        assert_eq!(skipped.total(), 0, "materials are not counted as shapes");
        let starts = |(found, start): (&String, &&str)| found.starts_with(start);
        let found = skipped.warnings();
        assert!(found.len() == warnings.len() && found.iter().zip(&warnings).all(starts), "{lines}: {found:?}");
        match (read_with("s.nff", scene(lines).as_bytes(), &strict()), warnings.contains(&limited)) {
            (Ok(_), false) => {}
            (Err(error), true) => assert!(error.to_string().contains("s.nff:7:1: fill: "), "{error}"),
            (found, _) => panic!("{lines}: {found:?}"),
        }
    }
}

#[test]
fn strict_reading_refuses_what_is_otherwise_counted() {
    for (line, place, kind) in [("p 3\n0 0 0 1 0 0 0 1 0", ":9:1", "polygon"), ("c 0 0 0 1 0 0 1 1", ":9:1", "cone")] {
        let scene = format!("v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 20\nresolution 9 9\ns 0 0 0 1\n\n{line}\n");
        let lenient = read_frame("s.nff", scene.as_bytes(), &ReadOptions::default()).expect("lenient");
        assert_eq!(lenient.skipped.kinds, [(kind, 1)]);
        let error = read_with("s.nff", scene.as_bytes(), &strict()).expect_err("strict").to_string();
        assert!(error.contains(&format!("s.nff{place}: {kind}: ")), "{error}");
    }
    read_with("s.toml", TOML.as_bytes(), &strict()).expect("nothing to skip");
}

#[test]
fn a_scene_is_read_from_standard_input() {
    const CHILD: &str = "HALFLINE_TEST_STDIN";
    if let Ok(spheres) = std::env::var(CHILD) {
        let scene =
            halfline_files::read::scene(Path::new("-"), &ReadOptions::default()).expect("the parent's scene").scene;
        assert_eq!(scene.spheres.len().to_string(), spheres);
        return;
    }
    let folder = folder(&[("a.csv", CSV.as_bytes())]);
    let with_file = TOML.to_owned() + "[[spheres]]\nfile = 'a.csv'\n";
    for (content, spheres) in [(TOML, "2"), (NFF, "2"), (&with_file, "4")] {
        let mut child = Command::new(std::env::current_exe().expect("this test"))
            .args(["--exact", "readers::a_scene_is_read_from_standard_input"])
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

/// Generated scenes of the Standard Procedural Databases.
#[test]
fn scenes_of_the_databases_have_their_spheres() {
    for (name, text) in nff::all() {
        let (spheres, kind, size) = match name {
            "balls_s2.nff" => (91, "polygon", 512),
            "balls_s4.nff" => (7381, "polygon", 512),
            "shells.nff" => (5761, "", 512),
            _ => (6, "cone", 256),
        };
        let found = read_frame(name, text.as_bytes(), &ReadOptions::default());
        let SceneFrame { scene, skipped, .. } = found.unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scene.spheres.len(), spheres, "{name}");
        assert_eq!((scene.image.width, scene.image.height), (size, size), "{name}");
        let count = |prefix: &str| text.lines().filter(|line| line.starts_with(prefix)).count() as u64;
        assert_eq!(count("s "), spheres as u64, "{name}");
        assert_eq!(skipped.total(), count("c ") + count("p ") + count("pp "), "{name}");
        assert!(skipped.kinds.iter().all(|(k, _)| *k == kind), "{name} {skipped:?}");
        assert_eq!(scene.lighting.lights.len() as u64, count("l "), "{name}");
        let strictly = read_with(name, text.as_bytes(), &strict());
        assert_eq!(strictly.is_ok(), kind.is_empty(), "{name}");
        // All spheres have the last fill, which reflects; nothing of it is left out.
        let fill = text.lines().rfind(|line| line.starts_with("f ")).expect("a fill");
        let numbers: Vec<f64> = fill.split(' ').skip(4).map(|x| x.parse().expect("a number")).collect();
        let material = phong([numbers[0], numbers[1], numbers[2], numbers[3]].map(|x| x as f32), 1.0);
        let materials = scene.spheres.materials.as_ref().expect("they reflect");
        assert!(material.bounces() && (0..spheres as u32).all(|id| materials.of(id) == material), "{name}");
        assert_eq!(skipped.warnings().len(), skipped.kinds.len(), "{name}: {skipped:?}");
        scene.check().expect("a scene that can be rendered");
    }
}

/// The hash of a scene's lights, centres and radii in the six digits of the databases' files. Numbers below 1e-13 count
/// as 0, because sums that vanish are rounded to about 1e-16 there.
fn fingerprint(scene: &Scene) -> String {
    let digits = |x: f64| format!("{:.5e} ", if x.abs() < 1e-13 { 0.0 } else { x });
    let lights = scene.lighting.lights.iter().map(|light| match light.source {
        LightSource::Point(position) => position,
        other => panic!("{other:?}"),
    });
    let places = scene.spheres.centers.iter().zip(scene.spheres.radii.iter());
    let mut text: String = lights.flat_map(|place| place.to_array()).map(digits).collect();
    text.extend(places.flat_map(|(center, radius)| [center[0], center[1], center[2], *radius]).map(digits));
    blake3::hash(text.as_bytes()).to_hex()[..16].to_owned()
}

/// The generated scenes equal the real ones within the six digits of their files. This test knows the fingerprints of the files;
/// files that are here must have them.
#[test]
fn the_databases_real_files_hold_the_same_scenes() {
    const FINGERPRINTS: [(&str, &str); 4] = [
        ("balls_s2.nff", "404197af613dbe73"),
        ("balls_s4.nff", "3cd9ffe9b73aa550"),
        ("shells.nff", "9a5462852121f19a"),
        ("jacks.nff", "2a05e3d57ba19dff"),
    ];
    for ((name, text), (known, expected)) in nff::all().into_iter().zip(FINGERPRINTS) {
        let found = read_frame(name, text.as_bytes(), &ReadOptions::default()).expect("a scene");
        let scene = &found.scene;
        let real = data::everywhere(name)
            .map(|path| halfline_files::read::scene(&path, &ReadOptions::default()).expect("a scene"));
        for SceneFrame { scene: real, skipped, .. } in real {
            assert_eq!((name, &*fingerprint(&real)), (known, expected), "the real file");
            assert_eq!((scene.camera, scene.image, &found.skipped), (real.camera, real.image, &skipped), "{name}");
            assert_eq!(scene.spheres.colors, real.spheres.colors, "{name}");
        }
        assert_eq!((name, &*fingerprint(scene)), (known, expected));
    }
}

#[test]
fn the_planets_of_the_ephemeris_have_their_exact_values() {
    real_or_skip(&["solar_system.csv"]);
    let mut all = Vec::new();
    for path in data::everywhere("solar_system.csv") {
        let csv = std::fs::read(&path).expect("the planets");
        assert_refused(read_spheres("a.csv", &csv), "a.csv:1:1", "header", "its columns have other names");
        let planets =
            halfline_files::read::scene(&path, &ReadOptions::default()).expect("the Sun and its planets").scene;
        assert_eq!((planets.spheres.len(), planets.spheres.radii[0]), (11, 695700.0));
        assert_eq!(planets.spheres.centers[3], [76580651.925311, 114940047.833629, 49846795.759752], "the Earth");
        all.push(planets.spheres);
    }
    // Tables of the same ephemeris by different programs differ in the last of their six decimals: the sum of a polynomial is
    // rounded in the sixth for the planets from Saturn on.
    for (one, other) in all.iter().zip(all.iter().skip(1)) {
        let apart = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).any(|n| (a[n] - b[n]).abs() > 1.5e-6);
        assert!(one.radii == other.radii && !one.centers.iter().zip(other.centers.iter()).any(apart));
    }
}

/// Levels of 8 bits, as three points have them.
const LEVELS: [[u8; 3]; 3] = [[200, 0, 7], [0, 255, 1], [3, 9, 250]];

/// A file whose colours are these levels times `scale`: its name, its content, and whether it has a column `red`.
type ColoredFile = (&'static str, Vec<u8>, bool);

/// The points (n, 0, 0) of radius 2 in every format whose fields have names, with colours as `names` of this type of NumPy.
fn colored(descr: &str, scale: f64, names: [&str; 3]) -> Vec<ColoredFile> {
    let number = |level: f64| -> Vec<u8> {
        match descr {
            "|u1" => vec![level as u8],
            "<u2" => (level as u16).to_le_bytes().to_vec(),
            "<i4" => (level as i32).to_le_bytes().to_vec(),
            "<f4" => (level as f32).to_le_bytes().to_vec(),
            _ => level.to_le_bytes().to_vec(),
        }
    };
    let (letter, size) = (&descr[1..2], &descr[2..]);
    let scaled = |n: usize| LEVELS[n].map(|level| f64::from(level) * scale);
    let bytes = |n: usize| scaled(n).into_iter().flat_map(number).collect::<Vec<u8>>();
    let shown = |n: usize| scaled(n).map(|level| level.to_string());
    let has_red = names[0].eq_ignore_ascii_case("red");
    let rows = |row: &dyn Fn(usize) -> String| (0..3).map(row).collect::<String>().into_bytes();
    let records = |row: &dyn Fn(usize) -> Vec<u8>| (0..3).flat_map(row).collect::<Vec<u8>>();
    let xyz = |n: usize| [n as f32, 0.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let archive = |members: &[(&str, Vec<u8>)]| {
        let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
        let stored = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
        for (name, content) in members {
            zip.start_file(format!("{name}.npy"), stored).expect("in memory");
            zip.write_all(content).expect("in memory");
        }
        zip.finish().expect("in memory").into_inner()
    };
    let array = |shape: &str, data: &[u8]| npy_of(descr, "False", shape, data);
    let [r, g, b] = names;
    let positions = npy_of("<f8", "False", "(3, 3)", &little(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0]));
    let radii = npy_of("<i2", "False", "(3,)", &[4, 0, 4, 0, 4, 0]);
    let channel = |k: usize| array("(3,)", &records(&|n| number(scaled(n)[k])));
    let full_record = |n: usize| [xyz(n), bytes(n), 2i16.to_le_bytes().to_vec()].concat();
    let pcd = format!(
        "VERSION 0.7\nFIELDS x y z {r} {g} {b} radius\nSIZE 4 4 4 {size} {size} {size} 2\nTYPE F F F {0} {0} {0} I\nWIDTH 3\n",
        letter.to_uppercase()
    );
    let kind = match descr {
        "|u1" => "uchar",
        "<u2" => "ushort",
        "<i4" => "int",
        "<f4" => "float",
        _ => "double",
    };
    let axes = ["x", "y", "z"].map(|axis| format!("property float {axis}\n")).concat();
    let colors = names.map(|name| format!("property {kind} {name}\n")).concat();
    let ply = |format: &str| {
        format!("ply\nformat {format} 1.0\nelement vertex 3\n{axes}{colors}property short radius\nend_header\n")
            .into_bytes()
    };
    let line = |n: usize| format!("{n} 0 0 {} 2\n", shown(n).join(" "));
    let fields = |colors: String| {
        let descr = format!("[('x', '<f4'), ('y', '<f4'), ('z', '<f4'), {colors}, ('radius', '<i2')]");
        crate::numpy::npy(
            &format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (3,), }}"),
            &records(&full_record),
        )
    };
    let dump =
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS x y z";
    let mut files: Vec<ColoredFile> = vec![
        ("a.npy", fields(names.map(|name| format!("('{name}', '{descr}')")).join(", ")), has_red),
        ("a.npy", fields(format!("('rgb', '{descr}', (3,))")), false),
        (
            "a.npz",
            archive(&[
                ("pos", positions.clone()),
                ("diameters", radii.clone()),
                (r, channel(0)),
                (g, channel(1)),
                (b, channel(2)),
            ]),
            has_red,
        ),
        (
            "a.npz",
            archive(&[
                ("colors", array("(3, 3)", &records(&bytes))),
                ("pos", positions.clone()),
                ("diameter", radii.clone()),
            ]),
            false,
        ),
        (
            "a.npz",
            archive(&[
                ("colour", array("(3, 4)", &records(&|n| [bytes(n), number(9.0)].concat()))),
                ("pos", positions),
                ("diameter", radii),
            ]),
            false,
        ),
        (
            "a.pcd",
            [pcd.clone() + "DATA binary\n"].concat().into_bytes().into_iter().chain(records(&full_record)).collect(),
            has_red,
        ),
        ("a.pcd", [(pcd + "DATA ascii\n").into_bytes(), rows(&line)].concat(), has_red),
        ("a.ply", [ply("ascii"), rows(&line)].concat(), has_red),
        ("a.ply", [ply("binary_little_endian"), records(&full_record)].concat(), has_red),
    ];
    // Numbers in text have no type.
    if letter == "f" || scale > 1.0 || descr == "|u1" {
        let row = |n: usize| format!("C {n} 0 0 {} 2\n", shown(n).join(" "));
        for property in ["color:R:3", "rgb:I:3", &names.map(|name| format!("{name}:R:1")).join(":")] {
            let head = format!("3\nProperties=species:S:1:pos:R:3:{property}:radius:I:1\n");
            files.push(("a.xyz", [head.into_bytes(), rows(&row)].concat(), has_red && property.contains("red:")));
        }
        files.push(("a.dump", [format!("{dump} {r} {g} {b} radius\n").into_bytes(), rows(&line)].concat(), has_red));
        files.push(("a.csv", [format!("x y z {r} {g} {b} radius\n").into_bytes(), rows(&line)].concat(), has_red));
    }
    files
}

/// docs/reading.md: one rule for the names and the numbers of colours and radii.
#[test]
fn colours_and_radii_have_one_rule_in_all_formats() {
    let sets = [["red", "green", "blue"], ["R", "G", "B"], ["diffuse_red", "Diffuse_Green", "diffuse_blue"]];
    let options =
        ReadOptions { particles: ParticleOptions { keep: Keep::All, ..Default::default() }, ..ReadOptions::default() };
    let expected = LEVELS.map(halfline::frame::srgb::linear);
    for names in sets {
        for (descr, scale) in [("|u1", 1.0), ("<u2", 1.0), ("<u2", 257.0), ("<i4", 257.0), ("<f4", 1.0), ("<f8", 257.0)]
        {
            for (n, (name, content, has_red)) in colored(descr, scale, names).into_iter().enumerate() {
                let what = format!("{n} {name} {descr} {scale} {names:?}");
                let frame = read_frame(name, &content, &options).unwrap_or_else(|e| panic!("{what}: {e}"));
                let spheres = &frame.scene.spheres;
                assert_eq!((spheres.centers[2], spheres.radii[2]), ([2.0, 0.0, 0.0], 2.0), "{what}");
                let colors = spheres.colors.as_ref().unwrap_or_else(|| panic!("{what}: no colours"));
                let near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-6;
                assert!(colors.iter().flatten().zip(expected.iter().flatten()).all(near), "{what}: {colors:?}");
                // Tables and arrays of a scene file are linear RGB.
                if !name.ends_with("csv") && !name.ends_with("npy") {
                    let scene = format!("{CAMERA}[[spheres]]\nfile = '{name}'\n");
                    let folder = folder(&[("s.toml", scene.as_bytes()), (name, &content)]);
                    let frame = halfline_files::read::scene(&folder.path().join("s.toml"), &ReadOptions::default());
                    assert_eq!(frame.expect(&what).scene.spheres.colors.as_ref(), Some(colors), "{what}: in a scene");
                }
                if has_red {
                    let selection = format!("red {}", 200.0 * scale).parse().expect("a selection");
                    let (mask, _) = frame.selected(&selection).expect(&what);
                    assert_eq!(mask, [true, false, false], "{what}: red is as in the file");
                }
            }
        }
    }
}

/// A name that is known and not taken is told; a colour of floats that are linear stays so.
#[test]
fn what_is_called_like_a_colour_or_a_radius_and_is_none_is_reported() {
    let numbers = little(&[0.0; 3]);
    let fields = |more: &str, bytes: &[u8]| {
        let descr = format!("[('x', '<f8'), ('y', '<f8'), ('z', '<f8'), {more}]");
        let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (1,), }}");
        crate::numpy::npy(&header, &[&numbers[..], bytes].concat())
    };
    let xyz = "1\nProperties=species:S:1:pos:R:3";
    for (name, content, message) in [
        ("a.npy", fields("('red', '|S1'), ('green', '|S1'), ('blue', '|S1')", b"abc"), "red"),
        ("a.npy", fields("('radius', '<c8')", &[0; 8]), "radius"),
        ("a.npy", fields("('rgb', '<f8')", &[0; 8]), "rgb"),
        ("a.npy", fields("('red', '|u1'), ('green', '|u1')", &[1, 2]), "`red`, `green`"),
        ("a.csv", b"x,y,z,color\n0,0,0,red\n".to_vec(), "color"),
        ("a.csv", b"x,y,z,rgb\n0,0,0,255\n".to_vec(), "rgb"),
        ("a.xyz", format!("{xyz}:color:S:1\nC 0 0 0 red\n").into_bytes(), "color"),
        ("a.xyz", format!("{xyz}:radius:R:3\nC 0 0 0 1 2 3\n").into_bytes(), "radius"),
        (
            "a.ply",
            b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
              property list uchar uchar rgb\nend_header\n0 0 0 3 1 2 3\n"
                .to_vec(),
            "rgb",
        ),
    ] {
        let frame =
            read_frame(name, &content, &ReadOptions::default()).unwrap_or_else(|e| panic!("{name} {message}: {e}"));
        let warnings = frame
            .skipped
            .warnings()
            .into_iter()
            .filter(|warning| warning.contains("not taken") && warning.contains(message));
        assert_eq!(warnings.count(), 1, "{name} {message}: {:?}", frame.skipped.warnings());
    }
}

/// A point of a scan: coordinates, an intensity and a colour.
fn scanned(rng: &mut Rng) -> String {
    let [x, y, z] = rng.cube().map(|t| 1e5 * t);
    let [r, g, b] = [(); 3].map(|()| rng.below(256));
    format!("{x} {y:.3} {z:e} {} {r} {g} {b}\n", rng.unit())
}

/// NumPy reads the same numbers, and computes the places in the same order.
#[test]
fn numpy_reads_scans_alike() {
    let Some(python) = python_or_skip() else { return };
    let mut rng = Rng::new(57);
    let (mut ptx, mut pts) = (String::new(), String::new());
    for (columns, rows) in [(3, 7), (5, 4)] {
        let mut row = || rng.cube().map(|t| t.to_string()).join(" ");
        let (place, axes, matrix) = (row(), [row(), row(), row()], [row(), row(), row(), row()]);
        let matrix: Vec<String> =
            matrix.iter().zip([0, 0, 0, 1]).map(|(row, last)| format!("{row} {last}\n")).collect();
        ptx += &format!("{columns}\n{rows}\n{place}\n{}\n{}", axes.join("\n"), matrix.concat());
        pts += &format!("{}\n", columns * rows);
        for cell in 0..columns * rows {
            let point = scanned(&mut rng);
            ptx += if cell % 5 == 2 { "0 0 0 0.5 0 0 0\n" } else { &point };
            pts += &point;
        }
    }
    let script = "
import sys, numpy as np
lines = [line.split() for line in open(sys.argv[1])]
found = []
while lines:
    if sys.argv[1].endswith('ptx'):
        count, m = int(lines[0][0]) * int(lines[1][0]), np.array(lines[6:10], float)
        lines = lines[10:]
    else:
        count, m = int(lines[0][0]), np.eye(4)
        lines = lines[1:]
    x, y, z = np.array(lines[:count], float).T[:3]
    if sys.argv[1].endswith('ptx'):
        there = (x != 0) | (y != 0) | (z != 0)
        x, y, z = x[there], y[there], z[there]
        x, y, z = (x * m[0, k] + y * m[1, k] + z * m[2, k] + m[3, k] for k in range(3))
    found.append(np.stack([x, y, z], 1))
    lines = lines[count:]
sys.stdout.buffer.write(np.concatenate(found).tobytes())
";
    for (name, text, count) in [("a.ptx", &ptx, 33), ("a.pts", &pts, 41)] {
        let folder = folder(&[(name, text.as_bytes())]);
        let output = Command::new(&python).args(["-c", script]).arg(folder.path().join(name)).output().expect("python");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let centers =
            read_frame(name, text.as_bytes(), &ReadOptions::default()).expect("points").scene.spheres.centers.to_vec();
        assert_eq!(centers.len(), count, "{name}");
        assert!(output.stdout == little(&centers.concat()), "{name}");
    }
}
