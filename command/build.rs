//! Makes the program of pages a part of the command, if `bash page/build` was run before.

use std::path::Path;
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let folder = Path::new(&env::var("CARGO_MANIFEST_DIR").unwrap_or_default()).join("program");
    let files = ["halfline.js", "halfline.wasm.gz"].map(|name| folder.join(name));
    // `page/build` touches this file: a folder that is not there would count as changed each time.
    println!("cargo::rerun-if-changed=build.rs");
    if folder.exists() {
        println!("cargo::rerun-if-changed={}", folder.display());
    }
    let value = match files.iter().all(|file| file.exists()) {
        true => format!("Some((include_str!({:?}), include_bytes!({:?})))", files[0], files[1]),
        false => "None".to_owned(),
    };
    let out = Path::new(&env::var("OUT_DIR").unwrap_or_default()).join("program.rs");
    fs::write(out, format!("const PROGRAM: Option<(&str, &[u8])> = {value};\n"))
}
