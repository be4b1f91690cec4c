//! The promise of `--resume`: a file is kept only if it is whole and has the provenance of this rendering. And the promises
//! of `--progress`, `--preview` and signals.

use crate::amount::amount;
use crate::test_dir::{Output, SPHERE, TestDir};
use serde_json::Value;
use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime};

/// A folder with `scene.toml` in it, which every command renders.
struct Renders(TestDir);

impl Renders {
    fn new() -> Self {
        Self(TestDir::new(&[("scene.toml", SPHERE)]))
    }

    fn good(&self, options: &[&str]) -> Output {
        self.0.render(&[&["scene.toml"], options].concat())
    }

    /// Whether `--resume` rendered, and the files that it wrote: all others get an old time first.
    fn written(&self, options: &[&str]) -> (bool, Vec<String>) {
        let old = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000);
        for name in self.names() {
            let file = fs::File::options().write(true).open(self.0.path(&name)).expect("there");
            file.set_modified(old).expect("set");
        }
        let output = self.good(&[options, &["--resume"]].concat());
        let new = |name: &String| fs::metadata(self.0.path(name)).expect("there").modified().expect("a time") != old;
        (output.err.contains("rendering on"), self.names().into_iter().filter(new).collect())
    }

    fn names(&self) -> Vec<String> {
        self.0.files().into_keys().collect()
    }
}

#[test]
fn whole_files_are_kept_and_all_others_written() {
    let renders = Renders::new();
    let options = ["-o", "a.png", "--aov", "depth,id=b.npz", "--aov", "depth=c.npy", "--aov", "color=d.exr"];
    assert_eq!(renders.written(&options), (true, ["a.png", "b.npz", "c.npy", "d.exr"].map(String::from).into()));
    let first = renders.0.files();
    assert_eq!(renders.written(&options), (false, Vec::new()));
    for (name, fault) in [("a.png", "cut"), ("b.npz", "gone"), ("c.npy", "another"), ("d.exr", "empty")] {
        let bytes = renders.0.get(name);
        match fault {
            "cut" => renders.0.put(name, &bytes[..bytes.len() - 13]),
            "gone" => renders.0.remove(name),
            // A file of the same length from another scene.
            "another" => {
                renders.good(&["--aov", "depth=c.npy", "--eye", "0,0,1"]);
                assert_eq!(renders.0.get(name).len(), bytes.len());
            }
            _ => renders.0.put(name, ""),
        }
        assert_eq!(renders.written(&options), (true, vec![name.to_owned()]), "{fault}");
        assert_eq!(renders.0.get(name), bytes, "{fault}");
    }
    assert!(renders.0.files() == first);
}

#[test]
fn a_setting_that_changes_bytes_renders_again() {
    let renders = Renders::new();
    let base = ["-o", "a.png", "--aov", "depth=d.exr"];
    let both = || ["a.png", "d.exr"].map(String::from).to_vec();
    assert_eq!(renders.written(&base).1, both());
    for (option, written) in [
        (&["--bits", "16"][..], vec!["a.png".to_owned()]),
        (&["--no-return", "zero"], vec!["d.exr".into()]),
        (&["--shade", "normal"], vec!["a.png".into()]),
        (&["--silhouette"], vec!["a.png".into()]),
        (&["--depth-cue"], vec!["a.png".into()]),
        (&["--sun", "1,1,1"], both()),
        (&["--accuracy", "exact"], both()),
        (&["--tolerance", "1e-7", "--accuracy", "certified"], both()),
        // The background is black anyway, so the provenance of depth is unchanged.
        (&["--transparent"], vec!["a.png".into()]),
        (&["--vfov", "61"], both()),
        (&["--size", "41x30"], both()),
    ] {
        let options = [&base[..], option].concat();
        assert_eq!(renders.written(&options), (true, written), "{option:?}");
        assert_eq!(renders.written(&options), (false, Vec::new()), "{option:?} again");
        renders.written(&base);
    }
    // Options that do not change the bytes of the file.
    assert_eq!(renders.written(&[&base[..], &["--unit", "7", "--repeat", "2"]].concat()), (false, Vec::new()));
}

#[test]
fn the_json_of_a_resumed_frame_says_so() {
    let renders = Renders::new();
    let options = ["-o", "a.png", "--resume", "--json"];
    let [first, second] = [(); 2].map(|()| renders.good(&options).json());
    assert_eq!([&first["resumed"], &second["resumed"]], [false, true]);
    for key in ["schema", "version", "halfline", "spheres", "skipped", "adapter", "driver", "method", "accuracy"] {
        assert_eq!(first[key], second[key], "{key}");
    }
    assert!(renders.good(&options).err.contains("a.png is already there: it is complete"));
    let several = ["-o", "f.%d.png", "--aov", "id=i.%d.npy", "--spin", "2", "--resume"];
    renders.good(&several);
    let stderr = renders.good(&several).err;
    for n in 1..=2 {
        assert!(stderr.contains(&format!("halfline: f.{n}.png, i.{n}.npy are already there")), "{stderr}");
    }
}

#[test]
fn standard_output_and_raw_files_are_always_rendered() {
    let renders = Renders::new();
    let options = ["-o", "-", "--resume"];
    assert_eq!(renders.good(&options).out, renders.good(&options).out);
    let raw = renders.good(&["--aov", "depth=-", "--raw"]).out;
    assert_eq!(raw.len(), 8 * 40 * 30);
    assert_eq!(renders.written(&["--aov", "depth=a.raw"]).1, ["a.raw"]);
    assert_eq!(renders.0.get("a.raw"), raw);
    assert_eq!(renders.written(&["--aov", "depth=a.raw"]).1, ["a.raw"], "a raw file has no provenance");
}

#[test]
fn progress_is_printed_for_programs() {
    let renders = Renders::new();
    let lines: Vec<Value> = renders
        .good(&["-o", "a.png", "--progress", "json", "--repeat", "2"])
        .err
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

    let text = renders.good(&["-o", "a.png", "--progress", "openjd"]).text();
    assert!(text.lines().all(|l| l.starts_with("openjd_progress: ") || l.starts_with("openjd_status: ")), "{text}");
    assert!(text.contains("openjd_progress: 100.0\n"), "{text}");
    for more in [&["--json"][..], &["--aov", "id=-"]] {
        renders.0.refused_render(2, &[&["scene.toml", "--progress", "openjd", "-o", "b.png"], more].concat(), &[]);
    }
    assert!(renders.good(&["-o", "a.png", "--progress", "none"]).out.is_empty());
}

#[test]
fn a_preview_is_blocks_on_standard_error() {
    let renders = Renders::new();
    let Output { out, err: shown, .. } = renders.good(&["--preview=blocks", "--aov", "id=id.npy"]);
    assert!(out.is_empty());
    // 40 x 30 pixels fit 80 x 48 half blocks as they are.
    assert_eq!((shown.matches('\u{2580}').count(), shown.matches("\x1b[0m\n").count()), (40 * 15, 15), "{shown}");
    let without = renders.good(&["--preview", "-o", "a.png"]).err;
    assert!(!without.contains('\x1b') && without.contains("--preview=blocks"), "{without}");
}

/// A render that is ended by any signal at any time leaves complete files or none. Its exit code is 130 for SIGTERM,
/// SIGINT and SIGHUP, unless it had finished; other signals have the system's default effect.
#[test]
#[cfg(unix)]
fn signals_leave_no_half_files() {
    let renders = Renders::new();
    let before = renders.names();
    let (mut ended, start) = (0, Instant::now());
    let apart = 4 / amount("moments of signals, in quarters", [1, 1, 4]);
    for n in (0..24u64).step_by(apart) {
        let signal = ["-TERM", "-INT", "-HUP", "-QUIT", "-KILL", "-USR1"][(n as usize + n as usize / 8) % 6];
        // Some spend more time rendering, some more writing.
        let options =
            ["-o", "a.exr", "--aov", "depth,position,normal,id", "--aov", "position=p.npy", "--size", "900x700"];
        let long = if n % 8 < 4 { &["--accuracy", "exact", "--repeat", "3"][..] } else { &[] };
        let arguments = [&["render", "scene.toml", "--backend", "cpu"], &options[..], long].concat();
        let mut child = renders.0.command(&arguments).stderr(Stdio::null()).spawn().expect("halfline runs");
        std::thread::sleep(Duration::from_millis(100 + 60 * n));
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status();
        sent.expect("kill runs");
        let status = child.wait().expect("it ends");
        // A signal before the handler is installed ends the process by the system's default.
        let code = status.code();
        ended += usize::from(code == Some(130));
        assert!(matches!(code, Some(130 | 0) | None), "{signal}: {status}");
        assert!(code != Some(130) || ["-TERM", "-INT", "-HUP"].contains(&signal), "{signal}: {status}");
        // SIGQUIT may leave a core file.
        let left = |name: &String| !before.contains(name) && !name.starts_with("core");
        for name in renders.names().into_iter().filter(left) {
            assert!(["a.exr", "p.npy"].contains(&name.as_str()), "{signal} left {name}");
            halfline_files::write::image_file::ImageFile::read(&renders.0.path(&name))
                .unwrap_or_else(|error| panic!("{error}"));
            renders.0.remove(&name);
        }
    }
    assert!(ended > usize::from(apart == 1), "only {ended} of 12 renders were interrupted in {:?}", start.elapsed());
}
