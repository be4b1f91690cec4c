//! Where options come from besides the command line: a variable of the environment, and a configuration file.
//!
//! A flag beats the variable `HALFLINE_NAME`, which beats the file's `name`, which beats the default. The file is
//! `$HALFLINE_CONFIG`, or else `halfline/config.toml` in `$XDG_CONFIG_HOME` (`~/.config`), if it is there.

use clap::builder::BoolishValueParser;
use clap::{Arg, ArgAction, Command};
use halfline::error::{Error, Place, Result};
use halfline::quote::shortened;
use std::collections::BTreeMap;
use std::env;
use std::fs::File;
use std::io::Read;
use std::path::PathBuf;

/// The options that may be set so: what a user or a machine always wants, not what one picture shows.
const NAMES: [&str; 20] = [
    "accuracy",
    "adapter",
    "backend",
    "background",
    "bits",
    "map",
    "method",
    "no-return",
    "preview",
    "progress",
    "radii",
    "radius-scale",
    "samples",
    "search",
    "seed",
    "shade",
    "size",
    "tolerance",
    "transparent",
    "unit",
];

/// The commands that they are set for; what `compare` tolerates is a judgement, which a file of preferences must not
/// soften.
const COMMANDS: [&str; 3] = ["render", "plan", "measure"];

/// Bytes of a configuration file, many times as many as all options take.
const LONGEST: u64 = 1 << 16;

/// Whether a command takes options from the file.
pub(super) fn is_configured(command: &str) -> bool {
    COMMANDS.contains(&command)
}

/// The configuration file's words by the options' names.
#[derive(Debug, Default)]
pub(super) struct Config(BTreeMap<String, Word>);

/// What a file says of an option, and where.
#[derive(Debug)]
struct Word {
    text: String,
    place: Place,
}

impl Config {
    /// Of this process.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that is named and cannot be read, [`Error::Settings`] with the place of what cannot be
    /// meant.
    pub(super) fn load() -> Result<Self> {
        let named = env::var_os("HALFLINE_CONFIG").filter(|name| !name.is_empty()).map(PathBuf::from);
        let home = || Some(PathBuf::from(env::var_os("HOME")?).join(".config"));
        let folder = || env::var_os("XDG_CONFIG_HOME").filter(|name| !name.is_empty()).map(PathBuf::from).or_else(home);
        let usual = || folder().map(|folder| folder.join("halfline/config.toml")).filter(|path| path.is_file());
        let Some(path) = named.or_else(usual) else { return Ok(Self::default()) };
        let mut text = Vec::new();
        let opened = File::open(&path).and_then(|file| file.take(LONGEST + 1).read_to_end(&mut text));
        opened.map_err(|e| Error::read(&path, e))?;
        if text.len() as u64 > LONGEST {
            let problem = format!("{}: a configuration file of more than {LONGEST} bytes", path.display());
            return Err(Error::Limits { problem, mend: "name a smaller one in HALFLINE_CONFIG".into() });
        }
        let text = String::from_utf8(text).map_err(|_| {
            Error::settings(format!("{}: the file is no UTF-8 text", path.display()), "save it as UTF-8")
        })?;
        Self::parse(&text, &path.display().to_string())
    }

    fn parse(text: &str, file: &str) -> Result<Self> {
        let place = |start: usize| Place::file(file).at_byte(text, start);
        let fail = |start: usize, problem: &str, mend: String| wrong(&place(start), problem, mend);
        let table = toml::de::DeTable::parse(text).map_err(|e| {
            let message = e.message().lines().collect::<Vec<_>>().join(", ");
            fail(e.span().map_or(0, |span| span.start), &message, "mend the TOML there".into())
        })?;
        let mut words = BTreeMap::new();
        for (key, value) in table.into_inner() {
            let name = key.get_ref().replace('_', "-");
            if !NAMES.contains(&name.as_str()) {
                let problem = format!("`{}` is no option that a file may set", shortened(key.get_ref(), 40));
                return Err(fail(key.span().start, &problem, format!("the options are {}", NAMES.join(", "))));
            }
            let start = value.span().start;
            let word = match value.into_inner() {
                toml::de::DeValue::String(text) => text.into_owned(),
                toml::de::DeValue::Integer(number) => number.to_string(),
                toml::de::DeValue::Float(number) => number.to_string(),
                toml::de::DeValue::Boolean(word) => word.to_string(),
                _ => {
                    return Err(fail(
                        start,
                        "the value is no word, number or truth",
                        "write it as on the command line".into(),
                    ));
                }
            };
            words.insert(name, Word { text: word, place: place(start) });
        }
        Ok(Self(words))
    }

    /// The command whose options know of the environment and of this file.
    ///
    /// # Errors
    /// [`Error::Settings`] with the place of a word that its option does not take.
    pub(super) fn apply(&self, command: Command) -> Result<Command> {
        let mut fault = Ok(());
        let mut option = |argument: Arg| {
            let (argument, checked) = self.option(argument);
            fault = std::mem::replace(&mut fault, Ok(())).and(checked);
            argument
        };
        let known = COMMANDS
            .into_iter()
            .fold(command, |command, name| command.mut_subcommand(name, |part| part.mut_args(&mut option)));
        fault.map(|()| known)
    }

    fn option(&self, argument: Arg) -> (Arg, Result<()>) {
        let Some(name) = argument.get_long().filter(|name| NAMES.contains(name)).map(str::to_owned) else {
            return (argument, Ok(()));
        };
        // People write 1 and yes into variables too.
        let argument = match argument.get_action() {
            ArgAction::SetTrue => argument.value_parser(BoolishValueParser::new()),
            _ => argument,
        };
        let argument = argument.env(format!("HALFLINE_{}", name.to_uppercase().replace('-', "_")));
        // Help names the variable, not what it holds: a manual is the same on every machine.
        let argument = argument.hide_env_values(true);
        match self.0.get(&name) {
            Some(word) => match word.check(&name, &argument) {
                Ok(()) => (argument.default_value(word.text.clone()), Ok(())),
                fault => (argument, fault),
            },
            None => (argument, Ok(())),
        }
    }
}

impl Word {
    /// Whether the option takes it: clap would say what is wrong, but not where.
    fn check(&self, name: &str, argument: &Arg) -> Result<()> {
        let alone = Arg::new("word").value_parser(argument.get_value_parser().clone()).allow_hyphen_values(true);
        let taken = Command::new("config").no_binary_name(true).arg(alone).try_get_matches_from([&self.text]);
        taken.map(drop).map_err(|error| {
            let why = std::error::Error::source(&error).map_or_else(String::new, |why| format!(": {why}"));
            let problem = format!("`{}` is no value of {name}{why}", shortened(&self.text, 40));
            wrong(&self.place, &problem, format!("write what --{name} takes on the command line"))
        })
    }
}

fn wrong(place: &Place, problem: &str, mend: String) -> Error {
    Error::settings(format!("{place}: {problem}"), mend)
}

#[cfg(test)]
mod tests {
    use super::super::Arguments;
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn a_flag_overrides_the_file() {
        let config = Config::parse("backend = \"cpu\"\nsearch = \"all\"\nradius_scale = 2\n", "c.toml").expect("good");
        let of = |arguments: &[&str], id: &str| {
            let matches =
                config.apply(Arguments::command()).expect("words").try_get_matches_from(arguments).expect("good");
            let raw = matches.subcommand().expect("render").1.get_raw(id).expect("a value").next().expect("one");
            raw.to_string_lossy().into_owned()
        };
        let bare = ["halfline", "render", "a.toml", "-o", "a.png"];
        assert_eq!((of(&bare, "backend"), of(&bare, "radius_scale")), ("cpu".into(), "2".into()));
        let flag = [&bare[..], &["--backend", "gpu"]].concat();
        assert_eq!((of(&flag, "backend"), of(&flag, "search")), ("gpu".into(), "all".into()));
    }

    #[test]
    fn an_invalid_value_in_the_file_is_refused_at_its_place() {
        for (text, place) in [
            ("backend = \"cpu\"\neye = [0, 0, 1]\n", "c.toml:2:1"),
            ("size = [1, 2]\n", "c.toml:1:8"),
            ("backend = \n", "c.toml:1:"),
        ] {
            let error = Config::parse(text, "c.toml").expect_err(text).to_string();
            assert!(error.contains(place), "{error}");
        }
    }
}
