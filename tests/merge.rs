//! The promise of `merge`: the merged file is byte for byte the full frame's, and what does not belong together is refused
//! and named.

#[path = "common/frames.rs"]
#[expect(dead_code, reason = "the helpers of tests that read what they write")]
mod frames;

use frames::{Random, cut, frame, origin};
use halfline::frame::file::Target;
use halfline::frame::format::{Bits, Format, Style};
use halfline::frame::{Aov, Frame};
use halfline::settings::Settings;
use halfline::window::Window;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

/// Cuts a window into random parts.
fn parts(random: &mut Random, window: Window) -> Vec<Window> {
    let [wide, high] = [window.width() > 1, window.height() > 1];
    if random.next().is_multiple_of(4) || !wide && !high {
        return vec![window];
    }
    let [mut a, mut b] = [window; 2];
    if wide && (!high || random.next().is_multiple_of(2)) {
        a.x1 = random.within(window.x0 + 1, window.x1);
        b.x0 = a.x1;
    } else {
        a.y1 = random.within(window.y0 + 1, window.y1);
        b.y0 = a.y1;
    }
    [parts(random, a), parts(random, b)].concat()
}

/// A folder with tiles in it.
struct Desk {
    folder: tempfile::TempDir,
    names: Vec<String>,
}

impl Desk {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a folder"), names: Vec::new() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Puts a tile of a rendering of `scene` there.
    fn put(&mut self, name: &str, part: &Frame, aovs: &[Aov], style: Style, scene: &str) {
        let settings = Settings::default();
        let target = Target::new(aovs, &self.path(name), style).expect("a target");
        target.write(part, &origin(part, &settings, scene)).expect("written");
        self.names.push(name.into());
    }

    /// Exit code and standard error.
    fn merge(&self, output: &str) -> (i32, String) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halfline"));
        command.arg("merge").args(&self.names).args(["-o", output]).current_dir(self.folder.path());
        let output = command.output().expect("halfline runs");
        (output.status.code().expect("a code"), String::from_utf8_lossy(&output.stderr).into_owned())
    }

    /// Merging must fail with `code`, say all of `words` and write nothing.
    fn refused(&self, output: &str, code: i32, words: &[&str]) {
        let names = || fs::read_dir(self.folder.path()).expect("a folder").count();
        let before = names();
        let (found, err) = self.merge(output);
        assert_eq!((found, err.lines().count()), (code, 1), "{err}");
        assert!(words.iter().all(|word| err.contains(word)), "{words:?} in {err}");
        assert_eq!(names(), before, "something was left");
    }
}

#[test]
fn tiles_are_the_full_frame_byte_for_byte() {
    let mut random = Random(1);
    let sixteen = Style { bits: Bits::Sixteen, transparent: true, ..Style::default() };
    let several = [Aov::Color, Aov::Depth, Aov::Normal, Aov::Id];
    let cases: [(Format, &[Aov], Style); 9] = [
        (Format::Png, &[Aov::Color], Style::default()),
        (Format::Png, &[Aov::Color], sixteen),
        (Format::Png, &[Aov::Depth], Style::default()),
        (Format::Png, &[Aov::Mask], Style::default()),
        (Format::Exr, &several, sixteen),
        (Format::Npy, &[Aov::Position], Style::default()),
        (Format::Npz, &several, Style::default()),
        (Format::Pfm, &[Aov::Normal], Style::default()),
        (Format::Pfm, &[Aov::Distance], Style::default()),
    ];
    for (n, (format, aovs, style)) in cases.into_iter().enumerate() {
        let mut desk = Desk::new();
        let full = [random.within(5, 60), random.within(5, 40)];
        let mut windows = parts(&mut random, Window::full(full[0], full[1]));
        if windows.len() == 1 {
            windows = (1..=6).map(|k| Window::tile(k, 6, full[0], full[1]).expect("a tile")).collect();
        }
        for (k, window) in windows.into_iter().rev().enumerate() {
            desk.put(&format!("{k}{}", format.ending()), &cut(&frame(n as u64, full), window), aovs, style, "scene");
        }
        let merged = format!("merged{}", format.ending());
        let (code, err) = desk.merge(&merged);
        assert_eq!(code, 0, "{err}");
        let whole = format!("whole{}", format.ending());
        desk.put(&whole, &frame(n as u64, full), aovs, style, "scene");
        let same = fs::read(desk.path(&merged)).expect("there") == fs::read(desk.path(&whole)).expect("there");
        assert!(same, "{aovs:?} as {format:?} of {full:?} from {} tiles", desk.names.len() - 1);
    }
}

const FULL: [u32; 2] = [30, 20];

/// Tiles 1 to 6 of 6 but for those in `without`.
fn desk(without: &[u32]) -> Desk {
    let mut desk = Desk::new();
    for k in (1..=6).filter(|k| !without.contains(k)) {
        let window = Window::tile(k, 6, FULL[0], FULL[1]).expect("a tile");
        desk.put(&format!("{k}.png"), &cut(&frame(1, FULL), window), &[Aov::Color], Style::default(), "scene");
    }
    desk
}

fn tile(k: u32) -> Window {
    Window::tile(k, 6, FULL[0], FULL[1]).expect("a tile")
}

#[test]
fn missing_parts_are_named_as_rectangles() {
    desk(&[2]).refused("full.png", 3, &["5 tiles", &format!("none holds {} of 30 x 20 pixels (100 pixels)", tile(2))]);
    let beside = Window { x1: tile(2).x1, ..tile(1) };
    desk(&[1, 2]).refused("full.png", 3, &[&format!("none holds {beside} of"), "200 pixels"]);
    desk(&[1, 6]).refused("full.png", 3, &[&format!("{} and {}", tile(1), tile(6)), "--crop"]);
    assert_eq!(desk(&[]).merge("full.png").0, 0);
}

#[test]
fn foreign_tiles_are_named_with_what_differs() {
    let plain = Style::default();
    let planted = |full: [u32; 2], style: Style, scene: &str, words: &[&str]| {
        let mut desk = desk(&[1]);
        desk.put("odd.png", &cut(&frame(1, full), tile(1)), &[Aov::Color], style, scene);
        // Named first or last, the odd one is the one.
        for _ in 0..2 {
            desk.refused("full.png", 3, &[&["halfline: odd.png: "], words].concat());
            desk.names.rotate_right(1);
        }
    };
    planted(FULL, plain, "another", &["halfline:scene", "\"another\"", "\"scene\""]);
    planted([30, 21], plain, "scene", &["halfline:frame", "30x21"]);
    planted(FULL, Style { bits: Bits::Sixteen, ..plain }, "scene", &["halfline:bits"]);
    planted(FULL, Style { transparent: true, ..plain }, "scene", &["halfline:buffers", "color,alpha"]);
    let mut desk = desk(&[1]);
    desk.put("odd.npy", &cut(&frame(1, FULL), tile(1)), &[Aov::Color], plain, "scene");
    desk.refused("full.png", 3, &["odd.npy", ".npy among tiles in .png"]);
}

#[test]
fn another_adapter_or_program_is_foreign() {
    for field in ["adapter", "driver", "Software", "accuracy"] {
        let mut desk = desk(&[4]);
        let mut part = cut(&frame(1, FULL), tile(4));
        match field {
            "adapter" => part.report.adapter = "another".into(),
            "driver" => part.report.driver = "another".into(),
            "Software" => part.report.halfline = "9.9.9",
            _ => part.report.accuracy = "exact",
        }
        desk.put("odd.png", &part, &[Aov::Color], Style::default(), "scene");
        desk.refused("full.png", 3, &["odd.png", field]);
    }
}

#[test]
fn overlapping_tiles_are_both_named() {
    let mut desk = desk(&[]);
    let over = Window { x0: 4, y0: 4, x1: 6, y1: 6 };
    desk.put("over.png", &cut(&frame(1, FULL), over), &[Aov::Color], Style::default(), "scene");
    desk.refused("full.png", 3, &["over.png", "4,4,6,6", "1.png"]);
    desk.names.pop();
    desk.names.push("3.png".into());
    desk.refused("full.png", 3, &["3.png", &tile(3).to_string()]);
}

#[test]
fn truncated_and_nameless_tiles_are_named() {
    let desk = desk(&[]);
    let whole = fs::read(desk.path("5.png")).expect("there");
    fs::write(desk.path("5.png"), &whole[..whole.len() - 20]).expect("written");
    desk.refused("full.png", 3, &["5.png", "not a whole PNG"]);
    image::RgbImage::new(10, 10).save(desk.path("5.png")).expect("written");
    desk.refused("full.png", 3, &["5.png", "does not tell"]);
    fs::remove_file(desk.path("5.png")).expect("removed");
    desk.refused("full.png", 8, &["cannot read 5.png"]);
}

#[test]
fn the_ending_is_the_tiles() {
    let desk = desk(&[]);
    desk.refused("full.exr", 2, &["full.exr", ".png"]);
    desk.refused("nowhere/full.png", 8, &["nowhere/full.png"]);
}
