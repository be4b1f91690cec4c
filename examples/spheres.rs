//! The spheres of particle files, for comparison with other programs: a line of JSON for each frame, with centres,
//! radii, the cell, the range of the values that give the colours, the warnings, time and step. Scripts of
//! `tests/independent` read it.
//!
//! ```sh
//! cargo run --release --example spheres -- FILE [--topology FILE] [--select EXPR] [--frames A-B] [--color-by COLUMN] \
//!     [--periodic wrap|unwrap]
//! ```

use halfline_files::ReadOptions;
use halfline_files::read::ParticleOptions;
use halfline_files::read::style::{Coloring, Scale};
use halfline_files::read::{Hold, Periodic, Sequence};
use serde_json::json;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The range of a column is found in each frame.
    let mut options = ReadOptions {
        particles: ParticleOptions { frames: "1-".parse()?, ..Default::default() },
        hold: Hold::None,
        ..ReadOptions::default()
    };
    let mut words = std::env::args().skip(1);
    let file = words.next().ok_or("a file is missing")?;
    while let Some(word) = words.next() {
        let value = words.next().ok_or_else(|| format!("{word} has no value"))?;
        match word.as_str() {
            "--select" => options.particles.select.push(value.parse()?),
            "--topology" => options.particles.topology = Some(value.into()),
            "--frames" => options.particles.frames = value.parse()?,
            "--periodic" => {
                options.particles.periodic = if value == "wrap" { Periodic::Wrap } else { Periodic::Unwrap };
            }
            "--color-by" => {
                let columns = value.split(',').map(str::to_owned).collect();
                options.style.coloring = Coloring::Column(Scale::of(columns));
            }
            _ => return Err(format!("{word} is not an option").into()),
        }
    }
    let mut sequence = Sequence::open(file.as_ref(), &options)?;
    while let Some(frame) = sequence.next_scene()? {
        let spheres = &frame.scene.spheres;
        let cell = frame.cell.map(|cell| json!({ "origin": cell.origin, "edges": cell.edges }));
        let range = frame.legend.map(|legend| legend.range);
        let warnings = frame.skipped.warnings();
        let line = json!({
            "frame": frame.number, "centers": *spheres.centers, "radii": *spheres.radii, "colors": spheres.colors.as_deref(),
            "cell": cell, "range": range, "warnings": warnings, "time": frame.when.time, "step": frame.when.step,
        });
        println!("{line}");
    }
    Ok(())
}
