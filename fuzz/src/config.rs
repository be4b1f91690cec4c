//! The configuration file's reader, from the command's source.

#[path = "../../command/src/config.rs"]
#[expect(dead_code, reason = "the command needs more of it")]
mod real;

use clap::{Arg, Command};
use halfline::Error;
use std::path::PathBuf;
use std::sync::LazyLock;

/// The file that is read repeatedly, in memory where the system has such a folder.
static PATH: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = crate::harness::desk();
    std::fs::create_dir_all(&folder).expect("a private folder");
    let path = folder.join("config.toml");
    // SAFETY: no other thread reads the environment while the first input is run.
    unsafe { std::env::set_var("HALFLINE_CONFIG", &path) };
    path
});

/// Reads the file and passes its values to options of the same names.
pub(crate) fn run(data: &[u8]) -> Result<(), Error> {
    std::fs::write(&*PATH, data).expect("a private file");
    let config = real::Config::load()?;
    let option = |name: &'static str| Arg::new(name).long(name);
    let number = |name: &'static str| option(name).value_parser(clap::value_parser!(f64));
    let options = [option("backend"), number("tolerance"), option("size")];
    let commands = ["render", "plan", "measure"].map(|name| Command::new(name).args(options.clone()));
    config.apply(Command::new("halfline").subcommands(commands)).map(drop)
}
