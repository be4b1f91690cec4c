//! Prints the frames of a file as JSON, one line for each: positions, columns, cell, time and warnings.
//!
//! ```sh
//! cargo run -p halfline-particles --example frames -- water.xyz 'element O'
//! ```

use halfline_particles::{ColumnValue, Columns, Frames, Keep, ParticleOptions};
use serde_json::{Map, Value, json};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let file = words.next().ok_or("a file is missing")?;
    let select = words.map(|word| word.parse()).collect::<Result<_, _>>()?;
    let options = ParticleOptions { select, frames: "1-".parse()?, keep: Keep::All, ..Default::default() };
    for frame in Frames::open(file.as_ref(), &options)? {
        let frame = frame?;
        let columns = Columns::of(&frame)?;
        let value = |value| match value {
            ColumnValue::Number(number) if number.is_finite() => json!(number),
            ColumnValue::Number(number) => json!(format!("{number:?}")),
            ColumnValue::Text(text) => json!(text),
        };
        let mut values = Map::new();
        for name in columns.names() {
            let (_, column) = columns.get(name)?;
            let all: Value = (0..frame.positions.len()).map(|n| value(column.value(n))).collect();
            values.insert(name.to_owned(), all);
        }
        let (positions, radii, colors) = (&frame.positions, &frame.radii, &frame.colors);
        let cell = frame.cell.map(|cell| json!({ "origin": cell.origin, "edges": cell.edges }));
        let warnings = frame.skipped.warnings();
        println!(
            "{}",
            json!({
                "positions": positions, "radii": radii, "colors": colors, "columns": values, "cell": cell,
                "time": frame.when.time, "step": frame.when.step, "warnings": warnings,
            })
        );
    }
    Ok(())
}
