//! The options that the command line of `halfline view` gives, and the command that renders a picture of the page with them.

use super::lens;
use crate::config::Config;
use crate::inset_args::joined;
use crate::option_table::{NO_VIEW, PAGE, has, ids_with};
use crate::process::all_arguments;
use clap::parser::{RawValues, ValueSource};
use clap::{Arg, ArgAction, ArgMatches, Command};
use halfline::error::{Error, Result};
use halfline_viewer::{FrameRequest, Lens, LensName, Mode, Options, Pose};
use std::ffi::{OsStr, OsString};

/// The colour of spheres that are selected on the page, and of the others.
const SELECTED: &str = "darkorange";
const OTHERS: &str = "silver";

/// An option of the command: its identifier and its value; a flag has none.
pub type WrittenOption = (String, Option<OsString>);

/// An option with its values as they were typed; a flag has none.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GivenOption {
    /// Its identifier in the definition of the command.
    pub(super) id: String,
    long: String,
    value: Option<OsString>,
}

/// The scene file and the options that hold for every picture of the page.
#[derive(Debug, Clone)]
pub(crate) struct Given {
    pub(super) scene: OsString,
    options: Vec<GivenOption>,
    /// The options of the camera with which the page begins.
    camera: Vec<GivenOption>,
    /// Options from the environment and the configuration file. The command reads them by itself; Python does not.
    preferences: Vec<GivenOption>,
    /// The frame with which it begins, if one is typed.
    pub(super) frame: Option<u64>,
}

impl Given {
    /// The options that are typed for `command`, as [`Given::of`], and all that clap found. `own` are those that pictures of the page do not
    /// have.
    ///
    /// # Errors
    /// [`Error::Settings`] for an option that a page does not have, with this mend, and errors of the configuration file.
    pub(crate) fn typed(command: &Command, own: &[&str], mend: &str) -> Result<(Self, ArgMatches)> {
        // The first word is the name of the command, here the name of the program.
        let words = joined(all_arguments().iter().skip(1).cloned());
        let matches = command.clone().try_get_matches_from(words);
        let help = format!("use halfline {} --help", command.get_name());
        let matches = matches.map_err(|error| Error::settings(error.to_string(), help))?;
        let refused = ids_with(NO_VIEW).filter(|id| !own.contains(id));
        if let Some(id) = refused.into_iter().find(|id| matches.value_source(id) == Some(ValueSource::CommandLine)) {
            let long = command.get_arguments().find(|arg| arg.get_id() == id).and_then(Arg::get_long).unwrap_or(id);
            return Err(Error::settings(format!("--{long} is an option of pictures in files"), mend));
        }
        Ok((Self::of(command, &matches, own, Config::load()?.preferences())?, matches))
    }

    /// The options that were typed for `command`, by `matches`, without those named `own`. Options that the page sets
    /// are kept apart. `preferences` come from the environment and the configuration file, which every command reads by
    /// itself, so that they are no words of this one.
    ///
    /// # Errors
    /// [`Error::Settings`] for several frames.
    fn of(command: &Command, matches: &ArgMatches, own: &[&str], preferences: Vec<(String, OsString)>) -> Result<Self> {
        let preferences = preferences.into_iter().map(|(id, value)| GivenOption::new(&id, Some(value))).collect();
        let mut given =
            Self { scene: OsString::new(), options: Vec::new(), camera: Vec::new(), preferences, frame: None };
        for arg in command.get_arguments() {
            let id = arg.get_id().as_str();
            let is_typed = matches.value_source(id) == Some(ValueSource::CommandLine);
            if !is_typed || own.contains(&id) {
                continue;
            }
            match arg.get_long() {
                None => given.scene = matches.get_raw(id).and_then(|mut raw| raw.next()).unwrap_or_default().into(),
                Some(_) if id == "frames" => given.frame = typed_frame(matches.get_raw(id))?,
                Some(long) if has(id, PAGE) => given.camera.extend(typed(arg, long, matches)),
                Some(long) => given.options.extend(typed(arg, long, matches)),
            }
        }
        Ok(given)
    }

    /// A scene with options by their identifiers. The command has one option for edges of the cell that are drawn at the
    /// reading and at the rendering.
    pub(crate) fn of_options(scene: OsString, options: &[WrittenOption]) -> Self {
        let option = |(id, value): &WrittenOption| match GivenOption::new(id, value.clone()) {
            edges if id == "outline" => GivenOption { long: "cell".into(), ..edges },
            option => option,
        };
        let options = options.iter().map(option).collect();
        Self { scene, options, camera: Vec::new(), preferences: Vec::new(), frame: None }
    }

    /// The options that hold for every picture.
    pub(crate) fn options(&self) -> &[GivenOption] {
        &self.options
    }

    /// The options of the picture with which the page begins: those that are typed, with all frames of the file.
    pub(super) fn initial(&self) -> Vec<GivenOption> {
        self.options.iter().chain(&self.camera).cloned().chain([all_frames()]).collect()
    }

    /// The options of a picture in the order of the command: given options, options of the page, the colours of a selection, the camera.
    pub(super) fn options_of(&self, request: &FrameRequest) -> Vec<GivenOption> {
        let FrameRequest { camera, size, frame, select, options, .. } = request;
        let mut options = self.styled(select.as_deref(), options);
        let mut set = |id: &str, value: String| {
            options.retain(|option| option.id != id);
            options.push(GivenOption::new(id, Some(value.into())));
        };
        if let Some(frame) = frame {
            set("frames", frame.to_string());
        }
        let Pose { eye, at, up, lens } = camera;
        for (id, vector) in [("eye", eye), ("at", at), ("up", up)] {
            set(id, vector.map(|x| x.to_string()).join(","));
        }
        for (id, value) in lens::options(lens, *size, false) {
            set(id, value.unwrap_or_default());
        }
        set("size", format!("{}x{}", size[0], size[1]));
        options
    }

    /// The same options, before them options of environment and configuration that they do not replace.
    pub(super) fn with_preferences(&self, options: Vec<GivenOption>) -> Vec<GivenOption> {
        let has = |id: &str| options.iter().any(|option| option.id == id);
        let is_replaced = |id: &str| match id {
            // Each of the two replaces the other.
            "background" | "transparent" => has("background") || has("transparent"),
            id => has(id),
        };
        let kept = self.preferences.iter().filter(|preference| !is_replaced(&preference.id));
        kept.cloned().chain(options.iter().cloned()).collect()
    }

    /// The options of a picture that is framed: the direction, the lens and the size of a request, and what it selects as the
    /// focus.
    pub(super) fn fitted(&self, request: &FrameRequest) -> Vec<GivenOption> {
        let FrameRequest { camera: Pose { eye, at, up, lens }, size, select, .. } = request;
        let mut options = self.options.clone();
        let mut set = |id: &str, value: Option<String>| options.push(GivenOption::new(id, value.map(OsString::from)));
        let vector = |vector: [f64; 3]| Some(vector.map(|x| x.to_string()).join(","));
        set("view", vector([0, 1, 2].map(|k| at[k] - eye[k])));
        set("up", vector(*up));
        lens::options(lens, *size, true).into_iter().for_each(|(id, value)| set(id, value));
        match (lens, select) {
            // Shows all whatever it frames.
            (Lens::Named(lens), _) if lens.name == LensName::Equirectangular => {}
            (_, Some(selection)) => set("focus", Some(selection.clone())),
            (_, None) => set("fit", None),
        }
        set("size", Some(format!("{}x{}", size[0], size[1])));
        options
    }

    /// The options that all frames of the file are read with, for pictures with these colours.
    pub(super) fn reading(&self, select: Option<&str>, options: &Options) -> Vec<GivenOption> {
        let mut options = self.styled(select, options);
        options.push(all_frames());
        options
    }

    /// The options that are typed, with options of the page and the colours of a selection.
    fn styled(&self, select: Option<&str>, options: &Options) -> Vec<GivenOption> {
        let mut all = self.options.clone();
        set(&mut all, options);
        if let Some(selection) = select {
            for value in [format!("not ({selection})={OTHERS}"), format!("({selection})={SELECTED}")] {
                all.push(GivenOption::new("color", Some(value.into())));
            }
        }
        all
    }

    /// The words of `halfline render` with these options, without an output.
    pub(crate) fn words(&self, options: &[GivenOption]) -> Vec<OsString> {
        let scene = match self.scene.as_encoded_bytes().first() {
            // A file whose name looks like an option.
            Some(b'-') => [OsStr::new("./"), &self.scene].into_iter().collect(),
            _ => self.scene.clone(),
        };
        ["render".into(), scene].into_iter().chain(options.iter().map(GivenOption::word)).collect()
    }

    /// The words of the command that renders the picture of a request.
    pub(super) fn words_of(&self, request: &FrameRequest) -> Vec<OsString> {
        let mut words = self.words(&self.options_of(request));
        let output = match request.mode {
            Mode::Svg => "view.svg".into(),
            Mode::Pdf => "view.pdf".into(),
            _ => self.output(),
        };
        words.extend(["-o".into(), output]);
        words
    }

    /// The name of the file that the copied command writes: never the name of the scene.
    pub(super) fn output(&self) -> OsString {
        match std::path::Path::new(&self.scene).file_stem() {
            Some(stem) => [stem, OsStr::new("-view.png")].into_iter().collect(),
            None => "view.png".into(),
        }
    }
}

impl GivenOption {
    /// An option with the name of its identifier.
    pub(super) fn new(id: &str, value: Option<OsString>) -> Self {
        Self { id: id.to_owned(), long: id.replace('_', "-"), value }
    }

    /// Its name as it is typed.
    pub(super) fn flag(&self) -> String {
        format!("--{}", self.long)
    }

    /// Its identifier and its value.
    pub(super) fn written(&self) -> WrittenOption {
        (self.id.clone(), self.value.clone())
    }

    /// Its value as text; empty for a flag.
    pub(super) fn text(&self) -> String {
        self.value.as_ref().map(|value| value.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// The option as one word, which no value can be taken from.
    fn word(&self) -> OsString {
        let mut word = OsString::from(self.flag());
        if let Some(value) = &self.value {
            word.push("=");
            word.push(value);
        }
        word
    }
}

/// Sets options of the page in place of those that are given: planes and opacities are added to them, a column brings its own range,
/// and a map is left out where no column has it.
fn set(given: &mut Vec<GivenOption>, options: &Options) {
    for (id, values) in options {
        let is_replaced = |before: &GivenOption| match (id.as_str(), before.id.as_str()) {
            ("cut" | "clip" | "opacity", _) => false,
            ("color_by", "range" | "log") | ("background", "transparent") => true,
            ("color_by", "color") => !before.text().contains('='),
            (id, before) => id == before,
        };
        given.retain(|before| !is_replaced(before));
        given.extend(values.iter().map(|value| GivenOption::new(id, Some(value.into()))));
    }
    if !given.iter().any(|option| option.id == "color_by" && option.text() != "element") {
        given.retain(|option| option.id != "map");
    }
}

/// The frame of `--frames`.
fn typed_frame(raw: Option<RawValues<'_>>) -> Result<Option<u64>> {
    let number = raw.and_then(|mut raw| raw.next()?.to_str()?.parse().ok()).filter(|number| *number > 0);
    let problem = "a page shows all frames of the file, and --frames names the first one that it shows";
    number.map(Some).ok_or_else(|| Error::settings(problem, "use one number, such as --frames 2"))
}

fn all_frames() -> GivenOption {
    GivenOption::new("frames", Some("1-".into()))
}

/// An option each time that it was typed.
fn typed(arg: &Arg, long: &str, matches: &ArgMatches) -> Vec<GivenOption> {
    let id = arg.get_id().as_str();
    let option = |value| GivenOption { id: id.to_owned(), long: long.to_owned(), value };
    if matches!(arg.get_action(), ArgAction::SetTrue) {
        return vec![option(None)];
    }
    let occurrences = matches.get_raw_occurrences(id).into_iter().flatten();
    occurrences.map(|mut occurrence| option(occurrence.next_back().map(OsStr::to_os_string))).collect()
}

/// The words as a line for a POSIX shell.
///
/// # Errors
/// [`Error::Settings`] for a word that no line can have.
pub(super) fn line(words: &[OsString]) -> Result<String> {
    let words = words.iter().map(|word| {
        let problem = "the command has a name that is not UTF-8 and ends with a line break";
        quoted(word).ok_or_else(|| Error::settings(problem, "rename the file"))
    });
    let words = std::iter::once(Ok("halfline".to_owned())).chain(words);
    Ok(words.collect::<Result<Vec<_>>>()?.join(" "))
}

/// A word for a POSIX shell: as it is where no character has a meaning there, else in single quotes; by its bytes where it is
/// not UTF-8. `None` where a shell would take the line break from the end of the bytes.
fn quoted(word: &OsStr) -> Option<String> {
    let Some(word) = word.to_str() else {
        let byte = |byte: &u8| match byte {
            byte if byte.is_ascii_alphanumeric() || b"-_./,=".contains(byte) => char::from(*byte).to_string(),
            byte => format!("\\0{byte:03o}"),
        };
        let bytes: String = word.as_encoded_bytes().iter().map(byte).collect();
        return (!bytes.ends_with("\\0012")).then(|| format!("\"$(printf %b '{bytes}')\""));
    };
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=:+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return Some(word.to_owned());
    }
    Some(format!("'{}'", word.replace('\'', r"'\''")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn printed(word: &OsStr) -> Vec<u8> {
        let line = format!("printf %s {}", quoted(word).expect("a word"));
        std::process::Command::new("sh").arg("-c").arg(line).output().expect("a shell").stdout
    }

    #[test]
    fn a_shell_reads_a_quoted_word_back() {
        for word in
            ["", "a b", "it's", "$HOME", "`x`", "\"", "a\\b", "*", "~", "é", "--color=(a)=b", "a\nb", "plain-1.5,2"]
        {
            assert_eq!(printed(word.as_ref()), word.as_bytes());
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_word_that_is_not_text_is_quoted_by_its_bytes() {
        use std::os::unix::ffi::OsStrExt;
        for word in [&b"a\xff.csv"[..], b"\xff", b"-%d\xc3 '$\\0101`\"\n7", b"--hide=\xe9 a=1"] {
            let line = quoted(OsStr::from_bytes(word)).expect("a word");
            assert!(line.is_ascii() && printed(OsStr::from_bytes(word)) == word, "{line}");
        }
        assert_eq!(quoted(OsStr::from_bytes(b"\xff\n")), None);
        line(&[OsStr::from_bytes(b"\xff\n").to_owned()]).expect_err("no line");
    }
}
