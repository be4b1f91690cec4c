//! The corpus: `corpus/TARGET.zip` has the inputs of a target, uncompressed and in the order of their names.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use zip::ZipArchive;

/// An input: its name, which is the SHA-1 of its content unless somebody chose one, and its content.
pub(crate) type Input = (String, Vec<u8>);

/// The inputs of a file.
pub(crate) fn read(path: &Path) -> Vec<Input> {
    let file = File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut archive = ZipArchive::new(file).expect("an archive");
    let count = archive.len();
    let input = |n| {
        let mut member = archive.by_index(n).expect("a member");
        let mut content = Vec::new();
        member.read_to_end(&mut content).expect("whole and undamaged");
        (member.name().expect("a name").into_owned(), content)
    };
    (0..count).map(input).collect()
}
