//! The promise of framing and of many pictures: what has no camera is seen whole, and each picture of a sequence or of a
//! spin is the one that would be rendered alone.

#[path = "common/desk.rs"]
mod desk;

use desk::{Desk, Said};
use std::io::Write;

/// Spheres of several sizes, away from the origin.
const PILE: &str = "x,y,z,radius\n1,2,3,0.5\n4,2,3,1\n2,6,-1,0.25\n-3,1,8,0.7\n0,0,0,0.9\n5,-2,4,0.3\n";

const FRAMES: &str = "3\none\nC 0 0 0\nO 1.2 0 0\nH -1 0.3 0.2\n3\ntwo\nC 0 0 1\nO 1.9 0 0\nH -1 0.4 0.2\n3\nthree
C 0 0 2\nO 2.4 0 0\nH -1 0.5 0.2\n";

/// Looks past its one sphere.
const NATIVE: &str = "[camera]\neye = [0, 0, 0]\nview = [0, 0, 1]\nup = [0, 1, 0]\nvfov = 40\n[image]\nsize = [90, 60]
[[sphere]]\ncenter = [0, 3, -9]\nradius = 1\n";

const CELL: &str = "2\nLattice=\"4 0 0 0 5 0 0 0 6\" Properties=species:S:1:pos:R:3\nC 0.5 0.5 0.5\nO 2 2 2\n";

/// The objects that were printed, one a line.
fn json(said: &Said) -> Vec<serde_json::Value> {
    let text = std::str::from_utf8(&said.out).expect("UTF-8");
    text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e} in {line}"))).collect()
}

fn desk() -> Desk {
    Desk::new(&[("pile.csv", PILE), ("frames.xyz", FRAMES), ("native.toml", NATIVE), ("cell.xyz", CELL)])
}

/// Empty rows or columns before the first hit, in shares of the side: left, right, top, bottom.
fn gaps(desk: &Desk, name: &str) -> [(usize, usize); 4] {
    let (mask, shape) = desk.array(name);
    let (height, width) = (shape[0], shape[1]);
    let column = |x: &usize| (0..height).any(|y| mask[y * width + x] != 0.0);
    let row = |y: &usize| (0..width).any(|x| mask[y * width + x] != 0.0);
    let left = (0..width).find(column).unwrap_or_else(|| panic!("{name}: nothing was hit"));
    let right = (0..width).rev().find(column).map_or(0, |x| width - 1 - x);
    let top = (0..height).find(row).unwrap_or(0);
    let bottom = (0..height).rev().find(row).map_or(0, |y| height - 1 - y);
    [(left, width), (right, width), (top, height), (bottom, height)]
}

/// The framed silhouettes touch 2 % of the side before the border, so that the first pixel centre within one is in the
/// row there or in the next: the silhouettes are many pixels wide.
fn is_tight((gap, side): (usize, usize)) -> bool {
    let free = side as f64 * 0.02;
    gap as f64 >= free - 0.5 && (gap as f64) < free + 1.5
}

#[test]
fn what_has_no_camera_is_seen_whole_and_as_near_as_that_allows() {
    let desk = desk();
    let views =
        ["", " --view 1,-2,0.5 --up 0,0,1", " --view -1,0,0", " --view 0,-2,0", " --vfov 100", " --at 9,9,9 --vfov 3"];
    for (file, size) in [("pile.csv", "200x200"), ("pile.csv", "160x300"), ("frames.xyz", "310x150")] {
        for view in views {
            for lens in ["", " --ortho"].iter().take(if view.contains("vfov") { 1 } else { 2 }) {
                desk.render(&format!("{file} --size {size}{view}{lens} --aov mask=m.npy"));
                let gaps = gaps(&desk, "m.npy");
                let case = format!("{file} {size}{view}{lens}: {gaps:?}");
                assert!(gaps.iter().all(|(gap, side)| *gap as f64 >= *side as f64 * 0.02 - 0.5), "cut: {case}");
                let [left, right, top, bottom] = gaps.map(is_tight);
                assert!(left && right || top && bottom, "loose: {case}");
            }
        }
    }
}

#[test]
fn fit_frames_what_has_a_camera_and_keeps_its_direction() {
    let desk = desk();
    let past = desk.render("native.toml --json");
    assert!(past.err.contains("no ray hits the 1 sphere") && past.err.contains("--fit frames them"), "{}", past.err);
    desk.render("native.toml --fit --aov mask=m.npy --aov position=p.npy");
    assert!(gaps(&desk, "m.npy")[2..].iter().all(|gap| gap.0 >= 1), "one row in fifty is left free");
    let (positions, _) = desk.array("p.npy");
    let nearest = positions.chunks(3).filter(|p| p[2].is_finite()).map(|p| p[2]).fold(f64::INFINITY, f64::min);
    // Seen along +z, the sphere at z = -9 shows its side at -10.
    assert!((nearest + 10.0).abs() < 1e-2, "{nearest}");
    desk.refused(2, "native.toml --fit --eye 0,0,5 -o a.png", &["--fit", "--eye"]);
    desk.refused(3, "native.toml --fit --at 0,0,0 -o a.png", &["camera.at", "same point"]);
}

#[test]
fn what_is_too_small_for_a_pixel_is_told_with_its_size() {
    let desk = desk();
    desk.put("far.csv", "x,y,z,radius\n0,0,0,1\n1e6,0,0,1\n-1e6,0,0,1\n");
    for (words, mend) in [("", "--vfov"), (" --ortho", "--ortho")] {
        let said = desk.render(&format!("far.csv --size 64x64 --json{words}"));
        let warning = json(&said)[0]["warnings"].as_array().expect("warnings").last().expect("one").to_string();
        let across: f64 =
            warning.split("is ").find_map(|t| t.split_once(" pixels across")?.0.parse().ok()).expect("pixels");
        // Two across 2.08e6 in 64 pixels of a framed view; perspective sees the middle one a little smaller or larger.
        assert!((across / 6.1e-5 - 1.0).abs() < 0.05, "{warning}");
        assert!(warning.contains(mend) && warning.contains("--size") && !warning.contains("--fit"), "{warning}");
    }
}

#[test]
fn a_spin_shows_all_of_it_from_every_side() {
    let desk = desk();
    let said = desk.render("pile.csv --spin 5 --size 150x110 --aov mask=m%d.npy -o p%02d.png --json");
    let numbers: Vec<_> = json(&said).iter().map(|report| report["number"].as_u64()).collect();
    assert_eq!(numbers, (1..=5).map(Some).collect::<Vec<_>>());
    let mut pictures: Vec<_> = (1..=5).map(|n| desk.get(&format!("p{n:02}.png"))).collect();
    for n in 1..=5 {
        let gaps = gaps(&desk, &format!("m{n}.npy"));
        assert!(gaps.iter().all(|(gap, side)| *gap as f64 >= *side as f64 * 0.02 - 0.5), "turn {n} is cut: {gaps:?}");
    }
    desk.render("pile.csv --spin 1 --size 150x110 --aov mask=one.npy -o one.png");
    assert!(desk.get("one.png") == pictures[0], "the first is the view that is not turned");
    pictures.sort();
    pictures.dedup();
    assert_eq!(pictures.len(), 5, "each from another side");
    // Half a turn around the middle sees the other side: the same outlines, mirrored, where rays are parallel.
    desk.render("pile.csv --spin 2 --ortho --size 151x110 --aov mask=h%d.npy");
    let ((front, shape), (back, _)) = (desk.array("h1.npy"), desk.array("h2.npy"));
    let mirrored: Vec<f64> = front.chunks(shape[1]).flat_map(|row| row.iter().rev().copied()).collect();
    let other = mirrored.iter().zip(&back).filter(|(a, b)| a != b).count();
    // A rounded direction moves outlines across a centre here and there.
    assert!(other * 500 < mirrored.len(), "{other} of {} pixels", mirrored.len());
}

/// As a farm does it: a task renders one frame, and knows nothing of the others.
#[test]
fn a_frame_alone_is_the_frame_among_the_others() {
    let desk = desk();
    for (options, name) in [("", "a"), (" --spin 12", "b"), (" --color-by x", "c")] {
        let options = format!("--size 60x40{options} --aov mask={name}%d.npy");
        let said = desk.render(&format!("frames.xyz --frames 2-9 {options} -o {name}.%03d.png --json"));
        let numbers: Vec<_> = json(&said).iter().map(|report| report["number"].as_u64()).collect();
        assert_eq!(numbers, [Some(2), Some(3)], "the file ends with 3");
        let together = desk.files();
        for n in [2, 3] {
            desk.render(&format!("frames.xyz --frames {n} {options} -o {name}.%03d.png"));
        }
        assert!(desk.files() == together, "{options}: other bytes alone");
        assert!(
            together.contains_key(&format!("{name}.002.png")) && !together.contains_key(&format!("{name}.001.png"))
        );
        assert!(together[&format!("{name}.002.png")] != together[&format!("{name}.003.png")], "{options}");
    }
}

#[test]
fn what_every_picture_would_say_is_said_once() {
    let desk = Desk::new(&[("odd.xyz", "1\n\nXx 0 0 0\n1\n\nXx 1 0 0\n2\n\nXx 0 0 0\nC 9 0 0\n")]);
    let said = desk.render("odd.xyz --frames 1-3 --aov mask=m.%d.npy");
    let count = |words: &str| said.err.matches(words).count();
    // The same sentence of frames 1 and 2, and another of frame 3.
    assert_eq!(
        (count("rendering on"), count("1 particle has no radius"), count("1 of 2 atoms")),
        (1, 1, 1),
        "{}",
        said.err
    );
}

#[test]
fn several_pictures_need_several_names_and_frames_that_are_there() {
    let desk = desk();
    for many in ["frames.xyz --frames 1-2", "frames.xyz --frames 2-", "pile.csv --spin 3", "missing.xyz --spin 3"] {
        desk.refused(2, &format!("{many} -o a.png"), &["a.png", "a.%04d.png"]);
        desk.refused(2, &format!("{many} -o a%d.png --aov id=id.npy"), &["id.npy", "id.%04d.npy"]);
    }
    desk.refused(3, "frames.xyz --frames 7 -o a.png", &["the 3 that the file has", "--frames"]);
    desk.refused(3, "native.toml --frames 3 -o a.png", &["the 1 that the file has"]);
    for bad in ["0", "3-2", "x", "1:0"] {
        desk.refused(2, &format!("frames.xyz --frames {bad} -o a.png"), &["--frames", bad]);
    }
    desk.refused(2, "pile.csv --spin 0 -o a.png", &["--spin"]);
    desk.refused(2, "pile.csv --spin 2 --size 30x20 --crop 0,0,40,10 -o a%d.png", &["0,0,40,10"]);
    desk.refused(2, "pile.csv --tile 17/16 -o a.png", &["17"]);
    let said = desk.render("pile.csv --spin 2 --size 30x20 --crop 10,5,20,15 --aov id=i%d.npy");
    assert_eq!((desk.array("i2.npy").1, said.out.len()), (vec![10, 10], 0));
}

#[test]
fn copies_clips_and_outlines_are_counted() {
    let desk = desk();
    let count = |words: &str| json(&desk.render(&format!("{words} --size 24x24 --json")))[0]["spheres"].as_u64();
    assert_eq!(count("cell.xyz --copies 3,2,4"), Some(2 * 24));
    // Centres at x = 0.5, 2 and, a cell of 4 farther, 4.5, 6.
    assert_eq!(count("cell.xyz --copies 2,1,1 --clip 1,0,0,2"), Some(2));
    assert_eq!(count("cell.xyz --copies 2,1,1 --clip 1,0,0,5 --clip -1,0,0,-1"), Some(2));
    // Beads a radius apart: of each of 4 edges of 4, 5 and 6 so many steps and one more.
    assert_eq!(count("cell.xyz --outline=0.5"), Some(2 + 4 * (9 + 11 + 13)));
    assert_eq!(count("cell.xyz --outline=0.5 --copies 2,1,1 --clip 1,0,0,-9"), Some(4 * (17 + 11 + 13)));
    for words in ["frames.xyz --copies 2,2,2", "frames.xyz --outline", "native.toml --outline"] {
        desk.refused(2, &format!("{words} -o a.png"), &["no periodic cell", "Lattice"]);
    }
    for bad in ["--copies 0,1,1", "--copies 2,2", "--clip 0,0,0,1", "--clip 1,2,3", "--outline=0"] {
        desk.refused(2, &format!("cell.xyz {bad} -o a.png"), &[bad.split([' ', '=']).next().expect("an option")]);
    }
    desk.refused(5, "cell.xyz --copies 99999,99999,9 -o a.png", &["179996400018 spheres"]);
    let said = desk.render("cell.xyz --clip 1,0,0,-9 --size 8x8 -o a.png");
    assert!(said.err.contains("every one of the 2 spheres") && said.err.contains("0 spheres"), "{}", said.err);
}

#[test]
fn odd_scenes_are_framed_or_refused_in_words() {
    let desk = desk();
    desk.put("empty.xyz", "0\nnothing\n");
    desk.put("one.xyz", "1\none\nC 5 6 7\n");
    desk.put("same.xyz", "3\nsame\nC 1 1 1\nC 1 1 1\nC 1 1 1\n");
    desk.put("wide.xyz", "2\nfar apart\nC 1.7e308 0 0\nC -1.7e308 0 0\n");
    for lens in ["", " --ortho", " --spin 2"] {
        let options = format!("--size 100x80{lens} --aov mask=m%d.npy");
        let said = desk.render(&format!("empty.xyz {options}"));
        assert!(said.err.contains("0 spheres"), "{}", said.err);
        for file in ["one.xyz", "same.xyz"] {
            desk.render(&format!("{file} {options}"));
            let [_, _, top, bottom] = gaps(&desk, "m1.npy").map(is_tight);
            assert!(top && bottom, "{file}{lens}");
        }
        desk.refused(3, &format!("wide.xyz{lens} -o a%d.png"), &["spheres lie between (-1.7e308,", "larger unit"]);
    }
    for bad in ["0", "nan", "-1", "inf"] {
        desk.refused(2, &format!("one.xyz --ortho {bad} -o a.png"), &["--ortho", bad, "positive"]);
    }
    desk.refused(2, "one.xyz --eye 0,0,9 --ortho -o a.png", &["--ortho", "height"]);
    desk.refused(3, "one.xyz --view 0,-1,0 --up 0,1,0 -o a.png", &["camera.up", "parallel"]);
}

#[test]
fn compressed_and_piped_is_the_same() {
    let desk = desk();
    let render = |words: &str, input: &[u8]| {
        let said = desk.run_with(&format!("render --backend cpu {words} --size 40x30 -o -"), &[], input);
        assert_eq!(said.code, 0, "{words}: {}", said.err);
        said.out
    };
    let plain = render("frames.xyz --frames 2", b"");
    assert!(plain.starts_with(b"\x89PNG"));
    let mut coder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    coder.write_all(FRAMES.as_bytes()).expect("memory");
    let gz = coder.finish().expect("memory");
    let mut coder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::default());
    coder.write_all(FRAMES.as_bytes()).expect("memory");
    let bz2 = coder.finish().expect("memory");
    desk.put("f.xyz.gz", &gz);
    desk.put("f.xyz.bz2", &bz2);
    // Neither name nor content tells an xyz that is piped from a table.
    for (words, input) in [
        ("f.xyz.gz --frames 2", &b""[..]),
        ("f.xyz.bz2 --frames 2", b""),
        ("- --format xyz --frames 2", FRAMES.as_bytes()),
        ("- --format xyz --frames 2", &gz),
        ("- --format xyz --frames 2", &bz2),
    ] {
        assert!(render(words, input) == plain, "{words}");
    }
    let both = render("frames.xyz --frames 1-2", b"");
    assert!(both.ends_with(&plain), "pictures follow each other on standard output");
}
