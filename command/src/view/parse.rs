//! Words of `halfline render` as its options, as the command line reads them: with environment and configuration.

use crate::config::Config;
use crate::render::Render;
use crate::scene_args::SceneArgs;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Args, Command, FromArgMatches};
use halfline::error::{Error, Result};
use std::error::Error as _;
use std::ffi::OsString;

/// The definition of `halfline render`.
pub(crate) struct Parser(Command);

impl Parser {
    /// The parser, with the defaults of the environment and of the configuration file.
    ///
    /// # Errors
    /// Errors of the configuration file.
    pub(super) fn new() -> Result<Self> {
        Config::load()?.apply(Self::without_preferences().0).map(Self)
    }

    /// The parser without environment and configuration.
    pub(crate) fn without_preferences() -> Self {
        let render = Render::augment_args(Command::new("render"));
        Self(Command::new("halfline").no_binary_name(true).subcommand(render))
    }

    /// The options of these words, beginning with `render`.
    ///
    /// # Errors
    /// [`Error::Settings`] with clap's words.
    pub(crate) fn args(&mut self, words: &[OsString]) -> Result<SceneArgs> {
        let matches = self.0.try_get_matches_from_mut(words).map_err(|error| self.refused(words, &error))?;
        let (_, matches) = matches.subcommand().ok_or_else(|| Error::settings("no command", "use render"))?;
        Ok(Render::from_arg_matches(matches).map_err(|error| refused(&error))?.args)
    }

    /// An error of clap; where an option lacks another one, it names both.
    fn refused(&mut self, words: &[OsString], error: &clap::Error) -> Error {
        let is_lacking = |error: &clap::Error| error.kind() == ErrorKind::MissingRequiredArgument;
        // The option without which nothing is lacking.
        let needs = (2..words.len()).filter(|_| is_lacking(error)).find(|n| {
            let fewer = words.iter().enumerate().filter(|(k, _)| k != n).map(|(_, word)| word);
            !self.0.try_get_matches_from_mut(fewer).is_err_and(|error| is_lacking(&error))
        });
        match needs {
            Some(n) => {
                let (given, lacking) = (setting(&words[n].to_string_lossy()), named(error, ContextKind::InvalidArg));
                let problem = format!("{given} belongs to {lacking}, and there is none");
                Error::settings(problem, format!("give {lacking}, or remove {given}"))
            }
            None => refused(error),
        }
    }

    /// The help of an option of `halfline render`.
    pub(super) fn help(&self, id: &str) -> String {
        let render = self.0.find_subcommand("render");
        let found = render.and_then(|render| render.get_arguments().find(|arg| arg.get_id() == id));
        found.and_then(Arg::get_help).map(ToString::to_string).unwrap_or_default()
    }
}

/// An error of clap. Its options are named as settings, which have other names in a notebook and in Python.
fn refused(error: &clap::Error) -> Error {
    let (name, value) = (named(error, ContextKind::InvalidArg), context(error, ContextKind::InvalidValue).join(","));
    match error.kind() {
        ErrorKind::ValueValidation => {
            let source = error.source().map(ToString::to_string).unwrap_or_default();
            match (source.strip_prefix("expected "), source.rsplit_once("; ")) {
                (Some(expected), _) => Error::settings(format!("{name} is {value}"), format!("give {expected}")),
                (None, Some((problem, mend))) => Error::settings(format!("{name}: {problem}"), mend),
                (None, None) => Error::settings(format!("{name}: {source}"), "give another value"),
            }
        }
        ErrorKind::InvalidValue => {
            let values = context(error, ContextKind::ValidValue).join(", ");
            let mend = if values.is_empty() { "give a value".into() } else { format!("choose from {values}") };
            Error::settings(format!("{name} is {value}"), mend)
        }
        ErrorKind::ArgumentConflict => {
            let other = named(error, ContextKind::PriorArg);
            Error::settings(format!("{name} and {other} exclude each other"), "remove one of them")
        }
        ErrorKind::MissingRequiredArgument => {
            Error::settings(format!("another option needs {name}, which is not given"), format!("give {name}"))
        }
        _ => {
            let text = error.render().to_string();
            let line = text.lines().next().unwrap_or_default();
            Error::settings(line.strip_prefix("error: ").unwrap_or(line), "use another value")
        }
    }
}

/// The texts of an error about this part of the command line.
fn context(error: &clap::Error, kind: ContextKind) -> Vec<&str> {
    match error.get(kind) {
        Some(ContextValue::String(text)) => vec![text],
        Some(ContextValue::Strings(all)) => all.iter().map(String::as_str).collect(),
        _ => Vec::new(),
    }
}

/// The settings that an error names.
fn named(error: &clap::Error, kind: ContextKind) -> String {
    context(error, kind).into_iter().map(setting).collect::<Vec<_>>().join(" and ")
}

/// The name of the setting of an option as clap shows it: `--shine <N>`, `--cell[=<RADIUS>]`.
fn setting(usage: &str) -> String {
    let name = usage.trim_start_matches('-').split([' ', '=', '[']).next().unwrap_or_default();
    format!("`\u{2060}{}`", name.replace('-', "_"))
}
