//! The promise under limits: with too little memory the exit code is 0 or 5, with too small a file size 8. A file is written
//! completely or not at all, and nothing else is left behind. The tests run processes under `ulimit`.

use crate::amount::amount;
use crate::numpy::npy_of;
use crate::test_dir::{Output, SPHERE, TestDir};
use std::fs;
use std::time::{Duration, Instant};

fn dir() -> TestDir {
    TestDir::new(&[("s.toml", SPHERE)])
}

/// Runs halfline under `ulimit`.
fn run(dir: &TestDir, limit: &str, arguments: &str, environment: &[(&str, &str)]) -> Output {
    let mut shell = dir.program("sh");
    // No core files and no backtraces, which take memory of their own.
    shell.args(["-c", &format!("ulimit -c 0 && {limit} && exec \"$0\" \"$@\"")]);
    shell.arg(env!("CARGO_BIN_EXE_halfline")).args(arguments.split_whitespace()).env_remove("RUST_BACKTRACE");
    // glibc reserves 64 MiB of addresses for every thread that allocates, if they are free at that moment: under the same
    // `ulimit -v` a command would succeed or fail by chance.
    shell.env("MALLOC_ARENA_MAX", "1");
    Output::of(shell.envs(environment.iter().copied()).output().expect("sh runs"))
}

/// The outcomes of a command with several limits of its address space.
struct Within {
    /// The smallest limit in MiB under which it succeeded.
    least: u64,
    /// The number of limits under which it was refused.
    refused: usize,
}

/// Runs a command under each limit in MiB: it succeeds or is refused with code 5.
fn within(dir: &TestDir, words: &str, output: &str, sizes: impl Iterator<Item = u64>) -> Within {
    let _ = fs::remove_file(dir.path(output));
    let before = dir.files();
    dir.good(words);
    let after = dir.files();
    let (mut done, mut refused, mut late) = (Vec::new(), 0, 0);
    for mib in sizes {
        let _ = fs::remove_file(dir.path(output));
        let Output { code, err, .. } = run(dir, &format!("ulimit -v {}", mib << 10), words, &[]);
        match code {
            0 => {
                assert!(dir.files() == after, "{words} in {mib} MiB: other files");
                done.push(mib);
            }
            5 => {
                assert!(
                    dir.files() == before,
                    "{words} in {mib} MiB leaves something behind: {:?}",
                    dir.files().keys()
                );
                assert!(err.contains("bytes"), "{words} in {mib} MiB: {err}");
                refused += 1;
                late += usize::from(!err.contains("free"));
            }
            code => panic!("{words} in {mib} MiB ends with {code}: {err}"),
        }
    }
    println!("{words}: succeeds under {} limits, refused under {refused}, {late} of them after work began", done.len());
    assert!(late == 0 || refused > late, "{words}: {late} of {refused} refused after work began");
    Within { least: *done.first().expect("one of the limits is large enough"), refused }
}

#[test]
fn too_little_memory_is_exit_code_5() {
    let dir = dir();
    let refused = |words: &str, output: &str, sizes: std::iter::StepBy<std::ops::RangeInclusive<u64>>| {
        let found = within(&dir, words, output, sizes);
        assert!(found.refused > 0, "{words}: no limit is too small");
        found.least
    };
    // The limits lie farther apart where not everything is tested.
    let apart = 4 / amount("limits of memory, in quarters", [1, 1, 4]);
    let render = "render s.toml --backend cpu --size 750x750";
    refused(&format!("{render} -o a.png"), "a.png", (64..=160).step_by(8 * apart));
    let all = "--aov depth,distance,normal,position,id,mask,certainty,bound,alpha";
    refused(&format!("{render} -o all.exr {all}"), "all.exr", (64..=288).step_by(16 * apart));
    refused(&format!("{render} -o all.npz {all}"), "all.npz", (64..=288).step_by(16 * apart));

    // Merging does not hold the whole frame in memory: two tiles of 81 MiB each are merged in less than either.
    for (tile, name) in [("1/2", "1.npy"), ("2/2", "2.npy")] {
        dir.good(&format!("render s.toml --backend cpu --size 2660x2660 --tile {tile} --aov position={name}"));
    }
    let length = fs::metadata(dir.path("1.npy")).expect("there").len() >> 20;
    assert!(length >= 80, "{length} MiB");
    // Below 64 MiB the program itself may not be loaded, or its threads not be started.
    let base =
        within(&dir, "render s.toml --backend cpu -o little.png", "little.png", (64..=192).step_by(8 * apart)).least;
    let merged = refused("merge 1.npy 2.npy -o whole.npy", "whole.npy", (64..=320).step_by(8 * apart));
    assert!(merged < base + length, "merged within {merged} MiB, the program itself takes {base}");
    refused("compare 1.npy 1.npy", "none", (128..=1152).step_by(128 * apart));
}

/// The memory for many rays is that for some: blocks are read, traced and written one after the other.
#[test]
fn any_number_of_rays_needs_the_same_memory() {
    let dir = dir().in_parts(4);
    // Rays of 24 bytes and hits of 33: 9 MB and 12 MB, or four times as many.
    for (name, count) in [("some.npy", 375_000), ("many.npy", 1_500_000)] {
        let rays: Vec<u8> = [0.0f32, 0.0, 0.0, 0.0, 0.0, -1.0].into_iter().flat_map(f32::to_le_bytes).collect();
        dir.put(name, npy_of("<f4", "False", &format!("({count}, 6)"), &rays.repeat(count)));
    }
    for output in ["hits.npz", "hits.csv"] {
        let traced = |name: &str, mib: u64| {
            let words = format!("trace s.toml --backend cpu --rays {name} -o {output}");
            let Output { code, err, .. } = run(&dir, &format!("ulimit -v {}", mib << 10), &words, &[]);
            assert!(code == 0 || code == 5, "{name} in {mib} MiB: {code}: {err}");
            assert_eq!(dir.path(output).exists(), code == 0, "{name} in {mib} MiB");
            let _ = fs::remove_file(dir.path(output));
            code == 0
        };
        let least = (64..1024).step_by(8).find(|mib| traced("some.npy", *mib)).expect("enough memory");
        println!("{output}: {least} MiB");
        // The 1,125,000 rays and hits more are 61 MiB; a half of them would be noticed. Blocks are traced while others are
        // read and written, so how many are alive at once, and what lies between them, differs from run to run: by 8 MiB on
        // an idle machine of 2 cores.
        assert!(traced("many.npy", least + 30), "{output}: some rays are traced in {least} MiB");
    }
}

#[test]
fn a_file_beyond_the_size_limit_is_exit_code_8_and_not_written() {
    let dir = dir();
    let before = dir.files();
    for words in ["-o a.png --aov position=p.npy", "-o a.exr --aov position,normal,id", "--aov position=p.npz"] {
        // Blocks of 512 or 1024 bytes, by the shell.
        let ended = run(&dir, "ulimit -f 8", &format!("render s.toml --backend cpu --size 300x200 {words}"), &[]);
        assert!(ended.code == 8 && ended.err.contains("cannot write"), "{words}: {} {}", ended.code, ended.err);
        let left: Vec<_> =
            dir.files().into_keys().filter(|name| !before.contains_key(name) && name != "a.png").collect();
        assert_eq!(left, [""; 0], "{words}");
        let _ = fs::remove_file(dir.path("a.png"));
    }
    for name in ["hits.npz", "hits.csv"] {
        let words = format!("trace s.toml --backend cpu --pattern lidar:rings=1,step=0.01 -o {name}");
        let ended = run(&dir, "ulimit -f 8", &words, &[]);
        assert!(ended.code == 8 && ended.err.contains(&format!("cannot write {name}")), "{}", ended.err);
        assert!(dir.files() == before, "{name}: {:?}", dir.files().keys());
    }
}

#[test]
fn too_many_threads_are_bounded() {
    let dir = dir();
    dir.good("render s.toml --backend cpu -o a.png");
    let begun = Instant::now();
    let many = [("RAYON_NUM_THREADS", "100000")];
    let ended = run(&dir, "true", "render s.toml --backend cpu -o b.png", &many);
    assert!(ended.code == 0 && begun.elapsed() < Duration::from_secs(30), "{:?}: {}", begun.elapsed(), ended.err);
    assert!(ended.err.contains("RAYON_NUM_THREADS is 100000"), "{}", ended.err);
    assert!(dir.files()["a.png"] == dir.files()["b.png"]);
}
