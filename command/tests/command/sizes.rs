//! The promise of sizes: an open height is the one that the framed spheres fill, paper has its pixels, and what is trimmed is the part
//! of the whole picture that shows something.

use crate::test_dir::TestDir;

/// Rows of spheres in a box of these sides, by a rule without a pattern.
fn box_of([x, y, z]: [f64; 3]) -> String {
    let mut state = 11_u32;
    let mut next = |side: f64| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24) * side
    };
    let rows = (0..400).map(|n| format!("{},{},{},0.1,{}\n", next(x), next(y), next(z), n % 3));
    format!("x,y,z,radius,kind\n{}", rows.collect::<String>())
}

/// Columns and rows of a PNG, from its header.
fn png(bytes: &[u8]) -> [u32; 2] {
    [16, 20].map(|at| u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four bytes")))
}

/// The ends of the columns and rows with an id, and the width and the height.
fn shown(ids: &[f64], shape: &[usize]) -> [[usize; 3]; 2] {
    let [height, width] = [shape[0], shape[1]];
    let columns: Vec<_> = (0..width).filter(|x| (0..height).any(|y| ids[y * width + x] >= 0.0)).collect();
    let rows: Vec<_> = (0..height).filter(|y| (0..width).any(|x| ids[y * width + x] >= 0.0)).collect();
    let ends = |of: &[usize]| [of[0], of[of.len() - 1] + 1];
    let ([x0, x1], [y0, y1]) = (ends(&columns), ends(&rows));
    [[x0, x1, width], [y0, y1, height]]
}

#[test]
fn an_open_height_is_filled() {
    let dir = TestDir::new(&[]);
    for (sides, cameras) in [
        ([9.0, 2.0, 1.0], ["--view front", "--view top --ortho", "--view 1,2,3"]),
        ([2.0, 7.0, 3.0], ["--view left", "--view auto", "--view front --ortho"]),
        ([3.0, 3.0, 3.0], ["--view iso --vfov 80", "--focus kind=1", "--view 3,1,2 --vfov 10"]),
    ] {
        dir.put("box.csv", box_of(sides));
        for camera in cameras {
            let words = format!("box.csv {camera} --size 300xauto --look plain --aov id=id.npy");
            dir.render(&words);
            let (ids, shape) = dir.array("id.npy");
            let margin = if camera.contains("focus") { 0.75 } else { 0.96 };
            for [first, last, side] in shown(&ids, &shape) {
                let share = (last - first) as f64 / side as f64;
                // A pixel at each end, a row of the height, and what spheres outside the focus take.
                let near = 2.0 / side as f64 + 1.0 / shape[0] as f64;
                let (least, most) = (margin - near, if camera.contains("focus") { 1.0 } else { margin + near });
                assert!((least..=most).contains(&share), "{sides:?} {camera}: {share} of {shape:?}");
            }
        }
    }
    // The legend is beside the spheres, so the picture is lower.
    let height = |words: &str| {
        dir.render(&format!("box.csv --view iso --color-by kind {words} -o p.png"));
        png(&dir.get("p.png"))
    };
    let [plain, with_legend] = [height("--size 600xauto"), height("--size 600xauto --legend-in")];
    assert!(plain[0] == 600 && with_legend[0] == 600 && with_legend[1] < plain[1] - 30, "{plain:?} {with_legend:?}");
}

#[test]
fn all_pictures_of_a_film_have_the_height_of_the_first() {
    let frame = |k: usize| format!("3\n\nC 0 0 0\nC {k} 0 0\nC 0 {} 0\n", 4 * k);
    let dir = TestDir::new(&[("film.xyz", &(1..4).map(frame).collect::<String>())]);
    dir.render("film.xyz --view front --frames 1-3 --size 90xauto -o p%d.png");
    let sizes = [1, 2, 3].map(|k| png(&dir.get(&format!("p{k}.png"))));
    assert!(sizes[0] == sizes[1] && sizes[1] == sizes[2] && sizes[0][1] > 90, "{sizes:?}");
    dir.render("film.xyz --view front --frames 1-3 --hold none --size 90xauto -o q%d.png");
    let sizes = [1, 3].map(|k| png(&dir.get(&format!("q{k}.png"))));
    assert!(sizes[0][1] < sizes[1][1], "{sizes:?}");
    // Nothing is left of the first frame.
    dir.render("film.xyz --view front --frames 1-2 --clip 0,-1,0,-6 --size 90xauto -o r%d.png");
    let sizes = [1, 2].map(|k| png(&dir.get(&format!("r{k}.png"))));
    assert!(sizes[0] == sizes[1] && sizes[0][1] != 512, "{sizes:?}");
}

#[test]
fn a_camera_of_a_file_keeps_its_shape() {
    let dir = TestDir::new(&[(
        "s.toml",
        "[camera]\neye = [0,0,9]\nat = [0,0,0]\nup = [0,1,0]\nvfov = 40.0\n[image]\nsize = [80, 60]\n[[sphere]]\ncenter = [0,0,0]\nradius = 1\n",
    )]);
    dir.render("s.toml --size 120xauto -o p.png");
    assert_eq!(png(&dir.get("p.png")), [120, 90]);
}

#[test]
fn paper_has_its_pixels() {
    let dir = TestDir::new(&[("box.csv", &box_of([3.0, 2.0, 1.0]))]);
    for (size, dpi, pixels, per_metre) in [
        ("20x10mm", "", [236, 118], 11811_u32),
        ("20x10mm", "--dpi 72", [57, 28], 2835),
        ("20mmx50", "--dpi 600", [472, 50], 23622),
    ] {
        dir.render(&format!("box.csv --size {size} {dpi} -o p.png"));
        let bytes = dir.get("p.png");
        let at = bytes.windows(4).position(|name| name == b"pHYs").expect("a resolution") + 4;
        assert_eq!((png(&bytes), &bytes[at..at + 4]), (pixels, &per_metre.to_be_bytes()[..]), "{size} {dpi}");
    }
    for (words, problem) in [
        ("--size 20", "expected WxH"),
        ("--size 20000mm", "1 to 10000 mm"),
        ("--size 10000mm --dpi 1000000", "393700787"),
        ("--size 90xauto --hold all --frames 1-", "--hold all"),
        ("--size 90xauto --stream", "an open height"),
        ("--size 90xauto --camera-from p.png", "--camera-from"),
    ] {
        dir.refused_render(2, &format!("box.csv {words} -o q%d.png"), &[problem]);
    }
}

#[test]
fn what_is_trimmed_is_the_part_that_shows_something() {
    let dir = TestDir::new(&[("box.csv", &box_of([5.0, 2.0, 1.0]))]);
    let camera = "box.csv --eye 1,1,20 --view 0,0,-1 --size 120x90 --look plain --samples 1";
    dir.render(&format!("{camera} --aov id=whole.npy --aov depth=whole.z.npy -o whole.png"));
    let out = dir.render(&format!("{camera} --trim --aov id=part.npy --aov depth=part.z.npy -o part.png"));
    let ((ids, shape), (part, sides)) = (dir.array("whole.npy"), dir.array("part.npy"));
    let [[x0, x1, _], [y0, y1, _]] = shown(&ids, &shape);
    assert_eq!(sides, [y1 - y0, x1 - x0]);
    assert!(out.err.contains(&format!("--trim keeps {}x{} of 120x90", x1 - x0, y1 - y0)), "{}", out.err);
    for name in ["npy", "z.npy"] {
        let (all, _) = dir.array(&format!("whole.{name}"));
        let cut: Vec<f64> = (y0..y1).flat_map(|y| all[y * 120 + x0..y * 120 + x1].to_vec()).collect();
        assert_eq!(dir.array(&format!("part.{name}")).0, cut, "{name}");
    }
    assert_eq!(part.len(), sides[0] * sides[1]);
    // What is drawn is shown too, and the files of one picture have one part.
    dir.render(&format!("{camera} --trim --label corner --aov id=part.npy -o part.png"));
    let sides = dir.array("part.npy").1;
    assert_eq!(png(&dir.get("part.png")), [sides[1] as u32, sides[0] as u32]);
    assert!(sides[0] > y1 - y0, "the label is above the spheres");
    // A picture is trimmed by its alpha, and one of nothing is whole.
    dir.render(&format!("{camera} --trim --transparent -o part.png"));
    assert_eq!(png(&dir.get("part.png")), [(x1 - x0) as u32, (y1 - y0) as u32]);
    let out = dir.render(&format!("{camera} --trim --select kind=9 -o nothing.png"));
    assert!(out.err.contains("nothing is shown"), "{}", out.err);
    assert_eq!(png(&dir.get("nothing.png")), [120, 90]);
    for (words, problem) in [
        ("--trim --crop 0,0,9,9 -o p.png", "--crop"),
        ("--trim --resume -o p.png", "--resume"),
        ("--trim --frames 1- -o p.mp4", "one size"),
    ] {
        dir.refused_render(2, &format!("{camera} {words}"), &[problem]);
    }
}

#[test]
fn an_open_height_without_framing_says_so() {
    let dir = TestDir::new(&[("box.csv", &box_of([3.0, 2.0, 1.0]))]);
    let out = dir.render("box.csv --eye 0,0,30 --at 0,0,0 --size 60xauto -o p.png");
    assert!(png(&dir.get("p.png")) == [60, 60] && out.err.contains("--trim cuts empty borders"), "{}", out.err);
}
