//! The promise of limits: with too little memory, too small files or too few threads the exit code is 0 or says so (5 for
//! memory, 8 for files), a file is whole or not there, and nothing is left behind. Real processes, under `ulimit`.

#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

const SCENE: &str = "[camera]\neye = [0.0, 0.0, 0.0]\nview = [0.0, 0.0, -1.0]\nup = [0.0, 1.0, 0.0]\nvfov = 60.0\n
[image]\nsize = [40, 30]\n\n[[sphere]]\ncenter = [0.0, 0.0, -3.0]\nradius = 1.0\n";

struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().expect("a folder"));
        fs::write(desk.path().join("s.toml"), SCENE).expect("written");
        desk
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// Runs a command, parted by spaces, under `ulimit`.
    fn run(&self, limit: &str, words: &str, environment: &[(&str, &str)]) -> Output {
        let mut shell = Command::new("sh");
        // No core files and no backtraces, which take memory of their own.
        shell.args(["-c", &format!("ulimit -c 0 && {limit} && exec \"$0\" \"$@\"")]);
        shell.arg(env!("CARGO_BIN_EXE_halfline")).args(words.split_whitespace()).current_dir(self.path());
        shell.env_remove("RUST_BACKTRACE").env_remove("RUST_LOG").env("XDG_CONFIG_HOME", self.path());
        // glibc reserves 64 MiB of addresses for every thread that allocates, if they are free at that moment: within the
        // same `ulimit -v` a command would be done or refused by chance.
        shell.env("MALLOC_ARENA_MAX", "1");
        shell.envs(environment.iter().copied()).stdin(Stdio::null()).output().expect("sh runs")
    }

    fn good(&self, words: &str) {
        let output = self.run("true", words, &[]);
        assert!(output.status.success(), "{words}: {}", text(&output));
    }

    fn files(&self) -> BTreeMap<String, Vec<u8>> {
        let entries = fs::read_dir(self.path()).expect("a folder").map(|entry| entry.expect("an entry"));
        entries.map(|e| (e.file_name().to_string_lossy().into(), fs::read(e.path()).unwrap_or_default())).collect()
    }
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// What became of a command within several numbers of MiB of addresses.
struct Within {
    /// The least number within which it was done.
    least: u64,
    /// How often it was refused.
    refused: usize,
}

/// Runs a command within every number of MiB of addresses: it is done or refused with code 5.
fn within(desk: &Desk, words: &str, output: &str, sizes: impl Iterator<Item = u64>) -> Within {
    let _ = fs::remove_file(desk.path().join(output));
    let before = desk.files();
    desk.good(words);
    let after = desk.files();
    let (mut done, mut refused, mut late) = (Vec::new(), 0, 0);
    for mib in sizes {
        let _ = fs::remove_file(desk.path().join(output));
        let ended = desk.run(&format!("ulimit -v {}", mib << 10), words, &[]);
        let told = text(&ended);
        match ended.status.code() {
            Some(0) => {
                assert!(desk.files() == after, "{words} in {mib} MiB: other files");
                done.push(mib);
            }
            Some(5) => {
                assert!(
                    desk.files() == before,
                    "{words} in {mib} MiB leaves something behind: {:?}",
                    desk.files().keys()
                );
                assert!(told.contains("bytes"), "{words} in {mib} MiB: {told}");
                refused += 1;
                late += usize::from(!told.contains("free"));
            }
            code => panic!("{words} in {mib} MiB ends with {code:?}, {:?}: {told}", ended.status),
        }
    }
    println!("{words}: done within {} sizes, refused within {refused}, {late} of them late", done.len());
    assert!(late == 0 || refused > late, "{words}: {late} of {refused} are refused late");
    Within { least: *done.first().expect("one of the sizes is large enough"), refused }
}

#[test]
fn too_little_memory_is_5() {
    let desk = Desk::new();
    let refused = |words: &str, output: &str, sizes: std::iter::StepBy<std::ops::RangeInclusive<u64>>| {
        let found = within(&desk, words, output, sizes);
        assert!(found.refused > 0, "{words}: no size is too small");
        found.least
    };
    let render = "render s.toml --backend cpu --size 1500x1500";
    refused(&format!("{render} -o a.png"), "a.png", (64..=320).step_by(32));
    let all = "--aov depth,distance,normal,position,id,mask,certainty,bound,alpha";
    refused(&format!("{render} -o all.exr {all}"), "all.exr", (96..=672).step_by(64));
    refused(&format!("{render} -o all.npz {all}"), "all.npz", (96..=672).step_by(64));

    // What is merged is not in memory as a whole: two tiles of 81 MiB each are put together within less than either.
    for (tile, name) in [("1/2", "1.npy"), ("2/2", "2.npy")] {
        desk.good(&format!("render s.toml --backend cpu --size 2660x2660 --tile {tile} --aov position={name}"));
    }
    let length = fs::metadata(desk.path().join("1.npy")).expect("there").len() >> 20;
    assert!(length >= 80, "{length} MiB");
    // Below 48 MiB the program itself may not be loaded.
    let base = within(&desk, "render s.toml --backend cpu -o little.png", "little.png", (48..=176).step_by(16)).least;
    let merged = refused("merge 1.npy 2.npy -o whole.npy", "whole.npy", (48..=304).step_by(16));
    assert!(merged < base + length, "merged within {merged} MiB, the program itself takes {base}");
    refused("compare 1.npy 1.npy", "none", (128..=1024).step_by(128));
}

#[test]
fn files_beyond_their_limit_are_8_and_not_there() {
    let desk = Desk::new();
    let before = desk.files();
    for words in ["-o a.png --aov position=p.npy", "-o a.exr --aov position,normal,id", "--aov position=p.npz"] {
        // Blocks of 512 bytes, or of 1024 where the shell counts so.
        let ended = desk.run("ulimit -f 8", &format!("render s.toml --backend cpu --size 300x200 {words}"), &[]);
        assert_eq!(ended.status.code(), Some(8), "{words}: {:?} {}", ended.status, text(&ended));
        assert!(text(&ended).contains("cannot write"), "{words}: {}", text(&ended));
        let left: Vec<_> =
            desk.files().into_keys().filter(|name| !before.contains_key(name) && name != "a.png").collect();
        assert_eq!(left, [""; 0], "{words}");
        let _ = fs::remove_file(desk.path().join("a.png"));
    }
}

#[test]
fn too_many_threads_are_bounded() {
    let desk = Desk::new();
    desk.good("render s.toml --backend cpu -o a.png");
    let begun = Instant::now();
    let many = [("RAYON_NUM_THREADS", "100000")];
    let ended = desk.run("true", "render s.toml --backend cpu -o b.png", &many);
    assert!(
        ended.status.success() && begun.elapsed() < Duration::from_secs(30),
        "{:?}: {}",
        begun.elapsed(),
        text(&ended)
    );
    assert!(text(&ended).contains("RAYON_NUM_THREADS asks for 100000 threads"), "{}", text(&ended));
    assert!(desk.files()["a.png"] == desk.files()["b.png"]);
}
