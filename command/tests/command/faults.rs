//! The promise under faults: if any system call fails, the exit code reports it, a file is written completely or not at
//! all, nothing else is left behind, inputs are unchanged, and the same command succeeds afterwards.
//!
//! A preloaded library (`shim.c`) makes the n-th call of a kind fail, for every n, once only this call and once all
//! later calls too, as SQLite's tests do (<https://www.sqlite.org/testing.html>, 3.1 and 3.2). It covers calls of the C
//! library; allocations smaller than FAULT_BYTES and direct system calls are not covered.

use crate::amount::amount;
use crate::skip::skip;
use crate::test_dir::TestDir;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Names and contents of the files in a folder.
type Files = BTreeMap<String, Vec<u8>>;

/// The kinds of calls, and the exit codes that are allowed after a failure.
const KINDS: [(&str, &[i32]); 12] = [
    ("write", &[0, 8]),
    ("stdout", &[0, 8]),
    // Lost messages have no effect.
    ("stderr", &[0]),
    // A file that cannot be read to its end may be reported as invalid.
    ("read", &[0, 3, 8]),
    ("open", &[0, 8]),
    ("create", &[0, 8]),
    ("name", &[0, 8]),
    ("sync", &[0, 8]),
    ("seek", &[0, 3, 8]),
    ("mode", &[0, 8]),
    // Fewer threads give the same frame.
    ("thread", &[0]),
    ("memory", &[0, 5]),
];

/// The smallest allocation that fails, in bytes: those that grow with pixels or spheres are larger.
const BYTES: &str = "4096";

/// A command, with the files before and after it.
struct Case {
    name: &'static str,
    command: &'static str,
    /// The files before.
    before: Files,
    /// The files afterwards, if nothing fails.
    after: Files,
}

/// The outcome of a command.
struct Outcome {
    code: Option<i32>,
    err: String,
    /// The number of calls that failed, and of all calls where the process ended by itself.
    failed: usize,
    calls: Option<u64>,
    files: Files,
}

/// The preloaded library, compiled with the C compiler; `None` and skipped where there is none.
fn shim(folder: &Path) -> Option<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/command/shim.c");
    let library = folder.join("shim.so");
    let mut compiler = Command::new(std::env::var_os("CC").unwrap_or_else(|| "cc".into()));
    compiler.args(["-shared", "-fPIC", "-O1", "-Wall", "-o"]).args([&library, &source]).arg("-ldl");
    let made = match compiler.output() {
        Ok(made) => made,
        Err(error) => {
            skip(format!("no C compiler: {error}"));
            return None;
        }
    };
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    Some(library)
}

/// Runs a command on `before` in a folder of its own; `faults` are the kind and the first and last call that fail.
fn run(shim: &Path, command: &str, before: &Files, faults: Option<(&str, u64, u64)>) -> Outcome {
    let (dir, notes) = (TestDir::new(&[]), TestDir::new(&[]));
    let note = notes.path("note");
    before.iter().for_each(|(name, content)| dir.put(name, content));
    let mut process = dir.command(command);
    process.env_clear().env("HOME", notes.path("")).env("RAYON_NUM_THREADS", "2");
    if let Some((kind, first, last)) = faults {
        process.env("LD_PRELOAD", shim).env("FAULT_NOTE", &note).env("FAULT_BYTES", BYTES).env("FAULT_KIND", kind);
        process.env("FAULT_AT", first.to_string()).env("FAULT_LAST", last.to_string());
    }
    let output = process.output().expect("halfline runs");
    let notes = fs::read_to_string(&note).unwrap_or_default();
    Outcome {
        code: output.status.code(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
        failed: notes.lines().filter(|line| *line == "failed").count(),
        calls: notes.lines().find_map(|line| line.strip_prefix("calls ")?.parse().ok()),
        files: dir.files(),
    }
}

impl Case {
    /// The files after a command that must succeed.
    fn new(shim: &Path, name: &'static str, command: &'static str, before: Files) -> Self {
        let done = run(shim, command, &before, None);
        assert_eq!(done.code, Some(0), "{name}: {}", done.err);
        Self { name, command, before, after: done.files }
    }

    /// The first thing that is wrong with an outcome.
    fn fault(&self, shim: &Path, outcome: &Outcome, codes: &[i32]) -> Option<String> {
        let Outcome { code, err, files, .. } = outcome;
        if err.contains("panicked") {
            return Some(format!("panics: {err}"));
        }
        let Some(code) = code.filter(|code| codes.contains(code)) else {
            return Some(format!("ends with {code:?}, not with one of {codes:?}: {err}"));
        };
        if code == 0 {
            return (*files != self.after).then(|| format!("is done, but the files differ: {:?}", files.keys()));
        }
        // When the process runs out of memory, another thread may be between the two steps that replace a file. The next
        // run, below, removes the temporary file.
        let is_stale = |name: &str| code == 5 && name.ends_with(".part");
        for (name, content) in files.iter().filter(|(name, _)| !is_stale(name)) {
            if self.before.get(name) != Some(content) && self.after.get(name) != Some(content) {
                return Some(format!("leaves {name}, which is neither the old file nor the new one"));
            }
        }
        if let Some((name, _)) = self.before.iter().find(|(name, _)| !files.contains_key(*name)) {
            return Some(format!("takes {name} away"));
        }
        if err.trim().is_empty() {
            return Some(format!("ends with {code} and says nothing"));
        }
        // What succeeds on the same files is known.
        if *files == self.before {
            return None;
        }
        let again = run(shim, self.command, files, None);
        (again.code != Some(0) || again.files != self.after).then(|| format!("cannot be done again: {}", again.err))
    }

    /// Makes every call of a kind fail, once alone and once with all later ones; of many calls, such as allocations, only one in
    /// so many where not everything is tested. Returns the number of calls, the number of runs by exit code, and the errors.
    fn every(&self, shim: &Path, kind: &str, codes: &[i32]) -> (u64, BTreeMap<i32, usize>, Vec<String>) {
        let whole = run(shim, self.command, &self.before, Some((kind, 0, 0)));
        assert_eq!((whole.code, &whole.files), (Some(0), &self.after), "{} counted: {}", self.name, whole.err);
        let calls = whole.calls.expect("the shim counts");
        // The number and the order of allocations vary with the threads.
        let share = match calls {
            0..=24 => amount("calls of a kind that has few, in eighths", [3, 8, 8]),
            _ => amount("calls of a kind that has many, in eighths", [1, 1, 8]),
        };
        let failing = (1..=calls).filter(|n| n % 8 < share);
        let runs = failing.flat_map(|n| [(n, n), (n, u64::MAX >> 1)]).collect::<Vec<_>>();
        let outcomes: Vec<_> = runs
            .into_par_iter()
            .map(|(first, last)| {
                let outcome = run(shim, self.command, &self.before, Some((kind, first, last)));
                let fault = self.fault(shim, &outcome, codes).map(|fault| {
                    let which = if first == last { "alone" } else { "and all that follow" };
                    format!("{}: {kind} {first} of {calls} {which}: {fault}", self.name)
                });
                (outcome, fault)
            })
            .collect();
        let mut ends = BTreeMap::new();
        let met = outcomes.iter().filter(|(outcome, _)| outcome.failed > 0);
        met.for_each(|(outcome, _)| *ends.entry(outcome.code.unwrap_or(-1)).or_default() += 1);
        (calls, ends, outcomes.into_iter().filter_map(|(_, fault)| fault).collect())
    }
}

const SCENE: &str = "[camera]\neye = [0.0, 0.0, 9.0]\nat = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nvfov = 40.0\n
[image]\nsize = [48, 40]\n\n[[spheres]]\nfile = \"spheres.csv\"\n";

/// A scene whose spheres are in a file of their own.
fn scene() -> Files {
    let mut spheres = "x,y,z,radius,r,g,b\n".to_owned();
    for n in 0..200 {
        let [x, y, z] = [n % 10, n / 10 % 10, n / 100].map(|k| f64::from(k) - 4.5);
        spheres += &format!("{x},{y},{z},0.6,0.{},0.5,0.2\n", n % 10);
    }
    [("scene.toml", SCENE.to_owned()), ("spheres.csv", spheres)].map(|(name, text)| (name.into(), text.into())).into()
}

/// The files that a command adds, which must succeed.
fn made(shim: &Path, command: &str, before: &Files) -> Files {
    let done = run(shim, command, before, None);
    assert_eq!(done.code, Some(0), "{command}: {}", done.err);
    done.files.into_iter().filter(|(name, _)| !before.contains_key(name)).collect()
}

const RENDER: &str = "render scene.toml --backend cpu --json -o a.png --aov color,id,depth,normal=b.exr --aov distance,mask=c.npz --aov position=d.npy --aov normal=e.pfm";

const RESUME: &str =
    "render scene.toml --backend cpu --resume -o a.png --aov color,depth=b.exr --aov depth=d.npy --aov id=f.npz";

#[test]
fn a_failing_system_call_leaves_whole_files() {
    let tools = tempfile::tempdir().expect("a folder");
    let Some(shim) = shim(tools.path()) else { return };
    let shim = shim.as_path();
    let render = Case::new(shim, "render", RENDER, scene());

    // One file is whole, one has a changed byte, one is truncated, one is missing.
    let mut resumed = scene();
    resumed.extend(made(shim, &RESUME.replace(" --resume", ""), &scene()));
    let middle = resumed["d.npy"].len() / 2;
    resumed.get_mut("d.npy").expect("there")[middle] ^= 1;
    resumed.get_mut("b.exr").expect("there").truncate(1000);
    resumed.remove("f.npz");
    let resume = Case::new(shim, "resume", RESUME, resumed);

    let mut tiles = Files::new();
    for (part, png, exr) in [("1/2", "1.png", "color,depth=1.exr"), ("2/2", "2.png", "color,depth=2.exr")] {
        let command = format!("render scene.toml --backend cpu --tile {part} -o {png} --aov {exr}");
        tiles.extend(made(shim, &command, &scene()));
    }
    let merge = Case::new(shim, "merge of PNG", "merge 1.png 2.png -o whole.png", tiles.clone());
    let layers = Case::new(shim, "merge of EXR", "merge 1.exr 2.exr -o whole.exr", tiles);

    let mut rays = scene();
    rays.insert("rays.csv".into(), "0,0,9,0,0,-1\n0,0,9,0,0,0\n1,0,9,0,0,-1\n".into());
    let trace = Case::new(
        shim,
        "trace",
        "trace scene.toml --backend cpu --rays rays.csv --skip-invalid --json -o hits.npz",
        rays,
    );

    let mut faults = Vec::new();
    println!("command       kind    calls  runs by exit code");
    for case in [&render, &resume, &merge, &layers, &trace] {
        for (kind, codes) in KINDS {
            let (calls, ends, found) = case.every(shim, kind, codes);
            let ends: Vec<_> = ends.iter().map(|(code, runs)| format!("{runs} x {code}")).collect();
            println!("{:13} {kind:7} {calls:5}  {}", case.name, ends.join(", "));
            faults.extend(found);
        }
    }
    assert!(faults.is_empty(), "{} of them:\n{}", faults.len(), faults.join("\n"));
}
