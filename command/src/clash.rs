//! Checks before any work that no output is an input of the same command and that no two outputs are the same file.

use super::names::{number_in, numbered};
use halfline::error::{Error, Result};
use halfline_files::write::file::{is_standard, is_standard_output};
use std::path::{Path, PathBuf};

/// The location of a file, existing or not, independent of how its name is written.
pub(super) fn place(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let new = || Some(folder.canonicalize().ok()?.join(path.file_name()?));
    path.canonicalize().ok().or_else(new).unwrap_or_else(|| path.to_path_buf())
}

/// Returns an error for an output that is also an input.
///
/// # Errors
/// [`Error::Settings`] naming both.
pub(super) fn check_inputs<'a>(outputs: impl IntoIterator<Item = &'a Path>, inputs: &[PathBuf]) -> Result<()> {
    for output in outputs {
        if let Some(input) = inputs.iter().find(|input| is_same_file(output, input)) {
            let names = match input == output {
                true => format!("{} is an input", output.display()),
                false => format!("{} is the input {}", output.display(), input.display()),
            };
            return Err(Error::settings(format!("{names} and would be overwritten"), "use another output file"));
        }
    }
    Ok(())
}

/// The error of a file that two outputs name.
pub(super) fn written_twice<T>(path: &Path, mend: &str) -> Result<T> {
    Err(Error::settings(format!("{} would be written twice", path.display()), mend))
}

/// Returns an error for several results on standard output; `what` names those before the JSON and the lines of openjd.
pub(super) fn check_one_standard(what: &str, are_there: impl IntoIterator<Item = bool>) -> Result<()> {
    if are_there.into_iter().filter(|is_there| *is_there).count() < 2 {
        return Ok(());
    }
    let problem = format!("standard output can hold only one of: {what}, the JSON, the lines of openjd");
    Err(Error::settings(problem, "use files for the others"))
}

/// Returns an error for names that are not UTF-8 and so cannot stand in the JSON of `list`.
///
/// # Errors
/// [`Error::Settings`] naming the first.
pub(super) fn check_text<'a>(names: impl IntoIterator<Item = &'a Path>, list: &str) -> Result<()> {
    match names.into_iter().find(|name| name.to_str().is_none()) {
        Some(name) => {
            let problem = format!("{} is not UTF-8, and {list} cannot name it", name.display());
            Err(Error::settings(problem, "use a name in UTF-8"))
        }
        None => Ok(()),
    }
}

/// Returns an error for name patterns that give the same file for some numbers, which may be different ones: `z%d` and
/// `z1%d`.
///
/// # Errors
/// [`Error::Settings`] naming both and the file.
pub(super) fn check_numbered(names: &[&Path], numbers: impl Iterator<Item = u64> + Clone) -> Result<()> {
    let places: Vec<_> = names.iter().map(|name| place(name)).collect();
    for (n, (name, first)) in names.iter().zip(&places).enumerate() {
        for (other, second) in names.iter().zip(&places).skip(n + 1).filter(|(_, second)| *second != first) {
            let clash = numbers.clone().map(|number| numbered(second, number)).find(|file| {
                // A name without a place for a number is one file for all numbers.
                *file == *first || number_in(first, file).is_some_and(|own| numbers.clone().any(|n| n == own))
            });
            if let Some(file) = clash {
                let [name, other, file] = [*name, *other, file.as_path()].map(Path::display);
                let problem = format!("{name} and {other} would both write {file}");
                return Err(Error::settings(problem, "use names that differ in more than their number"));
            }
        }
    }
    Ok(())
}

/// Whether both names refer to one regular file, by links or not. Devices and pipes may be both read and written.
fn is_same_file(output: &Path, input: &Path) -> bool {
    let output = if is_standard_output(output) { Path::new("/dev/stdout") } else { output };
    let input = if is_standard(input) { Path::new("/dev/stdin") } else { input };
    let (Ok(written), Ok(read)) = (output.metadata(), input.metadata()) else { return false };
    written.is_file() && read.is_file() && (is_same_node(&written, &read) || place(output) == place(input))
}

#[cfg(unix)]
fn is_same_node(a: &std::fs::Metadata, b: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
fn is_same_node(_: &std::fs::Metadata, _: &std::fs::Metadata) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbered_names_that_collide_are_refused() {
        let check = |names: &[&str], last: u64| {
            let names: Vec<_> = names.iter().map(Path::new).collect();
            check_numbered(&names, 1..=last)
        };
        for (names, last) in [
            (["z%d.npy", "z1%d.npy"], 11),
            (["z%d.npy", "./z%d1.npy"], 11),
            (["z%d.npy", "z%04d.npy"], 1000),
            (["z%02d.npy", "z%d.npy"], 10),
            (["z%d.npy", "z7.npy"], 7),
        ] {
            let error = check(&names, last).expect_err(names[1]).to_string();
            assert!(error.contains(names[0]) && error.contains(names[1]), "{error}");
            check(&names, last - 1).expect("not yet");
            check(&[names[1], names[0]], last - 1).expect("not yet");
            check(&[names[1], names[0]], last).expect_err("the other way round");
        }
        check(&["z%d.npy", "z%d.npy"], 9).expect("equal names are one file, which is checked elsewhere");
        check(&["z%d.npy", "y/z%d.npy"], 9).expect("two folders");
        check(&["z%d.npy", "y%d.npy", "z.npy", "z%dz.npy"], 99).expect("nothing in common");
    }

    #[test]
    fn files_are_identified_through_links() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("a"), "a").expect("written");
        std::fs::write(path("b"), "a").expect("written");
        std::fs::hard_link(path("a"), path("hard")).expect("linked");
        let inputs = [path("a")];
        check_inputs([path("b").as_path(), path("none").as_path()], &inputs).expect("others");
        check_inputs([path("a").as_path()], &inputs).expect_err("the same");
        check_inputs([path("./a").as_path()], &inputs).expect_err("the same");
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("a", path("soft")).expect("linked");
            check_inputs([path("soft").as_path()], &inputs).expect_err("a link");
            check_inputs([path("hard").as_path()], &inputs).expect_err("a link");
            check_inputs([Path::new("/dev/null")], &["/dev/null".into()]).expect("a device");
        }
    }
}
