//! The configuration file's reader, from the command's source.

#[path = "../../command/src/option_table.rs"]
#[expect(dead_code, reason = "the command needs more of it")]
mod option_table;
#[path = "../../command/src/config.rs"]
#[expect(dead_code, reason = "the command needs more of it")]
mod real;

use super::check::{Allowed, PER_BYTE_OF_TOML, allowed, check_error, desk};
use clap::{Arg, Command};
use std::path::PathBuf;
use std::sync::LazyLock;

/// The file that is read repeatedly, in memory where the system has such a folder.
static PATH: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = desk();
    std::fs::create_dir_all(&folder).expect("a private folder");
    let path = folder.join("config.toml");
    // SAFETY: no other thread reads the environment while the first input is run.
    unsafe { std::env::set_var("HALFLINE_CONFIG", &path) };
    path
});

/// Reads the file and passes its values to options of the same names.
pub(super) fn config(data: &[u8]) -> Allowed {
    std::fs::write(&*PATH, data).expect("a private file");
    let option = |name: &'static str| Arg::new(name).long(name);
    let number = |name: &'static str| option(name).value_parser(clap::value_parser!(f64));
    let options = [option("backend"), number("tolerance"), option("size")];
    let commands = ["render", "plan", "measure", "trace"].map(|name| Command::new(name).args(options.clone()));
    let command = Command::new("halfline").subcommands(commands);
    if let Err(error) = real::Config::load().and_then(|config| config.apply(command)) {
        check_error(&error);
    }
    allowed(data.len(), PER_BYTE_OF_TOML)
}
