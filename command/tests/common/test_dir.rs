//! The command line under test: a temporary folder to run it in, and the results of a run.

use halfline_files::write::buffers::FrameFile;
use halfline_measure::ArrayValue;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Variables that hide all adapters of the machine.
pub(crate) const NO_ADAPTER: [(&str, &str); 2] =
    [("VK_DRIVER_FILES", "no-such-driver.json"), ("WGPU_BACKEND", "vulkan")];

/// A scene of one unit sphere, its centre 3 in front of the eye.
pub(crate) const SPHERE: &str =
    "[camera]\neye = [0.0, 0.0, 0.0]\nview = [0.0, 0.0, -1.0]\nup = [0.0, 1.0, 0.0]\nvfov = 60.0\n
[image]\nsize = [40, 30]\n\n[[sphere]]\ncenter = [0.0, 0.0, -3.0]\nradius = 1.0\n";

/// The same as a wider picture in colour: rays through its corners miss the sphere.
pub(crate) const SCENE: &str = "[camera]
eye = [0.0, 0.0, 0.0]
view = [0.0, 0.0, -1.0]
up = [0.0, 1.0, 0.0]
viewport = [1.5, 1.0]

[image]
size = [45, 31]
background = [0.25, 0.5, 1.0]

[[sphere]]
center = [0.0, 0.0, -3.0]
radius = 1.0
color = [0.9, 0.4, 0.2]
";

/// The arguments of a command: one string, split at spaces, or a list.
pub(crate) trait Arguments {
    fn list(&self) -> Vec<String>;
}

impl Arguments for str {
    fn list(&self) -> Vec<String> {
        self.split_whitespace().map(str::to_owned).collect()
    }
}

impl Arguments for String {
    fn list(&self) -> Vec<String> {
        self.as_str().list()
    }
}

impl Arguments for [&str] {
    fn list(&self) -> Vec<String> {
        self.iter().map(|word| (*word).to_owned()).collect()
    }
}

impl<const N: usize> Arguments for [&str; N] {
    fn list(&self) -> Vec<String> {
        self.as_slice().list()
    }
}

impl Arguments for Vec<&str> {
    fn list(&self) -> Vec<String> {
        self.as_slice().list()
    }
}

impl Arguments for Vec<String> {
    fn list(&self) -> Vec<String> {
        self.clone()
    }
}

/// A temporary folder, and the number of parts that blocks of files are divided into.
pub(crate) struct TestDir {
    folder: tempfile::TempDir,
    parts: Option<usize>,
}

/// The result of a command: exit code, standard output, standard error.
pub(crate) struct Output {
    pub(crate) code: i32,
    pub(crate) out: Vec<u8>,
    pub(crate) err: String,
}

impl Output {
    /// The result of a process that has ended. If a signal ended it, the test fails.
    pub(crate) fn of(output: std::process::Output) -> Self {
        let err = String::from_utf8_lossy(&output.stderr).into_owned();
        let code = output.status.code().unwrap_or_else(|| panic!("{}: {err}", output.status));
        Self { code, out: output.stdout, err }
    }

    /// Standard output as text.
    pub(crate) fn text(&self) -> String {
        String::from_utf8(self.out.clone()).expect("UTF-8")
    }

    /// The JSON objects on standard output, one a line.
    pub(crate) fn json_lines(&self) -> Vec<Value> {
        self.text().lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e} in {line}"))).collect()
    }

    /// The one JSON object on standard output.
    pub(crate) fn json(&self) -> Value {
        let text = self.text();
        serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error} in {text}"))
    }
}

impl TestDir {
    /// With these files in it.
    pub(crate) fn new(files: &[(&str, &str)]) -> Self {
        let dir = Self { folder: tempfile::tempdir().expect("a temporary folder"), parts: None };
        files.iter().for_each(|(name, content)| dir.put(name, content));
        dir
    }

    /// Blocks of files are smaller by this factor, so that short files have many.
    pub(crate) fn in_parts(self, parts: usize) -> Self {
        Self { parts: Some(parts), ..self }
    }

    /// The path of a file in the folder; of the folder itself for "".
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("a file in the temporary folder");
    }

    pub(crate) fn get(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn remove(&self, name: &str) {
        fs::remove_file(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    }

    /// The names and contents of the entries, in order; a folder's content is empty.
    pub(crate) fn files(&self) -> BTreeMap<String, Vec<u8>> {
        let entries = fs::read_dir(self.folder.path()).expect("the folder").map(|entry| entry.expect("an entry"));
        entries.map(|e| (e.file_name().to_string_lossy().into(), fs::read(e.path()).unwrap_or_default())).collect()
    }

    /// `program` in the folder, without the user's own settings and with an empty standard input.
    pub(crate) fn program(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("HALFLINE_")) {
            command.env_remove(name);
        }
        // Without a desktop, whose absence a layer of Mesa would report on standard error.
        for name in ["XDG_RUNTIME_DIR", "DISPLAY", "NODEVICE_SELECT"] {
            command.env_remove(name);
        }
        command.env("XDG_CONFIG_HOME", self.folder.path()).env_remove("RUST_LOG");
        command.envs(self.parts.map(|parts| ("HALFLINE_BLOCKS", parts.to_string())));
        command.current_dir(self.folder.path()).stdin(Stdio::null());
        command
    }

    /// `halfline` with these arguments, not started yet.
    pub(crate) fn command(&self, arguments: &(impl Arguments + ?Sized)) -> Command {
        let mut command = self.program(env!("CARGO_BIN_EXE_halfline"));
        command.args(arguments.list());
        command
    }

    /// Runs halfline with these arguments and variables.
    pub(crate) fn run_with(&self, arguments: &(impl Arguments + ?Sized), environment: &[(&str, &str)]) -> Output {
        Output::of(self.command(arguments).envs(environment.iter().copied()).output().expect("halfline runs"))
    }

    pub(crate) fn run(&self, arguments: &(impl Arguments + ?Sized)) -> Output {
        self.run_with(arguments, &[])
    }

    /// Runs halfline with `input` on its standard input.
    pub(crate) fn run_fed(&self, arguments: &(impl Arguments + ?Sized), input: &[u8]) -> Output {
        let mut command = self.command(arguments);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("halfline runs");
        // A command that reads nothing may have closed its end already.
        let _ = child.stdin.take().expect("a pipe").write_all(input);
        Output::of(child.wait_with_output().expect("halfline ends"))
    }

    /// Runs a command that must succeed.
    pub(crate) fn good(&self, arguments: &(impl Arguments + ?Sized)) -> Output {
        let output = self.run(arguments);
        assert_eq!(output.code, 0, "{:?}: {}", arguments.list(), output.err);
        output
    }

    /// Renders on the CPU path, which must succeed.
    pub(crate) fn render(&self, arguments: &(impl Arguments + ?Sized)) -> Output {
        self.good(&on_cpu(arguments))
    }

    /// Runs a command that must fail with `code`, print all of `words` on standard error, print nothing else but with
    /// `--json` an object, and leave every file unchanged.
    pub(crate) fn refused_with(
        &self,
        code: i32,
        arguments: &(impl Arguments + ?Sized),
        environment: &[(&str, &str)],
        words: &[&str],
    ) {
        let (list, before) = (arguments.list(), self.files());
        let Output { code: found, out, err } = self.run_with(arguments, environment);
        assert_eq!(found, code, "{list:?}: {err}");
        let printed = String::from_utf8(out).expect("UTF-8");
        assert!(!err.contains("panicked") && !err.contains('\x1b'), "{list:?}: {err}");
        let is_note = |line: &&str| {
            let notes = ["rendering on ", "tracing on ", "warning: "].map(|note| format!("halfline: {note}"));
            notes.iter().any(|note| line.starts_with(note)) || line.contains(": falling back to the CPU")
        };
        let lines: Vec<_> = err.lines().filter(|line| !is_note(line)).collect();
        // The argument parser adds the usage; an error of the program is one line.
        let ours = lines.len() == 1 && lines[0].starts_with("halfline: ");
        assert!(ours || code == 2 && lines[0].starts_with("error: "), "{list:?}: {err}");
        if list.iter().any(|word| word == "--json") {
            let error = failure(&printed, code);
            assert!(!ours || lines[0] == format!("halfline: {error}"), "{list:?}: {err} and {printed}");
        } else {
            assert!(printed.is_empty(), "{list:?} printed {printed}");
        }
        words.iter().for_each(|word| assert!(err.contains(word), "{list:?}: no {word:?} in {err}"));
        assert!(self.files() == before, "{list:?} left something behind");
    }

    pub(crate) fn refused(&self, code: i32, arguments: &(impl Arguments + ?Sized), words: &[&str]) {
        self.refused_with(code, arguments, &[], words);
    }

    /// The same for rendering on the CPU path.
    pub(crate) fn refused_render(&self, code: i32, arguments: &(impl Arguments + ?Sized), words: &[&str]) {
        self.refused(code, &on_cpu(arguments), words);
    }

    /// The numbers of an array file, and its shape.
    pub(crate) fn array(&self, name: &str) -> (Vec<f64>, Vec<usize>) {
        let array = FrameFile::read(&self.path(name)).unwrap_or_else(|error| panic!("{error}")).buffers.remove(0).array;
        let values = (0..array.values().len()).filter_map(|k| array.values().get(k)).map(ArrayValue::to_f64).collect();
        (values, array.shape().to_vec())
    }
}

/// The message of the one object that a failure with this exit code prints with `--json`, whose kind and exit code must
/// be right.
pub(crate) fn failure(printed: &str, code: i32) -> String {
    let error = match serde_json::from_str::<Value>(printed) {
        Ok(object) if printed.ends_with("}\n") => object["error"].clone(),
        _ => panic!("no object: {printed:?}"),
    };
    let kind = match code {
        2 => "settings",
        3 => "scene",
        4 => "adapter",
        5 => "limits",
        6 => "device-lost",
        7 => "accuracy",
        8 => "io",
        130 => "interrupted",
        _ => panic!("no kind for {code}"),
    };
    assert_eq!((error["kind"].as_str(), error["exit"].as_i64()), (Some(kind), Some(code.into())), "{printed}");
    error["message"].as_str().filter(|message| !message.is_empty()).expect("a message").to_owned()
}

/// The arguments of `render` on the CPU path.
fn on_cpu(arguments: &(impl Arguments + ?Sized)) -> Vec<String> {
    ["render", "--backend", "cpu"].into_iter().map(str::to_owned).chain(arguments.list()).collect()
}
