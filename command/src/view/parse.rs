//! Words of `halfline render` as its options, as the command line reads them: with environment and configuration.

use crate::config::Config;
use crate::render::Render;
use crate::scene_args::SceneArgs;
use clap::{Arg, Args, Command, FromArgMatches};
use halfline::error::{Error, Result};
use std::ffi::OsString;

/// The definition of `halfline render`.
pub(super) struct Parser(Command);

impl Parser {
    /// The parser, with the defaults of the environment and of the configuration file.
    ///
    /// # Errors
    /// Errors of the configuration file.
    pub(super) fn new() -> Result<Self> {
        Config::load()?.apply(Self::without_preferences().0).map(Self)
    }

    /// The parser without environment and configuration.
    pub(super) fn without_preferences() -> Self {
        let render = Render::augment_args(Command::new("render"));
        Self(Command::new("halfline").no_binary_name(true).subcommand(render))
    }

    /// The options of these words, the first of which is `render`.
    ///
    /// # Errors
    /// [`Error::Settings`] with clap's words.
    pub(super) fn args(&mut self, words: &[OsString]) -> Result<SceneArgs> {
        let matches = self.0.try_get_matches_from_mut(words).map_err(|error| refused(&error))?;
        let (_, matches) = matches.subcommand().ok_or_else(|| Error::settings("no command", "use render"))?;
        Ok(Render::from_arg_matches(matches).map_err(|error| refused(&error))?.args)
    }

    /// The help of an option of `halfline render`.
    pub(super) fn help(&self, id: &str) -> String {
        let render = self.0.find_subcommand("render");
        let found = render.and_then(|render| render.get_arguments().find(|arg| arg.get_id() == id));
        found.and_then(Arg::get_help).map(ToString::to_string).unwrap_or_default()
    }
}

/// An error of clap in one line, without its hints on usage. Its option is named as a setting, which has another name in a
/// notebook.
fn refused(error: &clap::Error) -> Error {
    let text = error.render().to_string();
    let line = text.lines().next().unwrap_or_default();
    let line = line.strip_prefix("error: ").unwrap_or(line);
    let named = line.split_once(" for '--").and_then(|(before, rest)| {
        let (option, after) = rest.split_once('\'')?;
        let name = option.split(' ').next()?.replace('-', "_");
        Some(format!("{before} for `\u{2060}{name}`{after}"))
    });
    Error::settings(named.unwrap_or_else(|| line.to_owned()), "use another value")
}
