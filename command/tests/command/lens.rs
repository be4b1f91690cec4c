//! The promise of `--aperture` and `[camera] aperture`: what the command says of a lens, what goes with it, and that parts of a
//! picture and cameras taken from it agree.

use crate::test_dir::TestDir;

const SCENE: &str = "[camera]
eye = [0.0, 0.0, 4.0]
at = [0.0, 0.0, -1.0]
up = [0.0, 1.0, 0.0]
vfov = 60.0
aperture = 0.5

[image]
size = [40, 30]

[[sphere]]
center = [0.5, 0.0, -1.0]
radius = 1.0

[[sphere]]
center = [-1.0, 0.5, -6.0]
radius = 1.5
";

const ATOMS: &str = "4\n\nC 0 0 0\nO 2 0 0\nN 0 2 0\nH 0 0 2\n";

#[test]
fn a_lens_takes_64_samples_unless_they_are_given_and_is_in_every_record() {
    let dir = TestDir::new(&[("a.toml", SCENE), ("a.xyz", ATOMS)]);
    let run = dir.run("render a.toml --backend cpu -o a.png --json");
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.err.contains("lens of diameter 0.5: what is 5 away is in focus, --samples 64"), "{}", run.err);
    let report = run.json();
    assert_eq!(
        (&report["samples"], &report["camera"]["aperture"], &report["camera"]["focus"]),
        (&64.into(), &0.5.into(), &5.0.into())
    );
    // The picture's camera, given again; and by options in place of the file's.
    dir.render("a.toml --aov color=a.npy");
    dir.render("a.toml --camera-from a.png --aov color=again.npy");
    assert_eq!(dir.array("a.npy"), dir.array("again.npy"));
    let given = dir.run("render a.toml --samples 9 --aperture 1 --focus-distance 8 -o b.png --json");
    assert!(given.err.contains("lens of diameter 1: what is 8 away is in focus\n"), "{}", given.err);
    assert_eq!(given.json()["samples"], 9);
    // A file without a camera is framed, and its middle is in focus: the length of the way from the eye.
    let framed = dir.run("render a.xyz --view front --size 40x30 --aperture 1 -o c.png --json").json();
    let camera = &framed["camera"];
    let focus = camera["focus"].as_f64().expect("a focus");
    // The middle of the box around the spheres has z between 0 and 2.
    let depth = camera["eye"][2].as_f64().expect("an eye") - focus;
    assert!(depth > 0.0 && depth < 2.0, "{framed}");
    let plan = dir.run("plan a.toml -o a.png");
    assert!(plan.text().contains("lens of diameter 0.500000, in focus 5.00000 away"), "{}", plan.text());
    // The rays toward a look's sky leave from the samples of a lens, not from the centres of pixels.
    let soft = dir.run("render a.xyz --view front --size 8x8 --aperture 1 -o d.png --json");
    assert!(soft.err.contains("a sky with 3 rays from each sample"), "{}", soft.err);
    assert_eq!(soft.json()["occlusion"].get("at_centers"), None);
    let plan = dir.run("plan a.xyz --view front --size 8x8 --aperture 1 -o d.png").text();
    assert!(plan.contains("sky        3 rays for each point") && plan.contains("192 to the sky"), "{plan}");
    // A turn keeps the plane in focus.
    let turned = dir.run("render a.toml --spin 2 --samples 4 -o t%d.png --json").json_lines();
    assert_eq!(turned.iter().map(|report| report["camera"]["focus"].as_f64()).collect::<Vec<_>>(), [Some(5.0); 2]);
}

#[test]
fn tiles_of_a_picture_through_a_lens_merge_to_the_whole() {
    let dir = TestDir::new(&[("a.toml", SCENE)]);
    let options = "--samples 9 --silhouette --occlusion 4 --shadows";
    dir.render(&format!("a.toml {options} -o whole.png"));
    for tile in 1..=4 {
        dir.render(&format!("a.toml {options} --tile {tile}/4 -o t{tile}.png"));
    }
    let merged = dir.run("merge t1.png t2.png t3.png t4.png -o merged.png");
    assert_eq!(merged.code, 0, "{}", merged.err);
    assert_eq!(dir.get("whole.png"), dir.get("merged.png"));
    // A part through another lens is of another picture, also for --resume.
    dir.render(&format!("a.toml {options} --tile 4/4 --aperture 0.6 -o t4.png"));
    assert_ne!(dir.run("merge t1.png t2.png t3.png t4.png -o other.png").code, 0);
    let again = dir.run(&format!("render a.toml --backend cpu {options} --aperture 0.6 --resume -o whole.png"));
    assert!(!again.err.contains("already there"), "{}", again.err);
}

#[test]
fn what_has_no_lens_is_refused_with_the_mend() {
    let dir = TestDir::new(&[
        ("a.toml", SCENE),
        ("a.xyz", ATOMS),
        ("parallel.toml", SCENE.replace("vfov = 60.0", "height = 6.0").as_str()),
        ("focus.toml", SCENE.replace("aperture", "focus").as_str()),
        ("view.toml", SCENE.replace("at = [0.0, 0.0, -1.0]", "view = [0.0, 0.0, -1.0]").as_str()),
    ]);
    for (arguments, code, words) in [
        ("a.toml --samples 1", 2, "--samples 64"),
        ("a.toml --ortho 5", 3, "camera.aperture"),
        ("a.xyz --aperture 1 --ortho", 2, "--ortho"),
        ("a.xyz --aperture 1 --stream", 2, "--aperture"),
        ("a.xyz --focus-distance 3", 2, "--aperture"),
        ("a.xyz --aperture 0", 2, "positive length"),
        ("parallel.toml", 3, "parallel.toml:6"),
        ("focus.toml", 3, "focus.toml:6"),
        ("view.toml", 3, "camera.focus"),
    ] {
        let run = dir.run(&format!("render {arguments} -o a.png"));
        assert_eq!(run.code, code, "{arguments}: {}", run.err);
        assert!(run.err.contains(words), "{arguments}: {}", run.err);
    }
}
