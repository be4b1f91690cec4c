//! The promise of `--material`: the materials of scene files for files of particles.

use crate::test_dir::TestDir;
use serde_json::json;

const SIZE: &str = "--size 90x70 --look plain --sun 0,0,1 --eye 0,0,9 --at 0,0,0 --vfov 40";

/// Two atoms side by side, and the same spheres as a scene with this material of the second.
fn dir() -> TestDir {
    TestDir::new(&[("two.xyz", "2\ntwo\nC -1.8 0 0\nO 1.8 0 0\n")])
}

/// The picture of a command whose words have ~ in place of spaces.
fn picture(dir: &TestDir, options: &str) -> Vec<f64> {
    let words = format!("two.xyz {SIZE} {options} -o a.npy").replace(" -o", " --color white -o");
    dir.render(&words.split_whitespace().map(|word| word.replace('~', " ")).collect::<Vec<_>>());
    dir.array("a.npy").0
}

fn scene(dir: &TestDir, material: &str) -> Vec<f64> {
    let camera = "[camera]\neye = [0.0, 0.0, 9.0]\nat = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nvfov = 40.0\n";
    let ball = |x: f64, r: f64| format!("[[sphere]]\ncenter = [{x:?}, 0.0, 0.0]\nradius = {r:?}\ncolor = \"white\"\n");
    let balls = format!("{}{}{material}\n", ball(-1.8, 1.7), ball(1.8, 1.52));
    dir.put("scene.toml", format!("{camera}[image]\nsize = [90, 70]\n{balls}"));
    dir.render("scene.toml --sun 0,0,1 -o s.npy");
    dir.array("s.npy").0
}

#[test]
fn materials_of_particles_are_those_of_scene_files() {
    let dir = dir();
    let plain = picture(&dir, "");
    for (option, of_file) in [
        ("--material element~O=plastic", "material = \"plastic\""),
        ("--material element~O=plastic --shine 8", "material = \"plastic\"\nshine = 8.0"),
        ("--material all=glass --material element~C=matte --material element~O=metal", "material = \"metal\""),
        ("--material element~O=glass", "material = \"glass\""),
    ] {
        let own = picture(&dir, option);
        assert!(own == scene(&dir, of_file), "{option}");
        assert!(own != plain, "{option}");
    }
    assert!(picture(&dir, "--material matte") == plain);
    assert!(scene(&dir, "material = \"matte\"") == plain);
}

/// The highlight of plastic adds white light where the mirrored ray meets the sun, and nothing else.
#[test]
fn plastic_has_highlights() {
    let dir = dir();
    let (plain, plastic) = (picture(&dir, ""), picture(&dir, "--material plastic"));
    let added: Vec<f64> = plain.iter().zip(&plastic).map(|(a, b)| b - a).collect();
    assert!(added.iter().all(|added| *added >= 0.0));
    let most = added.iter().copied().fold(0.0, f64::max);
    // 0.8 of the sun where it is mirrored exactly, in a pixel near that place less.
    assert!((0.7..=0.8 + 1e-6).contains(&most), "{most}");
    let bright = |shine: &str| {
        let glossy = picture(&dir, &format!("--material plastic --shine {shine}"));
        plain.iter().zip(glossy).filter(|(a, b)| *b > **a + 0.05).count()
    };
    assert!(bright("5") > 3 * bright("50"), "{} {}", bright("5"), bright("50"));
    let report = dir.render("two.xyz --size 20x20 --look plain --material plastic -o b.png --json").json();
    let idle = "plastic has no highlights: the picture has no light; --sun and --look soft add one";
    assert_eq!(report["warnings"], json!([idle]));
    let report = dir.render("two.xyz --size 20x20 --material plastic -o b.png --json").json();
    assert_eq!(report["warnings"], json!([]), "the look soft has a light");
}

#[test]
fn invalid_materials_are_refused() {
    let dir = dir();
    dir.put("rows.csv", "x,y,z,radius\n0,0,0,1\n");
    for (words, expected) in [
        ("two.xyz --material wood -o a.png", &["--material", "wood", "matte, plastic, metal, glass"][..]),
        ("two.xyz --shine 5 -o a.png", &["--shine belongs to plastic", "--material plastic"]),
        ("two.xyz --shine 0 --material plastic -o a.png", &["--shine"]),
        ("rows.csv --material plastic --stream -o a.png", &["--stream", "materials", "--material"]),
    ] {
        dir.refused_render(2, words, expected);
    }
    dir.put("wrong.toml", "[camera]\neye = [0, 0, 9]\nat = [0, 0, 0]\nup = [0, 1, 0]\nvfov = 40\n[image]\nsize = [9, 9]\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"matte\"\nshine = 3\n");
    dir.refused_render(3, "wrong.toml -o a.png", &["wrong.toml:12:9", "matte has no such key", "it has none"]);
}
