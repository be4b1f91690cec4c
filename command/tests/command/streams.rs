//! The promise of standard output and standard error: messages that cannot be written have no effect, a result that
//! cannot be written is exit code 8, and nothing panics.

use crate::test_dir::{Output, SPHERE, TestDir};
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A stream that cannot be written.
#[derive(Debug, Clone, Copy)]
enum Broken {
    /// A full disk.
    #[cfg(target_os = "linux")]
    Full,
    /// A pipe whose reader is closed.
    Pipe,
}

impl Broken {
    const ALL: &[Self] = &[
        #[cfg(target_os = "linux")]
        Self::Full,
        Self::Pipe,
    ];

    fn stdio(&self) -> Stdio {
        match self {
            #[cfg(target_os = "linux")]
            Self::Full => std::fs::File::options().write(true).open("/dev/full").expect("/dev/full").into(),
            Self::Pipe => std::io::pipe().expect("a pipe").1.into(),
        }
    }
}

fn dir() -> TestDir {
    let dir = TestDir::new(&[("s.toml", SPHERE), ("bad.toml", "[camera]\n")]);
    for (tile, name) in [("1/2", "1.png"), ("2/2", "2.png")] {
        dir.render(&format!("s.toml --tile {tile} -o {name}"));
    }
    dir
}

#[test]
fn messages_that_cannot_be_written_change_nothing() {
    let dir = dir();
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
        (3, "render bad.toml --backend cpu -o a.png --json"),
        (8, "render none.toml --backend cpu -o a.png"),
    ];
    for (code, words) in work {
        let _ = std::fs::remove_file(dir.path("a.png"));
        let whole = Output::of(dir.command(words).env("RUST_LOG", "trace").output().expect("halfline runs"));
        assert_eq!(whole.code, code, "{words}: {}", whole.err);
        let files = dir.files();
        for broken in Broken::ALL {
            let _ = std::fs::remove_file(dir.path("a.png"));
            let output =
                dir.command(words).env("RUST_LOG", "trace").stderr(broken.stdio()).output().expect("halfline runs");
            assert_eq!((output.status.code(), &output.stdout), (Some(code), &whole.out), "{words}, {broken:?}");
            assert!(dir.files() == files, "{words}, {broken:?}: other files");
        }
    }
    // All three streams closed.
    let closed = format!("exec {} render s.toml --backend cpu -o b.png <&- >&- 2>&-", env!("CARGO_BIN_EXE_halfline"));
    let status = Command::new("sh").args(["-c", &closed]).current_dir(dir.path("")).status().expect("sh runs");
    dir.render("s.toml -o a.png");
    assert!(status.code() == Some(0) && dir.get("b.png") == dir.get("a.png"), "{status}");
}

#[test]
fn a_result_that_cannot_be_written_is_exit_code_8() {
    let dir = dir();
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
        "trace s.toml --backend cpu --pattern lidar:rings=1,step=1 -o -",
        "trace s.toml --backend cpu --pattern lidar:rings=1,step=1 --json",
        "compare 1.png 1.png",
        "compare 1.png 2.png --json",
        "compare 1.png 2.png -o -",
        "merge 1.png 2.png -o -",
        "completions bash",
        "man",
        "measure s.toml --backend cpu --methods stable --repeat 1",
    ] {
        for broken in Broken::ALL {
            let Output { code, err, .. } =
                Output::of(dir.command(words).stdout(broken.stdio()).output().expect("runs"));
            assert_eq!(code, 8, "{words}, {broken:?}: {err}");
            assert!(!err.contains("panicked"), "{words}, {broken:?}: {err}");
            let is_brief = words.contains("--help") || words == "--version";
            assert!(err.contains("cannot write -: ") || is_brief, "{words}: {err}");
        }
    }
    // A stream that is closed, in whose place the standard library opens /dev/null; /dev/null itself is a place to write to.
    #[cfg(target_os = "linux")]
    for (words, code) in [
        ("render s.toml --backend cpu -o - >&-", 8),
        ("render s.toml --backend cpu -o /dev/stdout >&-", 8),
        ("render s.toml --backend cpu --json >&-", 8),
        ("trace s.toml --backend cpu --pattern lidar:rings=1,step=1 -o - >&-", 8),
        ("merge 1.png 2.png -o - >&-", 8),
        ("completions bash >&-", 8),
        ("--version >&-", 8),
        ("render s.toml --backend cpu -o - >/dev/null", 0),
        ("render s.toml --backend cpu -o - 1<>/dev/null", 0),
        ("render s.toml --backend cpu -o c.png >&-", 0),
    ] {
        let line = format!("exec {} {words}", env!("CARGO_BIN_EXE_halfline"));
        let output = Command::new("sh").args(["-c", &line]).current_dir(dir.path("")).output().expect("sh runs");
        let Output { code: found, err, .. } = Output::of(output);
        assert_eq!(found, code, "{words}: {err}");
        assert!(code == 0 || words.contains("version") || err.contains("standard output is closed"), "{words}: {err}");
    }
    // Files are written nevertheless.
    let words = "render s.toml --backend cpu -o whole.png --json";
    let output = dir.command(words).stdout(Broken::Pipe.stdio()).output().expect("runs");
    assert_eq!(output.status.code(), Some(8));
    dir.render("s.toml -o other.png");
    assert!(dir.get("whole.png") == dir.get("other.png"));
}

/// The system's names of standard output mean standard output, and a pipe is written in place, whatever its name.
#[test]
fn pipes_and_devices_are_written_in_place() {
    let dir = dir();
    for words in ["-o a.png", "--aov depth=d.npy", "--aov color,depth=e.exr"] {
        dir.render(&format!("s.toml {words}"));
    }
    let (png, npy, exr) = (dir.get("a.png"), dir.get("d.npy"), dir.get("e.exr"));
    for name in ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"]
        .into_iter()
        .filter(|name| cfg!(target_os = "linux") || !name.starts_with("/proc"))
    {
        assert!(dir.render(&format!("s.toml -o {name}")).out == png, "{name}");
        assert!(dir.render(&format!("s.toml --aov depth={name}")).out == npy, "{name}");
        assert_eq!(dir.array("d.npy").1, [30, 40]);
        dir.refused_render(2, &format!("s.toml -o {name} --json"), &["standard output"]);
    }
    dir.render("s.toml -o /dev/null --aov depth=/dev/null");
    for (name, words, expected) in [("pipe", "-o pipe", &png), ("pipe.exr", "--aov color,depth=pipe.exr", &exr)] {
        let path = dir.path(name);
        assert!(Command::new("mkfifo").arg(&path).status().expect("mkfifo runs").success());
        let reader = std::thread::spawn({
            let path = path.clone();
            move || std::fs::read(path).expect("a pipe")
        });
        dir.render(&format!("s.toml {words}"));
        assert!(reader.join().expect("read") == *expected, "{words}");
        use std::os::unix::fs::FileTypeExt;
        assert!(path.metadata().expect("there").file_type().is_fifo(), "{words}: the pipe is still one");
        std::fs::remove_file(path).expect("removed");
    }
}

/// A command that would read a named pipe twice refuses it and does not wait for a second writer; one that reads it
/// once renders it.
#[test]
fn a_pipe_is_read_once() {
    let dir = TestDir::new(&[("all.xyz", "2\n\nC 0 0 0\nO 1 0 0\n")]);
    assert!(Command::new("mkfifo").arg(dir.path("pipe")).status().expect("mkfifo runs").success());
    let written = |words: &str| {
        let write = "cat all.xyz > pipe";
        let mut writer = Command::new("sh").args(["-c", write]).current_dir(dir.path("")).spawn().expect("sh runs");
        let output = dir.run(words);
        let _ = writer.kill();
        writer.wait().expect("an end");
        output
    };
    let render = "render pipe --format xyz --backend cpu -o p.png";
    for words in [format!("{render} --stream"), format!("{render} --frames 1-1 --hold all"), "view pipe".to_owned()] {
        let output = written(&words);
        assert!(output.code == 2 && output.err.contains("a pipe can be read once"), "{words}: {}", output.err);
    }
    for words in [render.to_owned(), format!("{render} --stream --eye 0,0,9 --at 0,0,0 --up 0,1,0")] {
        let output = written(&words);
        assert!(output.code == 0, "{words}: {}", output.err);
    }
}

/// SIGTERM ends a process that waits for the reader of a pipe.
#[test]
fn an_interrupt_ends_a_blocked_write() {
    let dir = dir();
    assert!(Command::new("mkfifo").arg(dir.path("fifo")).status().expect("mkfifo runs").success());
    // A pipe that is never opened for reading, and a standard output that is not read.
    for words in ["-o fifo", "--aov position=- --size 400x300 --raw"] {
        let render = format!("render s.toml --backend cpu {words}");
        let mut child =
            dir.command(&render).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("halfline runs");
        let mut messages = BufReader::new(child.stderr.take().expect("a pipe"));
        let mut line = String::new();
        messages.read_line(&mut line).expect("a line");
        assert!(line.contains("rendering on"), "{words}: {line}");
        std::thread::sleep(Duration::from_millis(300));
        assert!(child.try_wait().expect("its status").is_none(), "{words}: it waits");
        let sent = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
        assert!(sent.expect("kill runs").success());
        let start = Instant::now();
        // It takes half a second; more on a busy machine.
        while child.try_wait().expect("its status").is_none() && start.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(10));
        }
        let _ = child.kill();
        assert_eq!(child.wait().expect("an end").code(), Some(130), "{words}");
        let mut rest = String::new();
        messages.read_to_string(&mut rest).expect("text");
        assert_eq!(rest, "halfline: interrupted\n", "{words}");
    }
}
