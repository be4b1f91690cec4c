//! The promise of framing and of sequences: a scene without a camera is framed completely, and each frame of a sequence
//! or of a spin equals the same frame rendered separately.

use crate::test_dir::{Output, TestDir};
use std::io::Write;

/// Spheres of several sizes, away from the origin.
const PILE: &str = "x,y,z,radius\n1,2,3,0.5\n4,2,3,1\n2,6,-1,0.25\n-3,1,8,0.7\n0,0,0,0.9\n5,-2,4,0.3\n";

const FRAMES: &str = "3\none\nC 0 0 0\nO 1.2 0 0\nH -1 0.3 0.2\n3\ntwo\nC 0 0 1\nO 1.9 0 0\nH -1 0.4 0.2\n3\nthree
C 0 0 2\nO 2.4 0 0\nH -1 0.5 0.2\n";

/// A scene whose sphere is out of view.
const NATIVE: &str = "[camera]\neye = [0, 0, 0]\nview = [0, 0, 1]\nup = [0, 1, 0]\nvfov = 40\n[image]\nsize = [90, 60]
[[sphere]]\ncenter = [0, 3, -9]\nradius = 1\n";

const CELL: &str = "2\nLattice=\"4 0 0 0 5 0 0 0 6\" Properties=species:S:1:pos:R:3\nC 0.5 0.5 0.5\nO 2 2 2\n";

fn dir() -> TestDir {
    TestDir::new(&[("pile.csv", PILE), ("frames.xyz", FRAMES), ("native.toml", NATIVE), ("cell.xyz", CELL)])
}

/// Empty rows or columns before the first hit, in shares of the side: left, right, top, bottom.
fn gaps(dir: &TestDir, name: &str) -> [(usize, usize); 4] {
    let (mask, shape) = dir.array(name);
    let (height, width) = (shape[0], shape[1]);
    let column = |x: &usize| (0..height).any(|y| mask[y * width + x] != 0.0);
    let row = |y: &usize| (0..width).any(|x| mask[y * width + x] != 0.0);
    let left = (0..width).find(column).unwrap_or_else(|| panic!("{name}: nothing was hit"));
    let right = (0..width).rev().find(column).map_or(0, |x| width - 1 - x);
    let top = (0..height).find(row).unwrap_or(0);
    let bottom = (0..height).rev().find(row).map_or(0, |y| height - 1 - y);
    [(left, width), (right, width), (top, height), (bottom, height)]
}

/// Framed silhouettes keep a margin of 2 % of the side, so the first pixel centre inside one is in the row at the
/// margin or in the next: the silhouettes are many pixels wide.
fn is_tight((gap, side): (usize, usize)) -> bool {
    let free = side as f64 * 0.02;
    gap as f64 >= free - 0.5 && (gap as f64) < free + 1.5
}

#[test]
fn a_scene_without_a_camera_is_framed_tightly() {
    let dir = dir();
    let views = [
        "",
        " --view 1,-2,0.5 --up 0,0,1",
        " --view -1,0,0",
        " --view 0,-2,0",
        " --view iso",
        " --vfov 100",
        " --at 9,9,9 --vfov 3",
    ];
    for (file, size) in [("pile.csv", "200x200"), ("pile.csv", "160x300"), ("frames.xyz", "310x150")] {
        for view in views {
            for lens in ["", " --ortho"].iter().take(if view.contains("vfov") { 1 } else { 2 }) {
                dir.render(&format!("{file} --size {size}{view}{lens} --aov mask=m.npy"));
                let gaps = gaps(&dir, "m.npy");
                let case = format!("{file} {size}{view}{lens}: {gaps:?}");
                assert!(gaps.iter().all(|(gap, side)| *gap as f64 >= *side as f64 * 0.02 - 0.5), "cut: {case}");
                let [left, right, top, bottom] = gaps.map(is_tight);
                // A point in the middle leaves room at the side that reaches less far from it.
                let is_aimed = view.contains("--at") && (left || right || top || bottom);
                assert!(left && right || top && bottom || is_aimed, "loose: {case}");
            }
        }
    }
}

#[test]
fn fit_frames_a_scene_along_its_cameras_direction() {
    let dir = dir();
    let past = dir.render("native.toml --json");
    assert!(past.err.contains("no ray hits the 1 sphere") && past.err.contains("use --fit"), "{}", past.err);
    dir.render("native.toml --fit --aov mask=m.npy --aov position=p.npy");
    assert!(gaps(&dir, "m.npy")[2..].iter().all(|gap| gap.0 >= 1), "one row in fifty is left free");
    let (positions, _) = dir.array("p.npy");
    let nearest = positions.chunks(3).filter(|p| p[2].is_finite()).map(|p| p[2]).fold(f64::INFINITY, f64::min);
    // Along +z, the nearest point of the sphere at z = -9 is at -10.
    assert!((nearest + 10.0).abs() < 1e-2, "{nearest}");
    dir.refused_render(2, "native.toml --fit --eye 0,0,5 -o a.png", &["--fit", "--eye"]);
    dir.refused_render(3, "native.toml --fit --at 0,0,0 -o a.png", &["camera.at", "same point"]);
}

#[test]
fn a_sphere_smaller_than_a_pixel_is_reported_with_its_size() {
    let dir = dir();
    dir.put("far.csv", "x,y,z,radius\n0,0,0,1\n1e6,0,0,1\n-1e6,0,0,1\n");
    for (words, mend) in [("", "--vfov"), (" --ortho", "--ortho")] {
        let report = dir.render(&format!("far.csv --size 64x64 --json{words}")).json();
        let warning = report["warnings"].as_array().expect("warnings").last().expect("one").to_string();
        let across: f64 =
            warning.split("is ").find_map(|t| t.split_once(" pixels across")?.0.parse().ok()).expect("pixels");
        // 2 of 2.08e6 in 64 pixels of a framed view; in perspective a little more or less.
        assert!((across / 6.1e-5 - 1.0).abs() < 0.05, "{warning}");
        assert!(warning.contains(mend) && warning.contains("--size") && !warning.contains("--fit"), "{warning}");
    }
}

#[test]
fn every_frame_of_a_spin_shows_the_whole_scene() {
    let dir = dir();
    let reports = dir.render("pile.csv --spin 5 --size 150x110 --aov mask=m%d.npy -o p%02d.png --json").json_lines();
    let numbers: Vec<_> = reports.iter().map(|report| report["number"].as_u64()).collect();
    assert_eq!(numbers, (1..=5).map(Some).collect::<Vec<_>>());
    let mut pictures: Vec<_> = (1..=5).map(|n| dir.get(&format!("p{n:02}.png"))).collect();
    for n in 1..=5 {
        let gaps = gaps(&dir, &format!("m{n}.npy"));
        assert!(gaps.iter().all(|(gap, side)| *gap as f64 >= *side as f64 * 0.02 - 0.5), "turn {n} is cut: {gaps:?}");
    }
    dir.render("pile.csv --spin 1 --size 150x110 --aov mask=one.npy -o one.png");
    assert!(dir.get("one.png") == pictures[0], "the first frame is not turned");
    pictures.sort();
    pictures.dedup();
    assert_eq!(pictures.len(), 5, "each from another side");
    // After half a turn parallel rays see the same outlines, mirrored.
    dir.render("pile.csv --spin 2 --ortho --size 151x110 --aov mask=h%d.npy");
    let ((front, shape), (back, _)) = (dir.array("h1.npy"), dir.array("h2.npy"));
    let mirrored: Vec<f64> = front.chunks(shape[1]).flat_map(|row| row.iter().rev().copied()).collect();
    let other = mirrored.iter().zip(&back).filter(|(a, b)| a != b).count();
    // Rounding of a direction moves outlines across a few pixel centres.
    assert!(other * 500 < mirrored.len(), "{other} of {} pixels", mirrored.len());
}

/// A render farm renders each frame as a separate task.
#[test]
fn a_frame_rendered_alone_is_that_of_the_sequence() {
    let dir = dir();
    for (options, name) in [("", "a"), (" --spin 12", "b"), (" --color-by x", "c")] {
        let options = format!("--size 60x40{options} --aov mask={name}%d.npy");
        let reports = dir.render(&format!("frames.xyz --frames 2-9 {options} -o {name}.%03d.png --json")).json_lines();
        let numbers: Vec<_> = reports.iter().map(|report| report["number"].as_u64()).collect();
        assert_eq!(numbers, [Some(2), Some(3)], "the file ends with 3");
        let together = dir.files();
        for n in [2, 3] {
            dir.render(&format!("frames.xyz --frames {n} {options} -o {name}.%03d.png"));
        }
        assert!(dir.files() == together, "{options}: frames rendered separately have other bytes");
        assert!(
            together.contains_key(&format!("{name}.002.png")) && !together.contains_key(&format!("{name}.001.png"))
        );
        assert!(together[&format!("{name}.002.png")] != together[&format!("{name}.003.png")], "{options}");
    }
}

#[test]
fn a_warning_of_several_frames_is_printed_once() {
    let dir = TestDir::new(&[("odd.xyz", "1\n\nXx 0 0 0\n1\n\nXx 1 0 0\n2\n\nXx 0 0 0\nC 9 0 0\n")]);
    let err = dir.render("odd.xyz --frames 1-3 --aov mask=m.%d.npy").err;
    let count = |words: &str| err.matches(words).count();
    // Frames 1 and 2 have the same warning, frame 3 another.
    assert_eq!((count("rendering on"), count("1 particle has no radius"), count("1 of 2 atoms")), (1, 1, 1), "{err}");
}

#[test]
fn a_sequence_needs_numbered_names_and_existing_frames() {
    let dir = dir();
    for many in ["frames.xyz --frames 1-2", "frames.xyz --frames 2-", "pile.csv --spin 3", "missing.xyz --spin 3"] {
        dir.refused_render(2, &format!("{many} -o a.png"), &["a.png", "a.%04d.png"]);
        dir.refused_render(2, &format!("{many} -o a%d.png --aov id=id.npy"), &["id.npy", "id.%04d.npy"]);
    }
    dir.refused_render(3, "frames.xyz --frames 7 -o a.png", &["the file has 3 frames", "--frames"]);
    dir.refused_render(3, "native.toml --frames 3 -o a.png", &["the file has 1 frame, none of them selected"]);
    for bad in ["0", "3-2", "x", "1:0"] {
        dir.refused_render(2, &format!("frames.xyz --frames {bad} -o a.png"), &["--frames", bad]);
    }
    dir.refused_render(2, "pile.csv --spin 0 -o a.png", &["--spin"]);
    dir.refused_render(2, "pile.csv --spin 2 --size 30x20 --crop 0,0,40,10 -o a%d.png", &["0,0,40,10"]);
    dir.refused_render(2, "pile.csv --tile 17/16 -o a.png", &["17"]);
    let out = dir.render("pile.csv --spin 2 --size 30x20 --crop 10,5,20,15 --aov id=i%d.npy").out;
    assert_eq!((dir.array("i2.npy").1, out.len()), (vec![10, 10], 0));
}

#[test]
fn copies_clips_and_cells_have_their_numbers_of_spheres() {
    let dir = dir();
    let count = |words: &str| dir.render(&format!("{words} --size 24x24 --json")).json()["spheres"].as_u64();
    assert_eq!(count("cell.xyz --copies 3,2,4"), Some(2 * 24));
    // Centres at x = 0.5, 2 and, a cell of 4 farther, 4.5, 6.
    assert_eq!(count("cell.xyz --copies 2,1,1 --clip 1,0,0,2"), Some(2));
    assert_eq!(count("cell.xyz --copies 2,1,1 --clip 1,0,0,5 --clip -1,0,0,-1"), Some(2));
    // Beads a radius apart, on 4 edges each of length 4, 5 and 6.
    assert_eq!(count("cell.xyz --cell=0.5"), Some(2 + 4 * (9 + 11 + 13)));
    assert_eq!(count("cell.xyz --cell=0.5 --copies 2,1,1 --clip 1,0,0,-9"), Some(4 * (17 + 11 + 13)));
    for words in ["frames.xyz --copies 2,2,2", "frames.xyz --cell", "native.toml --cell"] {
        dir.refused_render(2, &format!("{words} -o a.png"), &["needs a periodic cell", "Lattice"]);
    }
    for bad in ["--copies 0,1,1", "--copies 2,2", "--clip 0,0,0,1", "--clip 1,2,3", "--cell=0"] {
        dir.refused_render(2, &format!("cell.xyz {bad} -o a.png"), &[bad.split([' ', '=']).next().expect("an option")]);
    }
    dir.refused_render(5, "cell.xyz --copies 99999,99999,9 -o a.png", &["179996400018 spheres"]);
    // The earlier name does the same.
    let older = |option: &str| dir.render(&format!("cell.xyz {option} --size 24x24 --copies 2,1,1 -o a.npy")).err;
    for (name, earlier) in [("--cell", "--outline"), ("--cell=0.5", "--outline=0.5")] {
        let err = older(name);
        let expected = dir.get("a.npy");
        assert!(!err.contains("--cell"), "{err}");
        let err = older(earlier);
        assert_eq!(err.matches("--outline is now called --cell").count(), 1, "{err}");
        assert!(dir.get("a.npy") == expected);
    }
    dir.refused_render(2, "cell.xyz --cell --outline -o a.png", &["--cell", "--outline"]);
    let help = dir.good("render --help").text();
    assert!(!help.contains("--outline ") && !help.contains("--outline["), "{help}");
    let err = dir.render("cell.xyz --clip 1,0,0,-9 --size 8x8 -o a.png").err;
    assert!(err.contains("removes all 2 spheres") && err.contains("0 spheres"), "{err}");
}

#[test]
fn degenerate_scenes_are_framed_or_refused() {
    let dir = dir();
    dir.put("empty.xyz", "0\nnothing\n");
    dir.put("one.xyz", "1\none\nC 5 6 7\n");
    dir.put("same.xyz", "3\nsame\nC 1 1 1\nC 1 1 1\nC 1 1 1\n");
    dir.put("wide.xyz", "2\nfar apart\nC 1.7e308 0 0\nC -1.7e308 0 0\n");
    for lens in ["", " --ortho", " --spin 2"] {
        let options = format!("--size 100x80{lens} --aov mask=m%d.npy");
        let err = dir.render(&format!("empty.xyz {options}")).err;
        assert!(err.contains("0 spheres"), "{err}");
        for file in ["one.xyz", "same.xyz"] {
            dir.render(&format!("{file} {options}"));
            let [_, _, top, bottom] = gaps(&dir, "m1.npy").map(is_tight);
            assert!(top && bottom, "{file}{lens}");
        }
        dir.refused_render(
            3,
            &format!("wide.xyz{lens} -o a%d.png"),
            &["spheres lie between (-1.7e308,", "larger unit"],
        );
    }
    for bad in ["0", "nan", "-1", "inf"] {
        dir.refused_render(2, &format!("one.xyz --ortho {bad} -o a.png"), &["--ortho", bad, "positive"]);
    }
    dir.refused_render(2, "one.xyz --eye 0,0,9 --ortho -o a.png", &["--ortho", "height"]);
    dir.refused_render(3, "one.xyz --view 0,-1,0 --up 0,1,0 -o a.png", &["camera.up", "parallel"]);
}

#[test]
fn compressed_and_piped_scenes_give_the_same_frame() {
    let dir = dir();
    let render = |words: &str, input: &[u8]| {
        let Output { code, out, err } = dir.run_fed(&format!("render --backend cpu {words} --size 40x30 -o -"), input);
        assert_eq!(code, 0, "{words}: {err}");
        out
    };
    let plain = render("frames.xyz --frames 2", b"");
    assert!(plain.starts_with(b"\x89PNG"));
    let mut coder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    coder.write_all(FRAMES.as_bytes()).expect("memory");
    let gz = coder.finish().expect("memory");
    let mut coder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::default());
    coder.write_all(FRAMES.as_bytes()).expect("memory");
    let bz2 = coder.finish().expect("memory");
    dir.put("f.xyz.gz", &gz);
    dir.put("f.xyz.bz2", &bz2);
    // Neither name nor content distinguishes piped xyz from a table.
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
    assert!(both.ends_with(&plain), "frames follow each other on standard output");
}
