//! The promise of `--resume`: only a file that is whole and says word for word that it comes from this very rendering is left
//! alone; and of `--progress` and the signals beside it.

use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant, SystemTime};

const SCENE: &str = "[camera]\neye = [0.0, 0.0, 0.0]\nview = [0.0, 0.0, -1.0]\nup = [0.0, 1.0, 0.0]\nvfov = 60.0\n
[image]\nsize = [40, 30]\n\n[[sphere]]\ncenter = [0.0, 0.0, -3.0]\nradius = 1.0\n";

struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().expect("a folder"));
        fs::write(desk.path("scene.toml"), SCENE).expect("written");
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, options: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halfline"));
        command.args(["render", "scene.toml", "--backend", "cpu"]).args(options).current_dir(self.0.path());
        command.stdin(Stdio::null()).env_remove("RUST_LOG");
        command
    }

    fn good(&self, options: &[&str]) -> Output {
        let output = self.command(options).output().expect("halfline runs");
        assert!(output.status.success(), "{options:?}: {}", text(&output.stderr));
        output
    }

    /// Whether `--resume` rendered; files that were there are written on an old day first, so that touching them shows.
    fn renders(&self, options: &[&str]) -> (bool, Vec<String>) {
        let old = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000);
        for name in self.names() {
            let file = fs::File::options().write(true).open(self.path(&name)).expect("there");
            file.set_modified(old).expect("set");
        }
        let output = self.good(&[options, &["--resume"]].concat());
        let new = |name: &String| fs::metadata(self.path(name)).expect("there").modified().expect("a time") != old;
        (text(&output.stderr).contains("rendering on"), self.names().into_iter().filter(new).collect())
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("a folder");
        let mut names: Vec<_> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn what_is_there_is_left_alone_and_what_is_not_is_written() {
    let desk = Desk::new();
    let asked = ["-o", "a.png", "--aov", "depth,id=b.npz", "--aov", "depth=c.npy", "--aov", "color=d.exr"];
    assert_eq!(desk.renders(&asked), (true, ["a.png", "b.npz", "c.npy", "d.exr"].map(String::from).into()));
    let first: Vec<_> = desk.names().iter().map(|name| fs::read(desk.path(name)).expect("there")).collect();
    assert_eq!(desk.renders(&asked), (false, Vec::new()));
    for (name, fault) in [("a.png", "cut"), ("b.npz", "gone"), ("c.npy", "other"), ("d.exr", "empty")] {
        let path = desk.path(name);
        let bytes = fs::read(&path).expect("there");
        match fault {
            "cut" => fs::write(&path, &bytes[..bytes.len() - 13]).expect("written"),
            "gone" => fs::remove_file(&path).expect("gone"),
            // As many bytes, and a number among them that is another: the eye's words are not the scene's.
            "other" => {
                desk.good(&["--aov", "depth=c.npy", "--eye", "0,0,1"]);
                assert_eq!(fs::read(&path).expect("there").len(), bytes.len());
            }
            _ => fs::write(&path, "").expect("written"),
        }
        assert_eq!(desk.renders(&asked), (true, vec![name.to_owned()]), "{fault}");
        assert_eq!(fs::read(&path).expect("there"), bytes, "{fault}");
    }
    let last: Vec<_> = desk.names().iter().map(|name| fs::read(desk.path(name)).expect("there")).collect();
    assert_eq!(first, last);
}

#[test]
fn every_setting_that_changes_bytes_renders_again() {
    let desk = Desk::new();
    let base = ["-o", "a.png", "--aov", "depth=d.exr"];
    let both = || ["a.png", "d.exr"].map(String::from).to_vec();
    assert_eq!(desk.renders(&base).1, both());
    for (option, written) in [
        (&["--bits", "16"][..], vec!["a.png".to_owned()]),
        (&["--no-return", "zero"], vec!["d.exr".into()]),
        (&["--shade", "normal"], vec!["a.png".into()]),
        (&["--accuracy", "exact"], both()),
        (&["--tolerance", "1e-7", "--accuracy", "certified"], both()),
        // The background is black as it is, so depth is of the same scene.
        (&["--transparent"], vec!["a.png".into()]),
        (&["--vfov", "61"], both()),
        (&["--size", "41x30"], both()),
    ] {
        let asked = [&base[..], option].concat();
        assert_eq!(desk.renders(&asked), (true, written), "{option:?}");
        assert_eq!(desk.renders(&asked), (false, Vec::new()), "{option:?} again");
        desk.renders(&base);
    }
    // What changes no bytes of the file is no reason.
    assert_eq!(desk.renders(&[&base[..], &["--unit", "7", "--repeat", "2"]].concat()), (false, Vec::new()));
}

#[test]
fn the_json_says_what_is_known() {
    let desk = Desk::new();
    let asked = ["-o", "a.png", "--resume", "--json"];
    let report = |output: Output| serde_json::from_str::<Value>(&text(&output.stdout)).expect("JSON");
    let (first, second) = (report(desk.good(&asked)), report(desk.good(&asked)));
    assert_eq!([&first["resumed"], &second["resumed"]], [false, true]);
    for key in ["schema", "version", "halfline", "spheres", "skipped", "adapter", "driver", "method", "accuracy"] {
        assert_eq!(first[key], second[key], "{key}");
    }
    assert!(text(&desk.good(&asked).stderr).contains("already there"));
}

#[test]
fn nothing_on_standard_output_is_ever_there() {
    let desk = Desk::new();
    let asked = ["-o", "-", "--resume"];
    assert_eq!(desk.good(&asked).stdout, desk.good(&asked).stdout);
    let raw = desk.good(&["--aov", "depth=-", "--raw"]).stdout;
    assert_eq!(raw.len(), 8 * 40 * 30);
    assert_eq!(desk.renders(&["--aov", "depth=a.raw"]).1, ["a.raw"]);
    assert_eq!(fs::read(desk.path("a.raw")).expect("there"), raw);
    assert_eq!(desk.renders(&["--aov", "depth=a.raw"]).1, ["a.raw"], "it cannot say where it comes from");
}

#[test]
fn progress_is_told_to_programs() {
    let desk = Desk::new();
    let said = desk.good(&["-o", "a.png", "--progress", "json", "--repeat", "2"]);
    let lines: Vec<Value> = text(&said.stderr)
        .lines()
        .filter(|l| l.starts_with('{'))
        .map(|l| serde_json::from_str(l).expect("JSON"))
        .collect();
    let trace = |frame: u64| {
        let of = |line: &&Value| line["step"] == "trace" && line["frame"] == frame;
        lines.iter().rfind(of).map(|line| (line["done"].as_u64(), line["total"].as_u64()))
    };
    assert_eq!([trace(1), trace(2)], [Some((Some(1200), Some(1200))); 2], "{lines:?}");
    assert_eq!(trace(3), None);

    let said = text(&desk.good(&["-o", "a.png", "--progress", "openjd"]).stdout);
    assert!(said.lines().all(|l| l.starts_with("openjd_progress: ") || l.starts_with("openjd_status: ")), "{said}");
    assert!(said.contains("openjd_progress: 100.0\n"), "{said}");
    for more in [&["--json"][..], &["--aov", "id=-"]] {
        let output = desk.command(&[&["--progress", "openjd", "-o", "b.png"], more].concat()).output().expect("runs");
        assert_eq!(output.status.code(), Some(2), "{more:?}");
    }
    assert!(desk.good(&["-o", "a.png", "--progress", "none"]).stdout.is_empty());
}

#[test]
fn a_preview_is_blocks_on_standard_error() {
    let desk = Desk::new();
    let said = desk.good(&["--preview=blocks", "--aov", "id=id.npy"]);
    assert!(said.stdout.is_empty());
    let shown = text(&said.stderr);
    // 40 x 30 pixels fit 80 x 48 half blocks as they are.
    assert_eq!((shown.matches('\u{2580}').count(), shown.matches("\x1b[0m\n").count()), (40 * 15, 15), "{shown}");
    let without = text(&desk.good(&["--preview", "-o", "a.png"]).stderr);
    assert!(!without.contains('\x1b') && without.contains("--preview=blocks"), "{without}");
}

/// Ended at any time by any signal, a render leaves whole files or none and nothing else. Its exit code is 130 for the
/// requests to end, unless it was done; the others end it as they end any process.
#[test]
#[cfg(unix)]
fn signals_leave_no_half_files() {
    let desk = Desk::new();
    let before = desk.names();
    let (mut ended, start) = (0, Instant::now());
    for n in 0..24u64 {
        let signal = ["-TERM", "-INT", "-HUP", "-QUIT", "-KILL", "-USR1"][n as usize % 6];
        // Some render longer than they write, some the other way round.
        let options =
            ["-o", "a.exr", "--aov", "depth,position,normal,id", "--aov", "position=p.npy", "--size", "900x700"];
        let long = if n % 8 < 4 { &["--accuracy", "exact", "--repeat", "3"][..] } else { &[] };
        let options = [&options[..], long].concat();
        let mut child = desk.command(&options).stderr(Stdio::null()).spawn().expect("halfline runs");
        std::thread::sleep(Duration::from_millis(100 + 60 * n));
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status();
        sent.expect("kill runs");
        let status = child.wait().expect("it ends");
        // A signal that comes before the handler stands, or after the end, is the system's affair.
        let code = status.code();
        ended += usize::from(code == Some(130));
        assert!(matches!(code, Some(130 | 0) | None), "{signal}: {status}");
        assert!(code != Some(130) || ["-TERM", "-INT", "-HUP"].contains(&signal), "{signal}: {status}");
        // SIGQUIT may leave a core file, which is what it is for.
        let left = |name: &String| !before.contains(name) && !name.starts_with("core");
        for name in desk.names().into_iter().filter(left) {
            assert!(["a.exr", "p.npy"].contains(&name.as_str()), "{signal} left {name}");
            halfline::frame::sheet::Sheet::read(&desk.path(&name)).unwrap_or_else(|error| panic!("{error}"));
            fs::remove_file(desk.path(&name)).expect("removed");
        }
    }
    assert!(ended > 1, "too few renders were met at work: {ended} of 12 in {:?}", start.elapsed());
}
