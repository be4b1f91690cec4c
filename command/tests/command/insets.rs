//! The promise of legend, label and scale bar inside the picture: they are in the picture of -o alone, say what the scene
//! says, and are part of its provenance.

use crate::test_dir::TestDir;

/// Two spheres whose middle is 10 before an eye at the origin, and a viewport of 1.5 x 1 at distance 1.
const SCENE: &str = "[camera]\neye = [0, 0, 0]\nview = [0, 0, -1]\nup = [0, 1, 0]\nviewport = [1.5, 1]
[image]\nsize = [300, 200]\nbackground = 'white'\n[[sphere]]\ncenter = [-1, 0, -10]\nradius = 1\n
[[sphere]]\ncenter = [1, 0, -10]\nradius = 1\n";

const ATOMS: &str = "3\nProperties=species:S:1:pos:R:3:vx:R:1\nC 0 0 0 3\nO 9 0 0 0\nH 18 0 0 6\n";

fn dir() -> TestDir {
    let two = format!("{ATOMS}{ATOMS}");
    TestDir::new(&[("s.toml", SCENE), ("atoms.xyz", ATOMS), ("two.xyz", two.as_str())])
}

/// The length of the longest dark run of pixels in the rows of an RGB picture.
fn longest_dark_run((levels, shape): &(Vec<f64>, Vec<usize>)) -> usize {
    let is_dark = |pixel: &[f64]| pixel.iter().all(|level| *level < 64.0);
    let runs = levels.chunks(3 * shape[1]).map(|row| {
        let (mut run, mut longest) = (0, 0);
        for pixel in row.chunks(3) {
            run = if is_dark(pixel) { run + 1 } else { 0 };
            longest = longest.max(run);
        }
        longest
    });
    runs.max().unwrap_or(0)
}

/// A quarter of 300 pixels is 75, or 3.75 scene units at 0.05 units a pixel: the bar is 2 units, 40 pixels, long.
#[test]
fn a_scale_bar_has_its_length() {
    let dir = dir();
    // Orthographic: 10 / 200 units a pixel. Perspective: 1.5 / 300 at distance 1, and 10 times that at the middle.
    for options in ["--ortho 10", "", "--ortho 20 --zoom 2"] {
        let err = dir.render(&format!("s.toml {options} --shade flat --color white --scale-bar -o a.png")).err;
        assert_eq!(longest_dark_run(&dir.array("a.png")), 40, "{options}");
        assert_eq!(err.contains("at the distance of the scene's middle"), options.is_empty(), "{options}: {err}");
    }
    let drawn = |name: &str| String::from_utf8_lossy(&dir.get(name)).into_owned();
    assert!(drawn("a.png").contains("scale bar: 2"));
    dir.render("s.toml --ortho 10 --scale-bar=nm -o b.exr");
    assert!(drawn("b.exr").contains("scale bar: 2 nm"));
    dir.refused_render(2, "s.toml --eye 0,0,-20 --scale-bar -o c.png", &["in front of the camera", "--ortho"]);
}

#[test]
fn panels_are_in_the_picture_and_in_no_other_buffer() {
    let dir = dir();
    let others = "--aov color=c.npy --aov depth,id=o.npz";
    dir.render(&format!("s.toml -o plain.png {others}"));
    let expected = [dir.get("c.npy"), dir.get("o.npz")];
    dir.render(&format!("s.toml --label {{file}} --scale-bar -o drawn.png {others}"));
    assert!([dir.get("c.npy"), dir.get("o.npz")] == expected, "buffers and their provenance");
    let ((plain, _), (drawn, shape)) = (dir.array("plain.png"), dir.array("drawn.png"));
    // Both panels are on the left, and a line of text is 9 pixels high.
    let mut changed = [0; 2];
    for (index, _) in plain.iter().zip(&drawn).enumerate().filter(|(_, (a, b))| a != b) {
        let (row, column) = (index / 3 / shape[1], index / 3 % shape[1]);
        assert!(column < 120 && !(40..150).contains(&row), "row {row}, column {column}");
        changed[usize::from(row > 100)] += 1;
    }
    assert!(changed.iter().all(|pixels| *pixels > 100), "{changed:?}");
    // Alpha of a panel: 0.8 of 255 is 204.
    dir.render("s.toml --transparent --label x -o t.png --aov alpha=a.npy");
    let (levels, _) = dir.array("t.png");
    assert_eq!(levels[4 * (6 * 300 + 6)..][..4], [255.0, 255.0, 255.0, 204.0]);
    assert_eq!(dir.array("a.npy").0[6 * 300 + 6], 0.0, "the buffer shows the scene alone");
}

/// Titles and captions stand in a legend in place of the program's words.
#[test]
fn a_legend_has_the_words_of_its_reader() {
    let dir = dir();
    let words = |options: &str| -> Vec<String> {
        let line = format!("render atoms.xyz {options} --backend cpu --size 60x40 -o a.png");
        line.split_whitespace().map(|word| word.replace('~', " ")).collect()
    };
    let legend = |options: &str| {
        let ran = dir.run(&words(&format!("{options} --legend l.svg")));
        assert_eq!(ran.code, 0, "{}", ran.err);
        String::from_utf8_lossy(&dir.get("l.svg")).into_owned()
    };
    assert!(legend("--color x~>~1=red:n=5~of~a:b").contains("n=5 of a:b"));
    assert!(legend("--color index~1:2=red:two").contains(">two<"));
    let titled = legend("--color-by vx --legend-title speed~/~nm");
    assert!(titled.contains("speed / nm") && !titled.contains("vx"), "{titled}");
    let captions = "--color x~>~1=red:far~away --color x~<~1=blue --opacity index~2=0.5:a~ghost";
    let rows = legend(&format!("{captions} --legend-title parts"));
    for (text, is_there) in [
        ("parts", true),
        ("far away", true),
        ("x &gt; 1", false),
        ("x &lt; 1", true),
        ("a ghost", true),
        ("0.5", false),
    ] {
        assert_eq!(rows.contains(text), is_there, "{text}: {rows}");
    }
    for (options, problem) in [
        ("--color red:all", "a caption belongs to a selection"),
        ("--color x~>~1=red:~", "the words for the legend are empty"),
        ("--color x~>~1=element:all", "a row for each element"),
        ("--radius x~>~1=2:big", "2:big"),
    ] {
        let ran = dir.run(&words(options));
        assert!(ran.code == 2 && ran.err.contains(problem), "{options}: {}", ran.err);
    }
}

/// A legend that names what next to no pixel shows says so.
#[test]
fn a_legend_warns_of_what_no_pixel_shows() {
    let dir = dir();
    dir.put("behind.xyz", "3\n\nC 0 0 0\nO 0 0 -1\nN 5 0 0\n");
    for (camera, is_hidden) in [("--eye 0,0,30 --at 0,0,0", true), ("--eye 0,0,-30 --at 0,0,0", false)] {
        for legend in ["--legend-in", "--legend l.svg"] {
            let err = dir.render(&format!("behind.xyz {camera} --ortho 12 --size 220x150 {legend} -o a.png")).err;
            assert_eq!(err.contains("pixels of spheres show (O: 0 pixels)"), is_hidden, "{err}");
        }
    }
    let err = dir.render("behind.xyz --eye 0,0,30 --at 0,0,0 --ortho 12 --size 220x150 -o a.png").err;
    assert!(!err.contains("legend"), "{err}");
}

#[test]
fn a_legend_has_the_colours_of_the_spheres() {
    let dir = dir();
    let colors = |corner: &str, column: &str| {
        dir.render(&format!("atoms.xyz --color-by {column} --size 300x200 --zoom 0.2 --legend-in{corner} -o a.png"));
        let (levels, _) = dir.array("a.png");
        move |color: [f64; 3]| {
            // The atoms are in the middle fifth.
            let legend = |at: &usize| !(100..200).contains(&(at % 300));
            let mut all = levels.chunks(3).enumerate().filter(|(_, pixel)| *pixel == color).map(|(at, _)| at);
            all.find(legend).map(|at| (at / 300, at % 300))
        }
    };
    // The ends of viridis: 440154 at the bottom, fde725 at the top.
    let (dark, bright) = ([68.0, 1.0, 84.0], [253.0, 231.0, 37.0]);
    for (corner, right, lower) in [
        ("", true, None),
        ("=top-right", true, Some(false)),
        (" top-right", true, Some(false)),
        ("=top-left", false, Some(false)),
        (" bottom-left", false, Some(true)),
        ("=bottom-left", false, Some(true)),
        ("=bottom-right", true, Some(true)),
    ] {
        let at = colors(corner, "vx");
        let (low, high) = (at(dark).expect("the low end"), at(bright).expect("the high end"));
        assert!(high.0 < low.0 && (high.1 > 150) == right, "{corner}: {high:?} above {low:?}");
        // The bar is half as high as the picture.
        assert!(
            lower.is_none_or(|lower| (low.0 > 160) == lower && (high.0 < 50) != lower),
            "{corner}: {high:?} {low:?}"
        );
    }
    // Jmol's red of oxygen, which a shaded sphere shows nowhere.
    let at = colors("", "element");
    assert!(at([255.0, 13.0, 13.0]).is_some_and(|(_, column)| column > 150));
}

#[test]
fn a_label_belongs_to_its_frame_and_to_the_provenance() {
    let dir = dir();
    let frames = |label: &str| {
        let words = ["render", "two.xyz", "--backend", "cpu", "--size", "200x90", "--frames", "1-2", "-o", "f%d.png"];
        dir.good(&[&words[..], &["--label", label]].concat());
        [dir.get("f1.png"), dir.get("f2.png")]
    };
    let [one, two] = frames("the same");
    assert!(one == two);
    let [one, two] = frames("{file}: {frame} of 2, {count} atoms");
    let says = |bytes: &[u8], text: &str| String::from_utf8_lossy(bytes).contains(text);
    assert!(says(&one, "label: two.xyz: 1 of 2, 3 atoms") && says(&two, "label: two.xyz: 2 of 2, 3 atoms"));
    let again = |label: &str| dir.render(&format!("s.toml -o r.png --label {label} --resume")).err;
    again("one");
    assert!(again("one").contains("already there") && !again("two").contains("already there"));
    assert!(again("two").contains("already there"));
}

/// The label is in the provenance of the picture.
#[test]
fn labels_have_the_time_and_the_step_of_their_frame() {
    let dir = dir();
    let gro = |t: &str| format!("water, t= {t}\n1\n    1SOL     OW    1   0.000   0.100   0.200\n 1 1 1\n");
    dir.put("a.gro", gro("0.00000 step= 0") + &gro("2.50000 step= 1250"));
    let atom = |time: f64| format!("1\nTime={time} Properties=species:S:1:pos:R:3\nO 0 0 0\n");
    dir.put("t.xyz", atom(0.125) + &atom(1e3));
    dir.put("a.dump", "ITEM: TIMESTEP\n40\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x y z\n0 0 0\n");
    for (file, frame, label, text) in [
        ("a.gro", 2, "t_=_{time}_ps,_step_{step}", "t_=_2.5_ps,_step_1250"),
        ("a.gro", 1, "{time}/{step}", "0/0"),
        ("t.xyz", 1, "{time}", "0.125"),
        ("t.xyz", 2, "{time}", "1000"),
        ("a.dump", 1, "{step}", "40"),
    ] {
        dir.render(&format!("{file} --frames {frame} --label {label} -o l.png"));
        let drawn = String::from_utf8_lossy(&dir.get("l.png")).into_owned();
        assert!(drawn.contains(&format!("label: {text}")), "{file} {frame}: {text}");
    }
}

/// DejaVu Sans has the letters of Europe and the signs of physics, and no Chinese ones
/// (<https://dejavu-fonts.github.io/>, unicover.txt).
#[test]
fn letters_that_the_font_lacks_are_named() {
    let dir = dir();
    dir.put("names.csv", "x,y,z,kind\n0,0,0,\u{6c34}\n4,0,0,Na\u{207a}\n");
    let warning = |options: &[&str]| {
        let run = dir.render(&[options, &["-o", "a.png", "--json"]].concat());
        let warnings: Vec<String> = serde_json::from_value(run.json()["warnings"].clone()).expect("texts");
        warnings.iter().for_each(|text| assert!(run.err.contains(text.as_str()), "{text}: {}", run.err));
        warnings.into_iter().find(|text| text.contains("font"))
    };
    let legend = ["names.csv", "--radius", "1", "--color-by", "kind", "--legend-in"];
    for (options, lacks) in [
        (
            &["s.toml", "--label", "\u{c5}ngstr\u{f6}m \u{2264} \u{3b1} \u{6c34}\u{6e29}\u{6c34}"][..],
            "\u{6c34} (U+6C34), \u{6e29} (U+6E29)",
        ),
        (&["s.toml", "--scale-bar=\u{6c34}"], "\u{6c34} (U+6C34)"),
        (&["s.toml", "--label", "a\u{e000}"], "\\u{e000} (U+E000)"),
        (&legend, "\u{6c34} (U+6C34)"),
    ] {
        let message = warning(options).unwrap_or_else(|| panic!("{options:?}"));
        assert!(message.contains(&format!("lacks {lacks}: boxes")), "{message}");
    }
    let file = |name| [&legend[..5], &["--legend", name]].concat();
    assert!(warning(&file("l.png")).is_some_and(|message| message.contains("lacks \u{6c34} (U+6C34): boxes")));
    let known = ["s.toml", "--label", "\u{c5} \u{2264} \u{b5}m\u{b2}"];
    for options in [&known[..], &["s.toml"], &legend[..5], &file("l.svg")] {
        assert_eq!(warning(options), None, "{options:?}");
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let dir = dir();
    for options in ["--crop 0,0,9,9 -o a.png", "--tile 1/2 -o a.png"] {
        dir.refused_render(2, &format!("s.toml --label x {options}"), &["whole pictures", "--crop or --tile"]);
    }
    for options in ["-o a.npy", "-o a.npz", "-o a.pfm", "--aov id=i.npy", "--json", "-o - --raw"] {
        dir.refused_render(
            2,
            &format!("s.toml --scale-bar {options}"),
            &["--scale-bar", ".webp, .svg, .pdf, .mp4 or .gif"],
        );
    }
    dir.refused_render(2, "s.toml --legend-in -o a.png", &["--color-by"]);
    dir.refused_render(2, "atoms.xyz --color-by vx --legend-in=middle -o a.png", &["middle", "bottom-left"]);
    for label in ["{", "}", "{x}", "{frame"] {
        dir.refused_render(2, &format!("s.toml --label {label} -o a.png"), &["--label", "{frame}, {file}, {count}"]);
    }
    for name in ["time", "step"] {
        dir.refused_render(2, &format!("s.toml --label {{{name}}} -o a.png"), &[name, &format!("no {name}")]);
    }
    let dump = "ITEM: TIMESTEP\n40\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x y z\n0 0 0\n";
    dir.put("a.dump", dump);
    dir.refused_render(2, "a.dump --label {time} -o a.png", &["no time", "{step}"]);
    for option in ["--label x", "--scale-bar"] {
        dir.refused_render(2, &format!("s.toml {option} --size 12x9 -o a.png"), &["12 x 9", "--size"]);
    }
    dir.refused_render(2, "atoms.xyz --color-by vx --legend-in --size 40x30 -o a.png", &["40 x 30", "legend"]);
}
