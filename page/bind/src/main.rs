//! Makes the program of a page, and the JavaScript around it, from what the compiler made: `halfline-page-bind FILE.wasm FOLDER`.

use std::error::Error;
use wasm_bindgen_cli_support::Bindgen;

fn main() -> Result<(), Box<dyn Error>> {
    let [input, output] = <[_; 2]>::try_from(std::env::args_os().skip(1).collect::<Vec<_>>())
        .map_err(|_| "usage: halfline-page-bind FILE.wasm FOLDER")?;
    let mut bindgen = Bindgen::new();
    bindgen.input_path(input).out_name("halfline").typescript(false).no_modules(true)?.remove_name_section(true);
    bindgen.generate(output)?;
    Ok(())
}
