//! A folder to work in with the command, away from the settings of whoever runs the tests.

use halfline::measure::{Array, Number};
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// A temporary folder.
pub(crate) struct Desk(tempfile::TempDir);

/// What a command left: exit code, standard output, standard error.
pub(crate) struct Said {
    pub(crate) code: i32,
    pub(crate) out: Vec<u8>,
    pub(crate) err: String,
}

impl Desk {
    /// With these files in it.
    pub(crate) fn new(files: &[(&str, &str)]) -> Self {
        let desk = Self(tempfile::tempdir().expect("a temporary folder"));
        files.iter().for_each(|(name, content)| desk.put(name, content));
        desk
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("a file in the temporary folder");
    }

    pub(crate) fn get(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The names of the files here, and their content.
    pub(crate) fn files(&self) -> BTreeMap<String, Vec<u8>> {
        let entries = fs::read_dir(self.0.path()).expect("the folder").map(|entry| entry.expect("an entry"));
        entries.map(|e| (e.file_name().to_string_lossy().into(), fs::read(e.path()).unwrap_or_default())).collect()
    }

    /// Runs halfline with words, variables and standard input; the words are parted by spaces.
    pub(crate) fn run_with(&self, words: &str, environment: &[(&str, &str)], input: &[u8]) -> Said {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halfline"));
        command.args(words.split_whitespace()).current_dir(self.0.path());
        for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("HALFLINE_")) {
            command.env_remove(name);
        }
        command.env("XDG_CONFIG_HOME", self.0.path()).env_remove("RUST_LOG").envs(environment.iter().copied());
        let piped = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = piped.spawn().expect("halfline runs");
        // Who reads nothing may have closed it already.
        let _ = child.stdin.take().expect("a pipe").write_all(input);
        let output = child.wait_with_output().expect("halfline ends");
        let err = String::from_utf8_lossy(&output.stderr).into_owned();
        Said {
            code: output.status.code().unwrap_or_else(|| panic!("{}: {err}", output.status)),
            out: output.stdout,
            err,
        }
    }

    pub(crate) fn run(&self, words: &str) -> Said {
        self.run_with(words, &[], b"")
    }

    /// Runs what must succeed, on the CPU path.
    pub(crate) fn render(&self, words: &str) -> Said {
        let said = self.run(&format!("render --backend cpu {words}"));
        assert_eq!(said.code, 0, "{words}: {}", said.err);
        said
    }

    /// Runs what must end with `code`, say all of `told`, print nothing and leave everything as it was.
    pub(crate) fn refused_with(&self, code: i32, words: &str, environment: &[(&str, &str)], told: &[&str]) {
        let before = self.files();
        let said = self.run_with(&format!("render --backend cpu {words}"), environment, b"");
        assert_eq!(said.code, code, "{words}: {}", said.err);
        assert!(said.out.is_empty() && !said.err.contains("panicked"), "{words}: {}", said.err);
        told.iter().for_each(|told| assert!(said.err.contains(told), "{words}: no {told:?} in {}", said.err));
        assert!(self.files() == before, "{words} left something behind");
    }

    pub(crate) fn refused(&self, code: i32, words: &str, told: &[&str]) {
        self.refused_with(code, words, &[], told);
    }

    /// The numbers of an array file, and its shape.
    pub(crate) fn array(&self, name: &str) -> (Vec<f64>, Vec<usize>) {
        let array = Array::read(&self.path(name)).unwrap_or_else(|error| panic!("{error}"));
        let values = (0..array.values().len()).filter_map(|k| array.values().get(k)).map(Number::to_f64).collect();
        (values, array.shape().to_vec())
    }
}
