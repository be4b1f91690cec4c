//! The promise of every option of a picture: it works, or is refused by name, in every way that the program takes: in memory, as a
//! stream that was asked for or chosen where memory is short, in parts, resumed, in tiles, in films, and through a curved lens.

use crate::amount::amount;
use crate::rng::Rng;
use crate::test_dir::{Output, TestDir};
use crate::ways_table::{self, Effect, Row, rows};
use halfline_files::write::buffers::FrameFile;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// The options that are ways themselves, or do not concern the picture of one scene.
const WAYS: [&str; 7] = ["help", "visible", "stream", "resume", "output", "adapter", "backend"];

/// The ways beside that in memory.
const ALL: [&str; 7] = ["stream", "chosen stream", "parts", "resume", "tiles", "film", "curved lens"];

/// The content of the files of a rendering, and what it printed.
type Files = BTreeMap<String, Vec<u8>>;

/// Long options in the help of a command.
fn options_of(dir: &TestDir, command: &str) -> BTreeSet<String> {
    let help = dir.good(&format!("{command} --help")).text();
    let longs = help.lines().filter_map(|line| {
        let line = line.trim_start();
        let line = line.split_once(", ").filter(|(short, _)| short.len() == 2).map_or(line, |(_, long)| long);
        let name = line.strip_prefix("--")?;
        name.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-')).next().map(str::to_owned)
    });
    longs.collect()
}

/// Words of options: each option with its values.
fn split(words: &str) -> Vec<Vec<String>> {
    let mut all: Vec<Vec<String>> = Vec::new();
    for word in words.split_whitespace().map(|word| word.replace('~', " ")) {
        match all.last_mut() {
            Some(last) if !word.starts_with("--") => last.push(word),
            _ => all.push(vec![word]),
        }
    }
    all
}

/// The name of an option in its words.
fn name(option: &[String]) -> &str {
    option[0].trim_start_matches('-').split('=').next().unwrap_or_default()
}

/// A walk of one row.
struct Walk<'a> {
    dir: &'a TestDir,
    row: &'a Row,
    /// The options that `sift` takes.
    sifted: &'a BTreeSet<String>,
    /// The exit code and the files in memory.
    memory: (i32, Files),
}

/// Whether an option works in a way; if not, it is refused there by its name. Everything else is an error, with what was said.
type Found = Result<bool, String>;

impl Walk<'_> {
    /// The words of a picture of the row's file.
    fn words(&self, options: &str) -> Vec<String> {
        split(&format!("{} {options} {}", self.row.file, self.row.outputs())).concat()
    }

    /// The same with the option, and with more words.
    fn with(&self, more: &str) -> Vec<String> {
        self.words(&format!("{} {more}", self.row.with))
    }

    /// Whether a rendering is that in memory. `also` are words by which a refusal may name the option.
    fn is_right(&self, (output, files): &(Output, Files), also: &[&str]) -> Found {
        let option = format!("--{}", self.row.option);
        let mut names = [&*option].into_iter().chain(self.row.also.iter().copied()).chain(also.iter().copied());
        if [2, 3].contains(&output.code) && names.any(|name| output.err.contains(name)) {
            return Ok(false);
        }
        let (code, expected) = &self.memory;
        if output.code != *code {
            return Err(format!("exit code {}: {}", output.code, output.err));
        }
        match expected.iter().find(|(name, bytes)| files.get(*name) != Some(*bytes)) {
            Some((name, _)) => Err(format!("{name} differs: {}", output.err)),
            None => Ok(true),
        }
    }

    /// Walks by `--stream`.
    fn stream(&self) -> Found {
        self.is_right(&run(self.dir, &self.with("--stream"), &[]), &[])
    }

    /// Walks as a stream that the program chooses: with one byte less than the frame needs, it reads the file as a stream, or ends with the code of memory.
    fn chosen_stream(&self) -> Found {
        let first = run(self.dir, &self.with(""), &[("HALFLINE_FREE", "0")]);
        let needed = ["needs about ", "may need "].iter().find_map(|before| first.0.err.split_once(before));
        let needed = needed.and_then(|(_, rest)| rest.split(' ').next());
        match needed.and_then(|bytes| bytes.parse::<u64>().ok()).filter(|_| first.0.code == 5) {
            Some(needed) => {
                let found = run(self.dir, &self.with(""), &[("HALFLINE_FREE", &(needed - 1).to_string())]);
                if found.0.code == 5 { Ok(false) } else { self.is_right(&found, &[]) }
            }
            None => self.is_right(&first, &[]),
        }
    }

    /// Walks in parts: `sift` gets the options that it takes, and the picture of its part the others. An option of `sift` is not ignored by the
    /// picture of a part that was made without it.
    fn parts(&self) -> Found {
        let [[sift, show], [bare, _]] = [&self.row.with, &self.row.base].map(|options| {
            let (sift, show): (Vec<_>, Vec<_>) =
                split(options).into_iter().partition(|of| self.sifted.contains(name(of)));
            [sift, show].map(|options| options.concat())
        });
        let outputs = split(&self.row.outputs()).concat();
        let words = ["sift", self.row.file, "--first-id", "0", "-o", "part.npz"].map(str::to_owned);
        let made = |sift: &[String]| self.dir.run(&[&words[..], sift].concat());
        let visible = ["--visible", "part.npz"].map(str::to_owned);
        let shown = |more: &[String]| run(self.dir, &[&visible[..], more, &show, &outputs].concat(), &[]);
        let sifted = made(&sift);
        if sifted.code != 0 {
            return self.is_right(&(sifted, Files::new()), &[]);
        }
        let right = self.is_right(&shown(&[]), &[])?;
        let own =
            split(&self.row.with).into_iter().find(|of| name(of) == self.row.option && self.sifted.contains(name(of)));
        match own {
            Some(own) if made(&bare).code == 0 => {
                let named = [self.row.option, "width of outlines"];
                self.is_right(&shown(&own), &named).map_err(|why| format!("of a part made without it: {why}"))?;
            }
            _ => {}
        }
        Ok(right)
    }

    /// Walks by `--resume`: over the files of a picture without the option, then over its own.
    fn resume(&self) -> Found {
        run(self.dir, &self.words(&self.row.base), &[]);
        let first = keep(self.dir, &self.with("--resume"));
        let right = self.is_right(&first, &[])?;
        if !right || first.0.code != 0 {
            return Ok(right);
        }
        let second = keep(self.dir, &self.with("--resume"));
        if !self.row.is_piped() && !self.row.with.contains("--quiet") && !second.0.err.contains("already there") {
            return Err(format!("its own file is not known: {}", second.0.err));
        }
        self.is_right(&second, &[])
    }

    /// Walks in two tiles, which are merged.
    fn tiles(&self) -> Found {
        let mut files = Files::new();
        for n in ["1", "2"] {
            let words = in_files(&self.with(&format!("--tile {n}/2")), &format!("tile{n}."));
            let tile = keep(self.dir, &words);
            if tile.0.code != 0 {
                return self.is_right(&tile, &["--tile"]);
            }
            files.extend(tile.1);
        }
        let named = self.memory.1.keys().map(|name| (name, name.replacen("p.", "tile1.", 1)));
        for (name, first) in named.filter(|(_, first)| self.dir.path(first).exists()) {
            let merged = self.dir.run(&format!("merge {first} {} -o {name}", first.replacen('1', "2", 1)));
            // What is written beside a picture is written for each tile.
            let bytes = if name.ends_with("svg") {
                self.dir.get(&first)
            } else if merged.code == 0 {
                self.dir.get(name)
            } else {
                Vec::new()
            };
            files.insert(name.clone(), bytes);
        }
        self.is_right(&(Output { code: self.memory.0, out: Vec::new(), err: "merged".into() }, files), &[])
    }

    /// Walks in films: the first of two frames of the file, the second one as it is rendered alone, and both as the pictures of a film.
    fn film(&self) -> Found {
        let film = run(self.dir, &in_files(&self.with("--frames 1-2"), "p.%d."), &[]);
        if film.0.code != 0 {
            return self.is_right(&film, &["--frames"]);
        }
        let still = |n: &str| -> Files {
            let of = |(name, bytes): (&String, &Vec<u8>)| {
                Some((format!("p.{}", name.strip_prefix(&format!("p.{n}."))?), bytes.clone()))
            };
            film.1.iter().filter_map(of).collect()
        };
        let (first, second) = (still("1"), still("2"));
        self.is_right(&(film.0, first.clone()), &[])?;
        if cfg!(unix) && self.row.outputs().starts_with("-o p.png") {
            let path = self.dir.path("bin").display().to_string();
            let words: Vec<String> = in_files(&self.with("--frames 1-2"), "p.%d.");
            let words: Vec<String> = words.iter().map(|word| word.replace("p.%d.png", "p.gif")).collect();
            let made = run(self.dir, &words, &[("PATH", &path)]);
            let stills = [&first, &second].map(|files| files.get("p.png").cloned().unwrap_or_default()).concat();
            let expected = Files::from([("p.gif".to_owned(), stills)]);
            Walk { memory: (0, expected), ..*self }.is_right(&made, &[])?;
        }
        let alone = run(self.dir, &self.with("--frames 2"), &[]);
        match second.iter().find(|(name, bytes)| alone.1.get(*name) != Some(bytes)) {
            Some((name, _)) => Err(format!("{name} of frame 2 alone differs: {}", alone.0.err)),
            None => Ok(true),
        }
    }

    /// Walks with a camera of a list whose lens has distortion, in place of the camera of the row: the option has its effect there too.
    fn curved_lens(&self) -> Found {
        // The list has camera and lens, and exact answers are within any tolerance.
        if ["vfov", "intrinsics", "hold", "tolerance"].contains(&self.row.option) {
            return Ok(true);
        }
        let through = |options: &str| {
            let is_kept = |option: &Vec<String>| {
                name(option) == self.row.option || !["eye", "at", "vfov", "cameras"].contains(&name(option))
            };
            let lens = if options.contains("--frames 2") { "--cameras curved2.json" } else { "--cameras curved.json" };
            let kept = split(options).into_iter().filter(is_kept).collect::<Vec<_>>().concat();
            run(self.dir, &[&self.words(lens)[..], &kept].concat(), &[])
        };
        let [without, with] = [&self.row.base, &self.row.with].map(|options| through(options));
        if !self.is_right(
            &(Output { code: with.0.code, out: Vec::new(), err: with.0.err.clone() }, self.memory.1.clone()),
            CURVED,
        )? {
            return Ok(false);
        }
        // What is refused without the option may be drawn with it.
        let effect =
            if without.0.code == 2 && self.row.effect == Effect::Numbers { Effect::Allows } else { self.row.effect };
        check_effect(effect, [&without, &with]).map(|()| true)
    }

    /// Walks a way.
    fn take(&self, way: &str) -> Found {
        match way {
            "tiles" | "film" if self.row.is_piped() => Ok(true),
            "stream" => self.stream(),
            "chosen stream" => self.chosen_stream(),
            "parts" => self.parts(),
            "resume" => self.resume(),
            "tiles" => self.tiles(),
            "film" => self.film(),
            _ => self.curved_lens(),
        }
    }
}

/// Words by which a curved lens refuses options: options of another camera, and a size of the lens.
const CURVED: &[&str] = &["--cameras", "a lens with a size"];

/// Words with other names of files, which begin with `p.`.
fn in_files(words: &[String], begin: &str) -> Vec<String> {
    let renamed = |word: &String| match word.strip_prefix("p.") {
        Some(rest) => format!("{begin}{rest}"),
        None => word.replace("=p.", &format!("={begin}")),
    };
    words.iter().map(renamed).collect()
}

/// Renders where no file of an earlier picture is.
fn run(dir: &TestDir, words: &[String], environment: &[(&str, &str)]) -> (Output, Files) {
    let old = dir.files().into_keys().filter(|name| name.starts_with("p.") || name.starts_with("tile"));
    old.for_each(|name| dir.remove(&name));
    let words = [&["render", "--backend", "cpu"].map(str::to_owned)[..], words].concat();
    let output = dir.run_with(&words, environment);
    let files = outputs(dir, &words, &output);
    (output, files)
}

/// Renders over the files that are there.
fn keep(dir: &TestDir, words: &[String]) -> (Output, Files) {
    let words = [&["render", "--backend", "cpu"].map(str::to_owned)[..], words].concat();
    let output = dir.run(&words);
    let files = outputs(dir, &words, &output);
    (output, files)
}

/// The files of a picture, and its bytes on standard output.
fn outputs(dir: &TestDir, words: &[String], output: &Output) -> Files {
    let mut files: Files = dir.files().into_iter().filter(|(name, _)| name.starts_with("p.")).collect();
    if words.iter().any(|word| word.ends_with("=-")) {
        files.insert("standard output".into(), output.out.clone());
    }
    files
}

/// Whether files have other numbers: pixels, without what is said about them.
fn has_other_numbers(a: &Files, b: &Files) -> bool {
    a.len() != b.len()
        || a.iter().any(|(name, bytes)| {
            let Some(other) = b.get(name) else { return true };
            match [bytes, other].map(|bytes| FrameFile::from_bytes(bytes, name)) {
                [Ok(one), Ok(two)] => one.buffers != two.buffers,
                _ => bytes != other,
            }
        })
}

/// Checks that a rendering with an option differs from one without it as its row says.
fn check_effect(effect: Effect, [without, with]: [&(Output, Files); 2]) -> Result<(), String> {
    let codes = [without.0.code, with.0.code];
    let is_there = match effect {
        Effect::Numbers => codes == [0, 0] && has_other_numbers(&without.1, &with.1),
        Effect::Bytes => codes == [0, 0] && without.1 != with.1,
        Effect::Nothing => codes == [0, 0] && without.1 == with.1,
        Effect::Allows => codes[0] != 0 && codes[1] == 0,
        Effect::Fails => codes[0] == 0 && codes[1] != 0,
        Effect::Any => [0, 2, 3].contains(&codes[1]),
    };
    let message = || format!("no effect: {effect:?}, {codes:?}: {}{}", without.0.err, with.0.err);
    if is_there { Ok(()) } else { Err(message()) }
}

/// The ways of a row that are wrong, and the number of those in which the option works.
fn walk(dir: &TestDir, row: &Row, sifted: &BTreeSet<String>, ways: &[&str]) -> (Vec<String>, usize) {
    let walk = Walk { dir, row, sifted, memory: (0, Files::new()) };
    let [without, with] = [&row.base, &row.with].map(|options| run(dir, &walk.words(options), &[]));
    if let Err(why) = check_effect(row.effect, [&without, &with]) {
        return (vec![format!("{} in memory: {why}", row.with)], 0);
    }
    let excludes = row.effect == Effect::Any && with.0.code != 0;
    let walk = Walk { memory: (with.0.code, with.1), ..walk };
    let (mut wrong, mut works) = (Vec::new(), 0);
    for way in ways.iter().filter(|way| !excludes && (row.effect != Effect::Any || **way != "curved lens")) {
        match walk.take(way) {
            Ok(does) => works += usize::from(does),
            Err(why) => wrong.push(format!("{}, {way}: {}", row.with, why.trim_end())),
        }
    }
    (wrong, works)
}

/// Walks all rows, each in so many ways, other ones from row to row. Returns the number of ways in which the options work.
fn walk_all(rows: &[Row], ways: usize) -> usize {
    let sifted = options_of(&TestDir::new(&[]), "sift");
    let (next, found) = (AtomicUsize::new(0), Mutex::new((Vec::new(), 0)));
    let threads = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let dir = ways_table::dir();
                loop {
                    let n = next.fetch_add(1, Ordering::Relaxed);
                    let Some(row) = rows.get(n) else { break };
                    let turned: Vec<&str> = ALL.into_iter().cycle().skip(n * ways % ALL.len()).take(ways).collect();
                    let (wrong, works) = walk(&dir, row, &sifted, &turned);
                    let mut found = found.lock().expect("no panic");
                    found.0.extend(wrong);
                    found.1 += works;
                }
            });
        }
    });
    let (wrong, works) = found.into_inner().expect("no panic");
    println!("{} rows in {ways} ways each: {works} work, the others are refused", rows.len());
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
    works
}

#[test]
fn every_option_works_or_is_refused_in_every_way() {
    let rows = rows();
    let known: BTreeSet<String> = rows.iter().map(|row| row.option.to_owned()).chain(WAYS.map(str::to_owned)).collect();
    assert_eq!(options_of(&TestDir::new(&[]), "render"), known, "a row for each option");
    let ways = amount("ways of an option", [2, ALL.len(), ALL.len()]);
    let works = walk_all(&rows, ways);
    assert!(2 * works > rows.len() * ways, "most work: {works}");
}

#[test]
fn drawn_options_together_work_or_are_refused_in_every_way() {
    let (rows, mut rng) = (rows(), Rng::new(0x5eed_0107));
    let drawn = (0..amount("drawn options together", [12, 24, 400])).map(|_| ways_table::drawn(&mut rng, &rows));
    let drawn: Vec<Row> = drawn.collect();
    assert!(walk_all(&drawn, ALL.len()) > drawn.len(), "some work");
}

/// A stream that the program chooses has the light of memory, or it is not chosen, and the error of memory says what makes it one. The list
/// of cameras beside its picture is not written over the one that is read.
#[test]
fn a_stream_that_the_program_chooses_never_changes_the_answer() {
    let dir = ways_table::dir();
    let with = |options: &str, free: u64| {
        let words = format!("render f.xyz --backend cpu --size 12x9 {options}");
        dir.run_with(&words, &[("HALFLINE_FREE", &free.to_string())])
    };
    for (options, is_chosen) in [
        ("-o p.png", false),
        ("-o p.png --samples 9", false),
        ("-o p.png --look plain", true),
        ("-o p.png --shade flat", true),
        ("--aov id=p.npy", true),
        ("-o p.png --look plain --cameras one.json", true),
        ("-o p.png --look plain --cameras one.json --label {count}", false),
        ("-o p.png --look plain --frames 2", false),
        ("-o p.png --look plain --frames 2 --eye 9,7,12 --at 2,2,2", true),
        ("-o p.png --look plain --frames 2 --spin 5 --eye 9,7,12 --at 2,2,2", false),
        ("-o p.png --look plain --opacity 0.5 --layers 2", false),
        ("-o p.png --look plain --mark kind~a=x", false),
        ("-o p.%d.png --look plain --frames 1-2", false),
    ] {
        let options = options.replace('~', " ");
        let words = |free: u64| with(&options, free);
        let Output { code, err, .. } = words(0);
        let needed = err.split_once("needs about ").and_then(|(_, rest)| rest.split(' ').next()?.parse::<u64>().ok());
        let Some(needed) = needed.filter(|_| code == 5) else {
            assert!(!is_chosen && code == 2, "{options}: {code}: {err}");
            continue;
        };
        let Output { code, err, .. } = words(needed - 1);
        assert_eq!(code, if is_chosen { 0 } else { 5 }, "{options}: {err}");
        assert_eq!(err.contains("read as a stream (see --stream)"), is_chosen, "{options}: {err}");
        let is_soft = !options.contains("--look") && !options.contains("--shade");
        assert_eq!(err.contains("add --look plain: the file is then read as a stream"), is_soft && !is_chosen, "{err}");
    }
    dir.put("cameras.json", dir.get("one.json"));
    for way in ["", "--stream"] {
        dir.refused_render(
            2,
            &format!("f.xyz --look plain --cameras cameras.json -o p.png {way}"),
            &["cameras.json is an input"],
        );
    }
    let curved = "f.xyz --look plain --cameras curved.json -o p.png --stream";
    dir.refused_render(2, curved, &["--stream: the rays of a curved lens need all spheres in memory"]);
}
