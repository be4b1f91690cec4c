//! Sources of options besides the command line: environment variables and a configuration file.
//!
//! A flag overrides the variable `HALFLINE_NAME`, which overrides the file's `name`, which overrides the default. The
//! file is `$HALFLINE_CONFIG`, or else `halfline/config.toml` in `$XDG_CONFIG_HOME` (`~/.config`), if it exists.

use super::option_table::{CONFIG, has, ids_with};
use clap::builder::BoolishValueParser;
use clap::{Arg, ArgAction, Command};
use halfline::error::{Error, Place, Result};
use halfline::quote::shortened;
use std::collections::BTreeMap;
use std::env;
use std::ffi::OsString;
use std::fs::File;
use std::io::Read;
use std::path::PathBuf;

/// The commands that they apply to. The tolerance of `compare` is a test criterion, which a file of preferences must
/// not relax.
const COMMANDS: [&str; 7] = ["render", "plan", "page", "sift", "measure", "trace", "view"];

/// The most bytes of a configuration file, many times the length of all options.
const LONGEST: u64 = 1 << 16;

/// Whether a command uses the file.
pub(super) fn is_configured(command: &str) -> bool {
    COMMANDS.contains(&command)
}

/// The values of the configuration file by option name.
#[derive(Debug, Default)]
pub(super) struct Config(BTreeMap<String, ConfigValue>);

/// The value of an option and its place in the file.
#[derive(Debug)]
struct ConfigValue {
    text: String,
    place: Place,
}

impl Config {
    /// The configuration of this process.
    ///
    /// # Errors
    /// [`Error::Io`] for a named file that cannot be read, [`Error::Settings`] with the place of an invalid entry.
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
            let problem = format!("{}: the configuration file has more than {LONGEST} bytes", path.display());
            return Err(Error::Limits { problem, mend: "use a smaller one in HALFLINE_CONFIG".into() });
        }
        let text = String::from_utf8(text).map_err(|_| {
            Error::settings(format!("{}: the file is not UTF-8 text", path.display()), "save it as UTF-8")
        })?;
        Self::parse(&text, &path.display().to_string())
    }

    fn parse(text: &str, file: &str) -> Result<Self> {
        let place = |start: usize| Place::file(file).at_byte(text, start);
        let fail = |start: usize, problem: &str, mend: String| wrong(&place(start), problem, mend);
        let table = toml::de::DeTable::parse(text).map_err(|e| {
            let message = e.message().lines().collect::<Vec<_>>().join(", ");
            fail(e.span().map_or(0, |span| span.start), &message, "correct the TOML there".into())
        })?;
        let mut words = BTreeMap::new();
        for (key, value) in table.into_inner() {
            let name = key.get_ref().replace('_', "-");
            if !is_preference(&name) {
                let problem = format!("`{}` is not an option that a file may set", shortened(key.get_ref(), 40));
                let mut all: Vec<String> = ids_with(CONFIG).map(|id| id.replace('_', "-")).collect();
                all.sort();
                return Err(fail(key.span().start, &problem, format!("the options are {}", all.join(", "))));
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
                        "expected a string, a number or a boolean",
                        "write it as on the command line".into(),
                    ));
                }
            };
            words.insert(name, ConfigValue { text: word, place: place(start) });
        }
        Ok(Self(words))
    }

    /// The options that environment and file set: identifiers and values.
    pub(super) fn preferences(&self) -> Vec<(String, OsString)> {
        let of = |id: &str| {
            let in_file = || self.0.get(&id.replace('_', "-")).map(|word| word.text.clone().into());
            Some((id.to_owned(), env::var_os(variable(id)).or_else(in_file)?))
        };
        ids_with(CONFIG).filter_map(of).collect()
    }

    /// The command with the environment variables and the values of this file added to the options of its subcommands that use
    /// them.
    ///
    /// # Errors
    /// [`Error::Settings`] with the place of a value that its option does not accept.
    pub(super) fn apply(&self, command: Command) -> Result<Command> {
        let mut fault = Ok(());
        let mut option = |argument: Arg| {
            let (argument, checked) = self.option(argument);
            fault = std::mem::replace(&mut fault, Ok(())).and(checked);
            argument
        };
        let known = COMMANDS.into_iter().fold(command, |command, name| match command.find_subcommand(name) {
            Some(_) => command.mut_subcommand(name, |part| part.mut_args(&mut option)),
            None => command,
        });
        fault.map(|()| known)
    }

    fn option(&self, argument: Arg) -> (Arg, Result<()>) {
        let Some(name) = argument.get_long().filter(|name| is_preference(name)).map(str::to_owned) else {
            return (argument, Ok(()));
        };
        // Variables may also contain 1 and yes.
        let argument = match argument.get_action() {
            ArgAction::SetTrue => argument.value_parser(BoolishValueParser::new()),
            _ => argument,
        };
        let argument = argument.env(variable(&name));
        // Help shows the variable's name but not its value, so that manuals are the same on every machine.
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

/// Whether the option with this name may be set this way.
fn is_preference(name: &str) -> bool {
    has(&name.replace('-', "_"), CONFIG)
}

/// The environment variable of an option.
fn variable(name: &str) -> String {
    format!("HALFLINE_{}", name.to_uppercase().replace('-', "_"))
}

impl ConfigValue {
    /// Checks the value with the option's parser; clap's own error would not name the place.
    fn check(&self, name: &str, argument: &Arg) -> Result<()> {
        let alone = Arg::new("word").value_parser(argument.get_value_parser().clone()).allow_hyphen_values(true);
        let taken = Command::new("config").no_binary_name(true).arg(alone).try_get_matches_from([&self.text]);
        taken.map(drop).map_err(|error| {
            let why = std::error::Error::source(&error).map_or_else(String::new, |why| format!(": {why}"));
            let problem = format!("`{}` is not a valid value of {name}{why}", shortened(&self.text, 40));
            wrong(&self.place, &problem, format!("use a value that --{name} accepts on the command line"))
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
        let config = Config::parse("backend = \"cpu\"\nseed = 7\nradius_scale = 2\n", "c.toml").expect("good");
        let of = |arguments: &[&str], id: &str| {
            let matches =
                config.apply(Arguments::command()).expect("words").try_get_matches_from(arguments).expect("good");
            let raw = matches.subcommand().expect("render").1.get_raw(id).expect("a value").next().expect("one");
            raw.to_string_lossy().into_owned()
        };
        let bare = ["halfline", "render", "a.toml", "-o", "a.png"];
        assert_eq!((of(&bare, "backend"), of(&bare, "radius_scale")), ("cpu".into(), "2".into()));
        let flag = [&bare[..], &["--backend", "gpu"]].concat();
        assert_eq!((of(&flag, "backend"), of(&flag, "seed")), ("gpu".into(), "7".into()));
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
