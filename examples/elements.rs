//! The elements of particle files, for comparison with other programs: a line of JSON for each file, with the symbol
//! and the position of every rendered atom, and the warnings. `tests/independent/elements.py` reads it.
//!
//! ```sh
//! cargo run --release --example elements -- FILE...
//! ```

use halfline_files::read::Style;
use halfline_files::read::style::Coloring;
use halfline_files::read::style::elements::element;
use halfline_files::read::{self, ReadOptions};
use serde_json::json;
use std::collections::HashMap;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The elements are identified by their colours, which must differ; unknown elements are deep pink.
    let linear = |n: u8| {
        let color = element(n).map_or(0xff1493, |element| element.color);
        halfline_files::read::style::color(&format!("#{color:06x}")).map(|rgb| rgb.map(f32::to_bits))
    };
    let mut symbols = HashMap::new();
    for n in (0..=109).rev() {
        let known = symbols.insert(linear(n)?, element(n).map_or("X", |element| element.symbol));
        assert!(known.is_none(), "two elements of one colour");
    }
    let style = Style { coloring: Coloring::Element, radius: Some(1.0), ..Style::default() };
    let options = ReadOptions { style, ..ReadOptions::default() };
    for file in std::env::args().skip(1) {
        let line = match read::scene(file.as_ref(), &options) {
            Ok(scene) => {
                let colors = scene.spheres.colors.unwrap_or_default();
                let found: Vec<_> = colors.iter().map(|color| symbols.get(&color.map(f32::to_bits))).collect();
                let warnings = scene.skipped.warnings();
                json!({ "file": file, "symbols": found, "positions": *scene.spheres.centers, "warnings": warnings })
            }
            Err(error) => json!({ "file": file, "error": error.to_string() }),
        };
        println!("{line}");
    }
    Ok(())
}
