//! Measures an adapter, one step a process, so that a driver that hangs or crashes ends that step alone. docs/hardware.md describes
//! the kit that `tests/hardware` packs from it; tests/hardware.d/run calls the steps.
//!
//! ```sh
//! hardware adapters                       # the self-test of every adapter
//! hardware compare SPHERES LOOK SIDE      # device and CPU path, buffer by buffer
//! hardware lattice                        # spheres at the ends of the size classes, device and CPU path
//! hardware frames SPHERES LOOK SIDE FRAMES BACKEND SECONDS
//! hardware inside SPHERES                 # the eye in the middle of a cloud
//! hardware film SPHERES FRAMES            # spheres that move
//! hardware films SPHERES LOOK SIDE FRAMES # a moving camera, one frame after the other and two in flight
//! hardware methods SPHERES SIDE           # every method, device and CPU path
//! ```
//! A step prints one line of JSON. `note TEXT` and `line STEP WORDS CODE SECONDS STDOUT STDERR` print lines of a report, and
//! `report LINES JSON` writes it; tests/hardware.d/page makes a page of it. Exit code: 0 good, 1 a wrong answer or a line about one, 2 usage, 3 an error.

#[path = "../cloud/mod.rs"]
mod cloud;
mod compare;
mod lattice;
mod report;
mod scenes;
mod times;

use serde_json::{Value, json};
use std::process::ExitCode;
use std::str::FromStr;

type Result<T = Value> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The self-test of every adapter.
fn adapters() -> Result {
    let found = halfline::adapters()?;
    let verdicts: Vec<Value> = halfline::verdicts(true)?
        .into_iter()
        .map(|verdict| verdict.map_or_else(|error| json!({ "error": error.to_string() }), |verdict| json!(verdict)))
        .collect();
    let certifies = verdicts.iter().any(|verdict| verdict["f32"] == true && verdict["places"] == true);
    Ok(json!({ "adapters": found, "verdicts": verdicts, "good": certifies }))
}

/// A word of the command line as a value.
fn value<T: FromStr<Err: std::error::Error + 'static>>(word: &str) -> Result<T> {
    Ok(word.parse()?)
}

/// Runs a step. `None` for words that name none.
fn step(words: &[&str]) -> Result<Option<Value>> {
    Ok(Some(match *words {
        ["adapters"] => adapters()?,
        ["compare", count, look, side] => compare::frames(value(count)?, look, value(side)?)?,
        ["lattice"] => lattice::lattice()?,
        ["frames", count, look, side, many, backend, seconds] => {
            times::frames(value(count)?, look, value(side)?, value(many)?, value(backend)?, value(seconds)?)?
        }
        ["inside", count] => times::inside(value(count)?)?,
        ["film", count, many] => times::film(value(count)?, value(many)?)?,
        ["films", count, look, side, many] => times::films(value(count)?, look, value(side)?, value(many)?)?,
        ["methods", count, side] => compare::methods(value(count)?, value(side)?)?,
        ["note", text] => json!({ "step": "machine", "what": text }),
        ["line", step, words, code, seconds, out, err] => {
            report::line(step, words, value(code)?, value(seconds)?, [out, err])?
        }
        ["report", lines, to] => {
            report::write(lines, to)?;
            json!({ "report": to })
        }
        _ => return Ok(None),
    }))
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match step(&words) {
        Ok(Some(result)) => {
            println!("{result}");
            ExitCode::from(u8::from(result["good"] == false))
        }
        Ok(None) => {
            eprintln!("usage: see examples/hardware/main.rs");
            ExitCode::from(2)
        }
        Err(error) => {
            println!("{}", json!({ "error": error.to_string() }));
            ExitCode::from(3)
        }
    }
}
