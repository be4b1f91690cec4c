//! The promise of the pictures in the documentation: each is what the command beside it renders.

use crate::amount::{amount, everything};
use crate::data::{in_checkout, real};
use crate::skip::skip;
use crate::test_dir::TestDir;

/// A picture of the documentation, and the words of the command that stands with it.
struct Picture {
    file: std::path::PathBuf,
    words: Vec<String>,
}

/// The words of a line of a shell; quotes hold words together.
fn words(line: &str) -> Vec<String> {
    let mut quoted = false;
    let between = |c: char| {
        quoted ^= c == '\'';
        c == ' ' && !quoted
    };
    line.split(between).filter(|word| !word.is_empty()).map(|word| word.replace('\'', "")).collect()
}

/// The pictures of docs/figure.md, and those that README.md has beside its commands.
fn pictures() -> Vec<Picture> {
    let text = |file: &str| std::fs::read_to_string(in_checkout(file)).expect("a page");
    let pages =
        [(text("README.md"), vec!["docs/", "docs/gallery/"]), (text("docs/figure.md"), vec!["figure/", "gallery/"])];
    let of_page = |(page, folders): &(String, Vec<&str>)| {
        let of = |line: &str| {
            let line = line.trim_start().replacen(
                "cargo run --release --no-default-features --bin halfline --",
                "halfline",
                1,
            );
            let words = words(line.split("  #").next()?.strip_prefix("halfline render ")?);
            let name = words.last()?;
            let folder = folders.iter().find(|folder| page.contains(&format!("]({folder}{name})")))?;
            let file = in_checkout(&format!("docs/{}{name}", folder.trim_start_matches("docs/")));
            Some(Picture { file, words })
        };
        page.lines().filter_map(of).collect::<Vec<_>>()
    };
    pages.iter().flat_map(of_page).collect()
}

/// Columns and rows of the part that is compared unless all tests run.
const PART: usize = 40;

#[test]
fn pictures_of_the_documentation_are_what_their_commands_render() {
    let pictures = pictures();
    let names: Vec<_> = pictures.iter().filter_map(|picture| picture.file.file_name()?.to_str()).collect();
    assert!(names.len() >= 15, "{names:?}");
    assert!(
        ["weekend.png", "capsid.png", "vortex.png", "pocket.png"].iter().all(|name| names.contains(name)),
        "{names:?}"
    );
    let mut compared = 0;
    if !everything() {
        println!("LEFT OUT: pixels of pictures of the documentation: {PART} x {PART} of each");
    }
    let apart = 3 / amount("pictures of the documentation, in thirds", [1, 3, 3]);
    for Picture { file, words } in pictures.iter().step_by(apart) {
        let scene = if words[0].starts_with("scenes/") { Some(in_checkout(&words[0])) } else { real(&words[0]) };
        let Some(scene) = scene else {
            println!("LEFT OUT: a picture of the documentation: {} is not there", words[0]);
            continue;
        };
        let dir = TestDir::new(&[]);
        if file.extension().is_some_and(|ending| ending == "svg") {
            let mut arguments = vec![scene.to_str().expect("a name").to_owned()];
            arguments.extend_from_slice(&words[1..]);
            dir.render(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
            let found = String::from_utf8(dir.get(words.last().expect("a name"))).expect("text");
            let expected = std::fs::read_to_string(file).expect("a figure");
            assert!(is_same_figure(&found, &expected), "{} differs from the figure of {words:?}", file.display());
            compared += 1;
            continue;
        }
        let (expected, shape) = dir.array(file.to_str().expect("a name"));
        let [height, width, channels] = shape[..] else { panic!("{shape:?}") };
        // Panels and texts are drawn into whole pictures.
        let drawn = ["--legend-in", "--label", "--scale-bar", "--mark"];
        let is_whole = everything() || words.iter().any(|word| drawn.iter().any(|option| word.starts_with(option)));
        let [x0, y0, x1, y1] = if is_whole { [0, 0, width, height] } else { busiest(&expected, width, channels) };
        let mut arguments = vec![scene.to_str().expect("a name").to_owned()];
        arguments.extend_from_slice(&words[1..]);
        if !is_whole {
            arguments.extend(["--crop".to_owned(), format!("{x0},{y0},{x1},{y1}")]);
        }
        dir.render(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        let (found, _) = dir.array(words.last().expect("a name"));
        let rows = (y0..y1).flat_map(|y| &expected[channels * (y * width + x0)..channels * (y * width + x1)]);
        assert!(found.iter().eq(rows), "{} differs from the picture of {words:?}", file.display());
        compared += 1;
    }
    println!("{compared} of {} pictures", pictures.len());
    if compared == 0 {
        skip("no scene of a picture is there");
    }
}

/// Whether two texts differ in their numbers alone, and these by a hundredth at most, to which gradients are rounded: sines differ by their
/// last digit between machines.
fn is_same_figure(a: &str, b: &str) -> bool {
    let parts = |text: &str| -> Vec<String> {
        let is_number = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
        let mut parts = vec![String::new()];
        let mut was_number = false;
        for c in text.chars() {
            if is_number(c) != was_number {
                parts.push(String::new());
                was_number = !was_number;
            }
            parts.last_mut().expect("a part").push(c);
        }
        parts
    };
    let is_near = |(a, b): (&String, &String)| {
        a == b || matches!((a.parse::<f64>(), b.parse::<f64>()), (Ok(a), Ok(b)) if (a - b).abs() < 0.011)
    };
    let [a, b] = [a, b].map(parts);
    a.len() == b.len() && a.iter().zip(&b).all(is_near)
}

/// The part with the most change from column to column, among some.
fn busiest(values: &[f64], width: usize, channels: usize) -> [usize; 4] {
    let height = values.len() / channels / width;
    let change = |[x, y]: [usize; 2]| -> f64 {
        let at = |x: usize, y: usize| values[channels * (y * width + x)];
        (0..PART * PART).map(|n| [x + n % PART, y + n / PART]).map(|[x, y]| (at(x + 1, y) - at(x, y)).abs()).sum()
    };
    let places =
        (0..height - PART).step_by(PART).flat_map(|y| (0..width - PART - 1).step_by(PART).map(move |x| [x, y]));
    let [x, y] = places.max_by(|a, b| change(*a).total_cmp(&change(*b))).expect("a part");
    [x, y, x + PART, y + PART]
}

/// The kind of a file that is none of the formats decides which of them is named first.
#[test]
fn unknown_endings_name_the_nearest() {
    let dir = TestDir::new(&[("t.csv", "x,y,z,radius\n0,0,0,1\n")]);
    for (file, first) in [
        ("a.webm", "; a film of several pictures is .mp4 or .gif; else use"),
        ("a.%d.MOV", "; a film of several pictures is .mp4 or .gif; else use"),
        ("a.gltf", "; a model of the spheres is .glb; else use"),
        ("a.obj", "; a model of the spheres is .glb; else use"),
        (
            "a.tga",
            ".webp; a film of several pictures is .mp4 or .gif, a model of the spheres is .glb, a figure without",
        ),
        ("a", ".webp; a film of several pictures is .mp4 or .gif, a model of the spheres is .glb, a figure without"),
    ] {
        let words = format!("render t.csv --size 8x8 -o {file}");
        dir.refused(2, &words, &[first, ".png, .exr"]);
        dir.refused(2, &format!("render t.csv --size 8x8 --aov depth={file}"), &["; use the file name extension"]);
    }
}

/// Spheres smaller than `--least-size` get this width, and a warning counts them.
#[test]
fn small_spheres_have_a_least_size() {
    let dir = TestDir::new(&[("two.csv", "x,y,z,radius\n-5,0,0,1e-6\n5,0,0,2\n")]);
    let camera = "two.csv --eye 0,0,40 --at 0,0,0 --ortho 20 --size 200x200 --look plain";
    let pixels = |options: &str| {
        let ran = dir.render(&format!("{camera} {options} --aov id=i.npy"));
        let ids = dir.array("i.npy").0;
        ([0.0, 1.0].map(|id| ids.iter().filter(|found| **found == id).count()), ran.err)
    };
    let ([none, whole], err) = pixels("");
    assert!(none == 0 && !err.contains("enlarged"), "{none} {err}");
    let ([small, same], err) = pixels("--least-size 10");
    // A disc of 10 pixels across: 78.5.
    assert!((70..88).contains(&small) && same == whole, "{small} {same} {whole}");
    assert!(err.contains("1 of 2 spheres are enlarged to 10 pixels"), "{err}");
    dir.refused_render(2, &format!("{camera} --least-size 3 --stream -o a.png"), &["--least-size"]);
    dir.refused_render(2, &format!("{camera} --least-size 0 -o a.png"), &["--least-size"]);
}
