//! The promise of radii and colours: they follow the options, a legend shows their meaning, and invalid options are
//! refused before anything is written.

use crate::test_dir::TestDir;
use halfline::frame::color_map::ColorMap;

/// Two atoms apart, with columns; one number is missing, one has no logarithm.
const ATOMS: &str = "3\nProperties=species:S:1:pos:R:3:vx:R:1:vy:R:1:q:R:1:kind:I:1:type:I:1
C 0 0 0 3 4 1 0 0\nO 9 0 0 0 0 -2 1 1\nH 18 0 0 6 8 nan 2 2\n";

const NATIVE: &str = "[camera]\neye = [0, 0, 9]\nview = [0, 0, -1]\nup = [0, 1, 0]\nvfov = 40\n[image]\nsize = [30, 20]
background = [0.25, 0.5, 0.75]\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\ncolor = [0.5, 0.25, 1]\n";

fn dir() -> TestDir {
    TestDir::new(&[("atoms.xyz", ATOMS), ("native.toml", NATIVE), ("bare.csv", "x,y,z\n0,0,0\n4,0,0\n")])
}

/// The colours of the three atoms, rendered with flat shading.
fn colors(dir: &TestDir, options: &str) -> [[f32; 3]; 3] {
    dir.render(&format!("atoms.xyz --size 120x40 --shade flat --aov id=id.npy -o c.npy {options}"));
    let ((ids, _), (pixels, _)) = (dir.array("id.npy"), dir.array("c.npy"));
    [0.0, 1.0, 2.0].map(|id| {
        let visible: Vec<_> = ids.iter().zip(pixels.chunks(3)).filter(|(i, _)| **i == id).map(|(_, c)| c).collect();
        assert!(
            !visible.is_empty() && visible.iter().all(|c| c == &visible[0]),
            "{options}: sphere {id} has one colour"
        );
        [0, 1, 2].map(|k| visible[0][k] as f32)
    })
}

#[test]
fn colours_follow_the_options() {
    let dir = dir();
    let ends = |map: ColorMap, parts: [f64; 3]| parts.map(|part| map.color(part));
    assert_eq!(colors(&dir, "--color 0.1,0.2,0.3"), [[0.1, 0.2, 0.3]; 3]);
    assert_eq!(colors(&dir, "--color #ffffff"), [[1.0; 3]; 3]);
    let elements = colors(&dir, "--color-by element");
    assert_eq!(elements, colors(&dir, ""), "the colours of elements are the default");
    assert!(elements[1][0] > elements[1][2] && elements[0] != elements[2], "oxygen is red: {elements:?}");
    // 3, 0, 6 between their least and their largest; 5, 0, 10 as lengths.
    assert_eq!(colors(&dir, "--color-by vx"), ends(ColorMap::Viridis, [0.5, 0.0, 1.0]));
    assert_eq!(colors(&dir, "--color-by VX,vy --map magma"), ends(ColorMap::Magma, [0.5, 0.0, 1.0]));
    assert_eq!(colors(&dir, "--color-by vx --range 0,12 --map grays"), ends(ColorMap::Grays, [0.25, 0.0, 0.5]));
    assert_eq!(colors(&dir, "--color-by vx --range 6,0"), ends(ColorMap::Viridis, [0.5, 1.0, 0.0]));
    assert_eq!(colors(&dir, "--color-by vx --range 4,5"), ends(ColorMap::Viridis, [0.0, 0.0, 1.0]), "beyond the ends");
    let reversed = ColorMap::Vik.reversed().expect("a direction");
    assert_eq!(colors(&dir, "--color-by vx --range 0,12 --map vik_r"), ends(reversed, [0.25, 0.0, 0.5]));
    dir.put("own.csv", "r,g,b\n0,0,255\n255,255,255\n255,0,0\n");
    let own = ColorMap::of_colors("own", vec![[0, 0, 255], [255; 3], [255, 0, 0]]).expect("a map");
    assert_eq!(colors(&dir, "--color-by vx --range 0,12 --map own.csv"), ends(own, [0.25, 0.0, 0.5]));
    let categories = [0.0, 1.0, 2.0].map(|k| ColorMap::Category.color(k));
    assert_eq!(colors(&dir, "--color-by kind --map category"), categories);
    assert_eq!(colors(&dir, "--color-by kind"), ends(ColorMap::Viridis, [0.0, 0.5, 1.0]), "a number like others");
    assert_eq!(colors(&dir, "--color-by type"), categories, "types are names");
    assert_eq!(colors(&dir, "--color-by type --map viridis"), ends(ColorMap::Viridis, [0.0, 0.5, 1.0]));
    let log = colors(&dir, "--color-by vx --log");
    assert_eq!([log[0], log[1], log[2]], ends(ColorMap::Viridis, [0.0, 0.0, 1.0]), "3 and 6 are the ends");
}

/// In memory and as a stream; the legend has a row for it.
#[test]
fn what_has_no_number_has_a_colour_of_its_own() {
    let dir =
        TestDir::new(&[("n.csv", "x,y,z,radius,q,kind\n0,0,0,1,3,1\n3,0,0,1,nan,nan\n6,0,0,1,5,2\n9,0,0,1,,1\n")]);
    let camera = "--eye 4.5,0,30 --at 4.5,0,0 --ortho 4 --size 48x16 --look plain --shade flat --backend cpu";
    let of = |options: &str| {
        dir.good(&format!("render n.csv {camera} {options} -o a.npy"));
        let (values, _) = dir.array("a.npy");
        // The middles of the spheres, 12 pixels apart.
        [6, 18, 30, 42].map(|column| [0, 1, 2].map(|channel| values[3 * (8 * 48 + column) + channel] as f32))
    };
    let grey = halfline::frame::srgb::linear([0x80; 3]);
    let [low, high] = [0.0, 1.0].map(|part| ColorMap::Viridis.color(part));
    for stream in ["", "--stream"] {
        assert_eq!(of(&format!("--color-by q {stream}")), [low, grey, high, grey], "{stream}");
        let own = of(&format!("--color-by q --nan-color 1,0.5,0 {stream}"));
        assert_eq!(own, [low, [1.0, 0.5, 0.0], high, [1.0, 0.5, 0.0]], "{stream}");
        let log = of(&format!("--color-by q --log --nan-color 0,1,0 {stream}"));
        assert_eq!(log, [low, [0.0, 1.0, 0.0], high, [0.0, 1.0, 0.0]], "{stream}");
        dir.good(&format!("render n.csv {camera} --color-by q {stream} --legend l{stream}.svg -o a.png"));
    }
    let legend = String::from_utf8(dir.get("l.svg")).expect("text");
    assert!(legend.contains("no number") && legend.contains("#808080"), "{legend}");
    assert!(legend.as_bytes() == dir.get("l--stream.svg"), "the legend of a stream");
    let categories = of("--color-by kind --map category --nan-color 0,0,1");
    assert_eq!([categories[1], categories[3]], [[0.0, 0.0, 1.0], ColorMap::Category.color(1.0)]);
    dir.good(&format!("render n.csv {camera} --color-by x --legend m.svg -o a.png"));
    assert!(!String::from_utf8(dir.get("m.svg")).expect("text").contains("no number"), "all have one");
    dir.refused(2, &format!("render n.csv {camera} --nan-color red -o a.png"), &["--nan-color", "--color-by"]);
}

#[test]
fn values_without_a_place_on_the_map_are_counted() {
    let dir = dir();
    for (options, expected) in [
        ("--color-by q", "1 of 3 values of q are not numbers"),
        ("--color-by q --log", "2 of 3 values of q are not positive numbers"),
        ("--color-by vy --log", "1 of 3 values of vy are not positive"),
    ] {
        let err = dir.render(&format!("atoms.xyz --size 20x20 -o a.png {options}")).err;
        assert!(err.contains(expected), "{options}: {err}");
    }
    assert!(!dir.render("atoms.xyz --size 20x20 -o a.png --color-by vx").err.contains("warning"));
}

#[test]
fn an_invalid_colouring_is_refused_with_the_valid_ones() {
    let dir = dir();
    dir.refused_render(2, "atoms.xyz -o a.png --color-by mass", &["`mass`", "x, y, z, vx, vy, q, kind, type"]);
    dir.refused_render(2, "atoms.xyz -o a.png --color-by vx,mass", &["`mass`"]);
    dir.refused_render(2, "native.toml -o a.png --color-by vx", &["no columns"]);
    dir.refused_render(2, "native.toml -o a.png --color-by element", &["no elements"]);
    dir.refused_render(2, "bare.csv -o a.png --color-by element", &["no elements"]);
    dir.refused_render(2, "atoms.xyz -o a.png --color-by vx --log --range 0,5", &["0,5", "logarithm"]);
    dir.refused_render(2, "atoms.xyz -o a.png --color-by vx --map rainbow", &["rainbow", "viridis", "category"]);
    dir.refused_render(2, "atoms.xyz -o a.png --color-by vx --map jet", &["jet", "lightness", "edges", "use turbo"]);
    for words in ["--range 0 3 atoms.xyz", "atoms.xyz --range 0 3"] {
        dir.refused_render(2, &format!("{words} -o a.png --color-by vx"), &["comma", "--range=0,3"]);
    }
    dir.refused_render(2, "atoms.xyz -o a.png --color-by vx --range=-2.5 7e1", &["comma", "--range=-2.5,7e1"]);
    dir.refused_render(2, "atoms.xyz -o a.png --color-by vx --range 1,1", &["--range", "different"]);
    for lonely in ["--range 0,1", "--log"] {
        dir.refused_render(2, &format!("atoms.xyz -o a.png {lonely}"), &["--color-by"]);
    }
    for (file, options) in [("bare.csv", ""), ("atoms.xyz", "--color red"), ("native.toml", "")] {
        let words = format!("{file} -o a.png --legend l.svg {options}");
        dir.refused_render(2, &words, &["neither elements nor a column", "--color-by"]);
    }
    dir.refused_render(2, "atoms.xyz -o a.png --color #fff --color-by vx", &["--color"]);
    dir.refused_render(2, "atoms.xyz -o a.png --color rde", &["rde", "use red", "#rrggbb"]);
}

#[test]
fn a_legend_shows_round_numbers_and_is_checked_before_any_work() {
    let dir = dir();
    let legend = |options: &str, name: &str| {
        dir.render(&format!("atoms.xyz --size 20x20 -o a.png {options} --legend {name}"));
        dir.get(name)
    };
    let text = |options: &str| String::from_utf8(legend(options, "l.svg")).expect("UTF-8");
    let plain = text("--color-by vx,vy");
    assert!([">|vx, vy|<", ">0<", ">2.5<", ">5<", ">7.5<", ">10<"].iter().all(|part| plain.contains(part)), "{plain}");
    let log = text("--color-by vx --log --range 1,100");
    assert!([">vx (logarithmic)<", ">1<", ">10<", ">100<"].iter().all(|part| log.contains(part)), "{log}");
    // A single positive value has one mark.
    assert!(text("--color-by q --log").contains(">1<"));
    assert!(legend("--color-by vx", "l.png").starts_with(b"\x89PNG"));
    dir.put("none.xyz", "1\nProperties=species:S:1:pos:R:3:q:R:1\nC 0 0 0 nan\n");
    let err = dir.render("none.xyz --size 20x20 -o a.png --color-by q --legend none.svg").err;
    assert!(err.contains("1 of 1 values of q") && !dir.path("none.svg").exists(), "{err}");

    for (options, code, expected) in [
        ("--color-by vx --legend l.gif", 2, ".svg or .png"),
        ("--color-by vx --legend new", 2, ".svg or .png"),
        ("--color-by vx --legend no/l.svg", 8, "does not exist"),
        ("--color-by vx --legend ./new.png", 2, "twice"),
        ("--color-by type --range 0,5 --map category --legend l.svg", 2, "no range"),
        ("--color-by type --log --map category", 2, "no logarithm"),
        ("--color-by type,kind --map category", 2, "no length"),
        // A refused frame leaves no file behind, and no legend.
        ("--color-by vx --legend new.svg --crop 0,0,99999,1", 2, "99999"),
    ] {
        dir.refused_render(code, &format!("atoms.xyz -o new.png {options}"), &[expected]);
    }
    let two = format!("{ATOMS}{ATOMS}");
    dir.put("two.xyz", two);
    let frames = "two.xyz --size 20x20 --frames 1-2 -o t%d.png --color-by vx --legend";
    dir.refused_render(2, &format!("{frames} l.svg --hold none"), &["l.svg", "l.%04d.svg"]);
    dir.render(&format!("{frames} l%d.svg"));
    assert!(dir.get("l1.svg") == dir.get("l2.svg"));
    dir.render(&format!("{frames} held.svg"));
    assert!(dir.get("held.svg") == dir.get("l1.svg"), "frames have a common range");
    dir.render(&format!("{frames} all.svg --range 0,9"));
    assert!(String::from_utf8_lossy(&dir.get("all.svg")).contains(">8<"));
}

#[test]
fn a_legend_of_categories_has_names_and_no_ticks() {
    let dir = dir();
    let atom = |chain: &str, x: f64| {
        format!("ATOM      1  CA  ALA {chain}   1    {x:8.3}   0.000   0.000  1.00  0.00           C\n")
    };
    dir.put("chains.pdb", [atom("A", 0.0), atom("L", 9.0), atom(" ", 18.0), atom("L", 27.0)].concat());
    let legend = |words: &str| {
        dir.render(&format!("{words} --size 60x20 -o a.png --legend l.svg"));
        String::from_utf8(dir.get("l.svg")).expect("UTF-8")
    };
    let chains = legend("chains.pdb --color-by chain");
    assert!([">chain<", ">A<", ">L<", ">(blank)<"].iter().all(|label| chains.contains(label)), "{chains}");
    assert!(chains.matches("<rect").count() == 4 && !chains.contains("<path"), "three swatches on white: {chains}");
    let elements = legend("atoms.xyz --color-by element");
    assert!([">H<", ">C<", ">O<"].iter().all(|label| elements.contains(label)), "{elements}");
    let types = legend("atoms.xyz --color-by kind --map category");
    assert!([">0<", ">1<", ">2<"].iter().all(|label| types.contains(label)) && !types.contains("0.5"), "{types}");
    // The picture has the colours of the legend.
    dir.render("chains.pdb --size 160x40 --shade flat --aov id=id.npy -o c.png --color-by chain --background #000000");
    let ((ids, _), (pixels, _)) = (dir.array("id.npy"), dir.array("c.png"));
    for (id, label) in [(0.0, "A"), (1.0, "L"), (2.0, "(blank)"), (3.0, "L")] {
        let at = ids.iter().position(|found| *found == id).expect("an atom in view");
        let hex: String = pixels[3 * at..3 * at + 3].iter().map(|level| format!("{:02x}", *level as u8)).collect();
        let swatch = chains.split("<rect").find(|part| part.contains(&format!(">{label}<"))).expect("a swatch");
        assert!(swatch.contains(&format!("#{hex}")), "{label} is #{hex}: {swatch}");
    }
}

#[test]
fn a_resumed_picture_has_its_legend() {
    let dir = dir();
    let words = "atoms.xyz --size 20x20 -o a.png --color-by vx --legend l.svg --resume";
    dir.render(words);
    let legend = dir.get("l.svg");
    std::fs::remove_file(dir.path("l.svg")).expect("it was there");
    assert!(dir.render(words).err.contains("already there"));
    assert!(dir.get("l.svg") == legend);
}

#[test]
fn the_background_follows_the_options() {
    let dir = dir();
    let corner = |options: &str| {
        dir.render(&format!("native.toml -o c.npy {options}"));
        dir.array("c.npy").0[..3].to_vec()
    };
    assert_eq!(corner(""), [0.25, 0.5, 0.75]);
    assert_eq!(corner("--background 1,0,0.5"), [1.0, 0.0, 0.5]);
    assert_eq!(corner("--background #000000"), [0.0; 3]);
    assert_eq!(corner("--transparent"), [0.0; 3]);
    dir.render("native.toml --transparent -o t.png");
    let (pixels, shape) = dir.array("t.png");
    assert_eq!((shape, &pixels[..4]), (vec![20, 30, 4], &[0.0; 4][..]));
    assert!(pixels.chunks(4).any(|pixel| pixel[3] == 255.0), "the sphere hides what is behind it");
    dir.refused_render(2, "native.toml --transparent --background 1,0,0 -o a.png", &["--background", "--transparent"]);
}

/// Names of CSS, hexadecimal digits and arrays are the same colours, in options and in scene files.
#[test]
fn colours_have_names() {
    let dir = dir();
    let picture = |file: &str, options: &str| {
        dir.render(&format!("{file} -o c.npy {options}"));
        dir.get("c.npy")
    };
    let given = picture("native.toml", "--color #663399 --background #ff0000");
    assert!(given == picture("native.toml", "--color rebeccapurple --background Red"), "one provenance too");
    assert!(given == picture("native.toml", "--color #639 --background 1,0,0"));
    let array = ["color = [0.5, 0.25, 1]", "background = [0.25, 0.5, 0.75]"];
    let named = |color: &str, background: &str| {
        let text = NATIVE.replace(array[0], &format!("color = {color}"));
        dir.put("named.toml", text.replace(array[1], &format!("background = {background}")));
    };
    named("'rebeccapurple'", "'#f00'");
    assert!(given == picture("named.toml", ""));
    named("'rebecapurple'", "[0, 0, 0]");
    dir.refused_render(3, "named.toml -o a.png", &["named.toml:12", "sphere 0 color", "use rebeccapurple, "]);
    named("[0, 0, 0]", "'wite'");
    dir.refused_render(3, "named.toml -o a.png", &["named.toml:8", "image.background", "use white, "]);
}

/// A radius is the distance from a sphere's centre to its nearest point, which parallel rays show.
#[test]
fn radii_follow_the_options() {
    let dir = dir();
    let radii = |file: &str, options: &str| {
        dir.render(&format!("{file} --ortho --size 400x100 --aov id=id.npy --aov position=p.npy {options}"));
        let ((ids, _), (positions, _)) = (dir.array("id.npy"), dir.array("p.npy"));
        let mut front = vec![0.0f64; 3];
        for (id, p) in ids.iter().zip(positions.chunks(3)).filter(|(id, _)| **id >= 0.0) {
            front[*id as usize] = front[*id as usize].max(p[2]);
        }
        front
    };
    // Bondi 1964 and Cordero 2008 (hydrogen 1.20: Rowland and Taylor 1996), carbon, oxygen, hydrogen, in angstrom.
    let (vdw, covalent) = ([1.7, 1.52, 1.2], [0.76, 0.66, 0.31]);
    // A pixel is below 0.06 here: the centre of one is within 0.042 of the axis, where the smallest sphere is 0.003 lower.
    let close = |found: &[f64], expected: &[f64], options: &str| {
        let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 4e-3);
        assert!(near, "{options}: {found:?}, not {expected:?}");
    };
    for (options, expected) in [
        ("", vdw),
        ("--radii covalent", covalent),
        ("--radius-scale 0.5", vdw.map(|r| r * 0.5)),
        ("--radius 2", [2.0; 3]),
        ("--radius 2 --radius-scale 0.75", [1.5; 3]),
    ] {
        close(&radii("atoms.xyz", options), &expected, options);
    }
    close(&radii("native.toml", "--radius 0.5")[..1], &[0.5], "a scene's own spheres too");
    let err = dir.render("bare.csv --size 20x20 -o a.png").err;
    assert!(err.contains("2 particles have no radius") && err.contains("--radius"), "{err}");
    for bad in ["--radius 0", "--radius nan", "--radius-scale -1", "--radius-scale inf", "--radii bondi"] {
        dir.refused_render(2, &format!("atoms.xyz -o a.png {bad}"), &[bad.split(' ').next().expect("an option")]);
    }
}

/// The edges of a cell have one colour without lines and shade: between it and the background there is nothing darker.
#[test]
fn the_edges_of_a_cell_are_solid() {
    let cell = "Lattice=\"9 0 0 2 8 0 0 1 7\" Properties=species:S:1:pos:R:3";
    let dir = TestDir::new(&[("cell.xyz", &format!("1\n{cell}\nC 5 4 3\n"))]);
    for options in ["", "--samples 16", "--look figure", "--sun 1,2,3 --shadows", "--ortho 20"] {
        dir.render(&format!("cell.xyz --cell=0.12 --background white --size 200x160 --radius 0.01 {options} -o a.png"));
        let (levels, _) = dir.array("a.png");
        let darkest = levels.iter().copied().fold(255.0, f64::min);
        // 0.35 of linear light.
        assert_eq!(darkest, 160.0, "{options}");
        assert!(levels.iter().filter(|level| **level < 200.0).count() > 600, "{options}: the edges are there");
    }
}
