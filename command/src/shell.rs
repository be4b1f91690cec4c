//! `halfline completions SHELL` and `halfline man`: shell completions and manual pages, generated from the definition
//! of the options.

use super::Arguments;
use super::config::Config;
use super::process::ExitCode;
use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;
use halfline::error::{Error, Result};
use halfline_files::write::file::{check_writable, write_atomically};
use std::path::PathBuf;

/// Prints the shell completions of halfline's commands and options.
///
/// Examples:
///   halfline completions bash > ~/.local/share/bash-completion/completions/halfline
///   halfline completions zsh > "${fpath[1]}/_halfline"
///   halfline completions fish > ~/.config/fish/completions/halfline.fish
#[derive(Debug, Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Completions {
    /// The shell.
    shell: Shell,
}

/// Prints the manual page, or writes the pages of all commands into a folder.
///
/// Examples:
///   halfline man | man -l -
///   halfline man --out ~/.local/share/man/man1
#[derive(Debug, Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Man {
    /// An existing folder for halfline.1, halfline-render.1, ...
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Completions {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut Arguments::command(), "halfline", &mut text);
        write_atomically("-".as_ref(), |out| out.write_all(&text))?;
        Ok(ExitCode::SUCCESS)
    }
}

impl Man {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        let command = Config::default().apply(Arguments::command())?;
        let Some(folder) = &self.out else {
            write_page(command, "-".into())?;
            return Ok(ExitCode::SUCCESS);
        };
        if !folder.is_dir() {
            let missing = std::io::Error::new(std::io::ErrorKind::NotFound, "the folder does not exist");
            return Err(Error::write(folder, missing));
        }
        let parts = command.get_subcommands().map(|part| {
            let name = format!("halfline-{}", part.get_name());
            part.clone().name(name.clone()).bin_name(name)
        });
        for page in parts.chain([command.clone()]) {
            let path = folder.join(format!("{}.1", page.get_name()));
            check_writable(&path)?;
            write_page(page, path)?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn write_page(command: Command, path: PathBuf) -> Result<()> {
    write_atomically(&path, |mut out| clap_mangen::Man::new(command).render(&mut out))
}
