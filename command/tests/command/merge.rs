//! The promise of `merge`: the merged file equals the file of the full frame byte for byte, and tiles that do not belong
//! together are refused with their names.

use crate::random_frames::{cut, frame, origin};
use crate::rng::Rng;
use crate::test_dir::{Output, TestDir};
use halfline::frame::{Aov, Frame};
use halfline::settings::Settings;
use halfline::window::Window;
use halfline_files::write::file::Target;
use halfline_files::write::format::{Bits, FileFormat, FormatOptions};

/// Cuts a window into random parts.
fn parts(rng: &mut Rng, window: Window) -> Vec<Window> {
    let [wide, high] = [window.width() > 1, window.height() > 1];
    if rng.below(4) == 0 || !wide && !high {
        return vec![window];
    }
    let [mut a, mut b] = [window; 2];
    if wide && (!high || rng.below(2) == 0) {
        a.x1 = rng.within(window.x0 + 1, window.x1);
        b.x0 = a.x1;
    } else {
        a.y1 = rng.within(window.y0 + 1, window.y1);
        b.y0 = a.y1;
    }
    [parts(rng, a), parts(rng, b)].concat()
}

/// A folder with tiles in it.
struct Tiles {
    dir: TestDir,
    names: Vec<String>,
}

impl Tiles {
    fn new() -> Self {
        Self { dir: TestDir::new(&[]), names: Vec::new() }
    }

    /// Writes a tile of a rendering of `scene`.
    fn put(&mut self, name: &str, part: &Frame, aovs: &[Aov], style: FormatOptions, scene: &str) {
        let settings = Settings::default();
        let target = Target::new(aovs, &self.dir.path(name), style).expect("a target");
        target.write(part, &origin(part, &settings, scene)).expect("written");
        self.names.push(name.into());
    }

    fn merge(&self, output: &str) -> Output {
        self.dir.run(&self.command(output))
    }

    fn command(&self, output: &str) -> String {
        format!("merge {} -o {output}", self.names.join(" "))
    }

    fn refused(&self, output: &str, code: i32, words: &[&str]) {
        self.dir.refused(code, &self.command(output), words);
    }
}

#[test]
fn merged_tiles_are_the_full_frame_byte_for_byte() {
    let mut rng = Rng::new(1);
    let sixteen = FormatOptions { bits: Bits::Sixteen, transparent: true, ..FormatOptions::default() };
    let several = [Aov::Color, Aov::Depth, Aov::Normal, Aov::Id];
    let light_buffers = [Aov::Color, Aov::Shadow, Aov::Occlusion];
    let cases: [(FileFormat, &[Aov], FormatOptions); 15] = [
        (FileFormat::Png, &[Aov::Color], FormatOptions::default()),
        (FileFormat::Png, &[Aov::Color], sixteen),
        (FileFormat::Png, &[Aov::Depth], FormatOptions::default()),
        (FileFormat::Png, &[Aov::Mask], FormatOptions::default()),
        (FileFormat::Exr, &several, sixteen),
        (FileFormat::Npy, &[Aov::Position], FormatOptions::default()),
        (FileFormat::Npz, &several, FormatOptions::default()),
        (FileFormat::Pfm, &[Aov::Normal], FormatOptions::default()),
        (FileFormat::Pfm, &[Aov::Distance], FormatOptions::default()),
        (FileFormat::Npy, &[Aov::Shadow], FormatOptions::default()),
        (FileFormat::Npz, &light_buffers, FormatOptions::default()),
        (FileFormat::Exr, &light_buffers, FormatOptions::default()),
        (FileFormat::Png, &[Aov::Occlusion], FormatOptions::default()),
        (FileFormat::Png, &[Aov::Occlusion], sixteen),
        (FileFormat::Pfm, &[Aov::Occlusion], FormatOptions::default()),
    ];
    for (n, (format, aovs, style)) in cases.into_iter().enumerate() {
        let mut tiles = Tiles::new();
        let full = [rng.within(5, 60), rng.within(5, 40)];
        let mut windows = parts(&mut rng, Window::full(full[0], full[1]));
        if windows.len() == 1 {
            windows = (1..=6).map(|k| Window::tile(k, 6, full[0], full[1]).expect("a tile")).collect();
        }
        for (k, window) in windows.into_iter().rev().enumerate() {
            tiles.put(&format!("{k}{}", format.ending()), &cut(&frame(n as u64, full), window), aovs, style, "scene");
        }
        let merged = format!("merged{}", format.ending());
        let output = tiles.merge(&merged);
        assert_eq!(output.code, 0, "{}", output.err);
        let whole = format!("whole{}", format.ending());
        tiles.put(&whole, &frame(n as u64, full), aovs, style, "scene");
        let same = tiles.dir.get(&merged) == tiles.dir.get(&whole);
        assert!(same, "{aovs:?} as {format:?} of {full:?} from {} tiles", tiles.names.len() - 1);
    }
}

const FULL: [u32; 2] = [30, 20];

/// Tiles 1 to 6 of 6 except those in `without`.
fn tiles(without: &[u32]) -> Tiles {
    let mut tiles = Tiles::new();
    for k in (1..=6).filter(|k| !without.contains(k)) {
        let window = Window::tile(k, 6, FULL[0], FULL[1]).expect("a tile");
        tiles.put(&format!("{k}.png"), &cut(&frame(1, FULL), window), &[Aov::Color], FormatOptions::default(), "scene");
    }
    tiles
}

fn tile(k: u32) -> Window {
    Window::tile(k, 6, FULL[0], FULL[1]).expect("a tile")
}

#[test]
fn missing_parts_are_named_as_rectangles() {
    tiles(&[2]).refused(
        "full.png",
        3,
        &["5 tiles", &format!("no tile covers {} of 30 x 20 pixels (100 pixels)", tile(2))],
    );
    let neighbour = Window { x1: tile(2).x1, ..tile(1) };
    tiles(&[1, 2]).refused("full.png", 3, &[&format!("no tile covers {neighbour} of"), "200 pixels"]);
    tiles(&[1, 6]).refused("full.png", 3, &[&format!("{} and {}", tile(1), tile(6)), "--crop"]);
    assert_eq!(tiles(&[]).merge("full.png").code, 0);
}

#[test]
fn a_tile_of_another_frame_is_named_with_the_difference() {
    let plain = FormatOptions::default();
    let planted = |full: [u32; 2], style: FormatOptions, scene: &str, words: &[&str]| {
        let mut tiles = tiles(&[1]);
        tiles.put("odd.png", &cut(&frame(1, full), tile(1)), &[Aov::Color], style, scene);
        // In the first and in the last place.
        for _ in 0..2 {
            tiles.refused("full.png", 3, &[&["halfline: odd.png: "], words].concat());
            tiles.names.rotate_right(1);
        }
    };
    planted(FULL, plain, "another", &["halfline:scene", "\"another\"", "\"scene\""]);
    planted([30, 21], plain, "scene", &["halfline:frame", "30x21"]);
    planted(FULL, FormatOptions { bits: Bits::Sixteen, ..plain }, "scene", &["halfline:bits"]);
    planted(FULL, FormatOptions { transparent: true, ..plain }, "scene", &["halfline:buffers", "color,alpha"]);
    let mut tiles = tiles(&[1]);
    tiles.put("odd.npy", &cut(&frame(1, FULL), tile(1)), &[Aov::Color], plain, "scene");
    tiles.refused("full.png", 3, &["odd.npy", ".npy among tiles in .png"]);
}

#[test]
fn a_tile_of_another_adapter_or_program_is_refused() {
    for field in ["adapter", "driver", "Software", "accuracy"] {
        let mut tiles = tiles(&[4]);
        let mut part = cut(&frame(1, FULL), tile(4));
        match field {
            "adapter" => part.report.adapter = "another".into(),
            "driver" => part.report.driver = "another".into(),
            "Software" => part.report.halfline = "9.9.9",
            _ => part.report.accuracy = "exact",
        }
        tiles.put("odd.png", &part, &[Aov::Color], FormatOptions::default(), "scene");
        tiles.refused("full.png", 3, &["odd.png", field]);
    }
}

#[test]
fn overlapping_tiles_are_both_named() {
    let mut tiles = tiles(&[]);
    let over = Window { x0: 4, y0: 4, x1: 6, y1: 6 };
    tiles.put("over.png", &cut(&frame(1, FULL), over), &[Aov::Color], FormatOptions::default(), "scene");
    tiles.refused("full.png", 3, &["over.png", "4,4,6,6", "1.png"]);
    tiles.names.pop();
    tiles.names.push("3.png".into());
    tiles.refused("full.png", 3, &["3.png", &tile(3).to_string()]);
}

#[test]
fn truncated_tiles_and_tiles_without_provenance_are_named() {
    let tiles = tiles(&[]);
    let whole = tiles.dir.get("5.png");
    tiles.dir.put("5.png", &whole[..whole.len() - 20]);
    tiles.refused("full.png", 3, &["5.png", "the PNG file is damaged"]);
    image::RgbImage::new(10, 10).save(tiles.dir.path("5.png")).expect("written");
    tiles.refused("full.png", 3, &["5.png", "no provenance"]);
    tiles.dir.remove("5.png");
    tiles.refused("full.png", 8, &["cannot read 5.png"]);
}

#[test]
fn the_output_has_the_format_of_the_tiles() {
    let tiles = tiles(&[]);
    tiles.refused("full.exr", 2, &["full.exr", ".png"]);
    tiles.refused("nowhere/full.png", 8, &["nowhere/full.png"]);
}
