//! The promise of standard output and standard error: talk that cannot be written decides nothing, and a result that does not
//! arrive ends with 8. Nothing panics.

#![cfg(unix)]

#[path = "common/desk.rs"]
mod desk;

use desk::Desk;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

const SCENE: &str = "[camera]\neye = [0.0, 0.0, 0.0]\nview = [0.0, 0.0, -1.0]\nup = [0.0, 1.0, 0.0]\nvfov = 60.0\n
[image]\nsize = [40, 30]\n\n[[sphere]]\ncenter = [0.0, 0.0, -3.0]\nradius = 1.0\n";

/// Where nothing can be written.
#[derive(Debug, Clone, Copy)]
enum Broken {
    /// A full disk.
    Full,
    /// A pipe whose reader is gone.
    Pipe,
}

impl Broken {
    fn stdio(self) -> Stdio {
        match self {
            Self::Full => File::options().write(true).open("/dev/full").expect("/dev/full").into(),
            Self::Pipe => std::io::pipe().expect("a pipe").1.into(),
        }
    }
}

fn desk() -> Desk {
    let desk = Desk::new(&[("s.toml", SCENE), ("bad.toml", "[camera]\n")]);
    for (tile, name) in [("1/2", "1.png"), ("2/2", "2.png")] {
        desk.render(&format!("s.toml --tile {tile} -o {name}"));
    }
    desk
}

fn command(desk: &Desk, words: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_halfline"));
    command.args(words.split_whitespace()).current_dir(desk.path("")).stdin(Stdio::null());
    command.env("XDG_CONFIG_HOME", desk.path("")).env("RUST_LOG", "trace");
    command
}

fn err(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn talk_that_cannot_be_written_decides_nothing() {
    let desk = desk();
    let work = [
        (0, "render s.toml --backend cpu -o a.png"),
        (0, "render s.toml --backend cpu -o a.png --progress json --preview=blocks"),
        (0, "render s.toml --backend cpu -o a.png --resume"),
        (0, "merge 1.png 2.png -o a.png"),
        (0, "compare 1.png 1.png"),
        (1, "compare 1.png 2.png"),
        (2, "render s.toml --bogus"),
        (2, "render s.toml"),
        (3, "render bad.toml --backend cpu -o a.png"),
        (8, "render none.toml --backend cpu -o a.png"),
    ];
    for (code, words) in work {
        let _ = std::fs::remove_file(desk.path("a.png"));
        let seen = command(&desk, words).output().expect("halfline runs");
        assert_eq!(seen.status.code(), Some(code), "{words}: {}", err(&seen));
        let files = desk.files();
        for broken in [Broken::Full, Broken::Pipe] {
            let _ = std::fs::remove_file(desk.path("a.png"));
            let output = command(&desk, words).stderr(broken.stdio()).output().expect("halfline runs");
            assert_eq!((output.status.code(), &output.stdout), (Some(code), &seen.stdout), "{words}, {broken:?}");
            assert!(desk.files() == files, "{words}, {broken:?}: other files");
        }
    }
    // Closed, all three of them.
    let closed = format!("exec {} render s.toml --backend cpu -o b.png <&- >&- 2>&-", env!("CARGO_BIN_EXE_halfline"));
    let status = Command::new("sh").args(["-c", &closed]).current_dir(desk.path("")).status().expect("sh runs");
    desk.render("s.toml -o a.png");
    assert!(status.code() == Some(0) && desk.get("b.png") == desk.get("a.png"), "{status}");
}

#[test]
fn a_result_that_does_not_arrive_ends_with_8() {
    let desk = desk();
    for words in [
        "--help",
        "--version",
        "render --help",
        "render s.toml --backend cpu --json",
        "render s.toml --backend cpu -o -",
        "render s.toml --backend cpu --aov depth=-",
        "render s.toml --backend cpu --aov depth=- --raw",
        "plan s.toml --backend cpu -o a.png",
        "plan s.toml --backend cpu -o a.png --json",
        "compare 1.png 1.png",
        "compare 1.png 2.png --json",
        "compare 1.png 2.png -o -",
        "merge 1.png 2.png -o -",
        "completions bash",
        "man",
        "measure s.toml --backend cpu --methods stable --repeat 1",
    ] {
        for broken in [Broken::Full, Broken::Pipe] {
            let output = command(&desk, words).env_remove("RUST_LOG").stdout(broken.stdio()).output().expect("runs");
            let told = err(&output);
            assert_eq!(output.status.code(), Some(8), "{words}, {broken:?}: {told}");
            assert!(!told.contains("panicked"), "{words}, {broken:?}: {told}");
            assert!(
                told.contains("cannot write -: ") || words.contains("--help") || words == "--version",
                "{words}: {told}"
            );
        }
    }
    // What goes to files is there all the same.
    let words = "render s.toml --backend cpu -o whole.png --json";
    let output = command(&desk, words).stdout(Broken::Full.stdio()).output().expect("runs");
    assert_eq!(output.status.code(), Some(8));
    desk.render("s.toml -o other.png");
    assert!(desk.get("whole.png") == desk.get("other.png"));
}

/// What systems call standard output is standard output, and a pipe is written as it is, whatever it is called.
#[test]
fn pipes_and_devices_are_written_as_they_are() {
    let desk = desk();
    for words in ["-o a.png", "--aov depth=d.npy", "--aov color,depth=e.exr"] {
        desk.render(&format!("s.toml {words}"));
    }
    let (png, npy, exr) = (desk.get("a.png"), desk.get("d.npy"), desk.get("e.exr"));
    for name in ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"]
        .into_iter()
        .filter(|name| cfg!(target_os = "linux") || !name.starts_with("/proc"))
    {
        assert!(desk.render(&format!("s.toml -o {name}")).out == png, "{name}");
        assert!(desk.render(&format!("s.toml --aov depth={name}")).out == npy, "{name}");
        assert_eq!(desk.array("d.npy").1, [30, 40]);
        desk.refused(2, &format!("s.toml -o {name} --json"), &["standard output"]);
    }
    desk.render("s.toml -o /dev/null --aov depth=/dev/null");
    for (name, words, expected) in [("pipe", "-o pipe", &png), ("pipe.exr", "--aov color,depth=pipe.exr", &exr)] {
        let path = desk.path(name);
        assert!(Command::new("mkfifo").arg(&path).status().expect("mkfifo runs").success());
        let reader = std::thread::spawn({
            let path = path.clone();
            move || std::fs::read(path).expect("a pipe")
        });
        desk.render(&format!("s.toml {words}"));
        assert!(reader.join().expect("read") == *expected, "{words}");
        use std::os::unix::fs::FileTypeExt;
        assert!(path.metadata().expect("there").file_type().is_fifo(), "{words}: the pipe is still one");
        std::fs::remove_file(path).expect("removed");
    }
}

/// A request to end is answered also where the process waits for a reader that never comes.
#[test]
fn an_interrupt_ends_what_waits_for_a_reader() {
    let desk = desk();
    assert!(Command::new("mkfifo").arg(desk.path("fifo")).status().expect("mkfifo runs").success());
    // A pipe that nobody opens, and a standard output that is full and not read.
    for words in ["-o fifo", "--aov position=- --size 400x300 --raw"] {
        let render = format!("render s.toml --backend cpu {words}");
        let mut child = command(&desk, &render)
            .env_remove("RUST_LOG")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("halfline runs");
        let mut said = BufReader::new(child.stderr.take().expect("a pipe"));
        let mut line = String::new();
        said.read_line(&mut line).expect("a line");
        assert!(line.contains("rendering on"), "{words}: {line}");
        std::thread::sleep(Duration::from_millis(300));
        assert!(child.try_wait().expect("its status").is_none(), "{words}: it waits");
        let sent = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
        assert!(sent.expect("kill runs").success());
        let start = Instant::now();
        // Long beside the half second that it has, for a busy machine.
        while child.try_wait().expect("its status").is_none() && start.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(10));
        }
        let _ = child.kill();
        assert_eq!(child.wait().expect("an end").code(), Some(130), "{words}");
        let mut rest = String::new();
        said.read_to_string(&mut rest).expect("text");
        assert_eq!(rest, "halfline: interrupted\n", "{words}");
    }
}
