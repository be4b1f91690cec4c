//! Unpacks the corpus into folders, with which libFuzzer works, and packs it again.

use crate::corpus;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipWriter};

/// Writes the inputs of a pack, if there is one, to a folder.
pub(crate) fn unpack(pack: &Path, folder: &Path) {
    if pack.exists() {
        for (name, content) in corpus::read(pack) {
            fs::write(folder.join(name), content).expect("an input");
        }
    }
}

/// Packs the files of a folder. The same files give the same bytes.
pub(crate) fn pack(folder: &Path, pack: &Path) {
    let mut paths: Vec<_> =
        fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::DEFAULT)
        .system(System::Unix)
        .unix_permissions(0o644);
    let mut archive = ZipWriter::new(File::create(pack).expect("the pack"));
    for path in &paths {
        let name = path.file_name().expect("a name").to_string_lossy();
        archive.start_file(name, options).expect("a member");
        archive.write_all(&fs::read(path).expect("an input")).expect("written");
    }
    archive.finish().expect("written");
    println!("{}: {} inputs", pack.display(), paths.len());
}
