//! Prints the table of extremes: every family of tests/extremes against every form of the quadratic and against
//! certified answers, on the adapter that WGPU_ADAPTER_NAME or the first argument names. docs/extremes.md keeps two.
//!
//! ```sh
//! cargo run --release --example extremes
//! ```
//!
//! A cell is the number of misclassified pixels (false hits, false misses and wrong spheres, against exact) and the
//! largest relative error of the distance where the right sphere is hit.

#[expect(dead_code, reason = "the helpers of tests that render on pinned adapters")]
#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/extremes/families.rs"]
mod families;
#[path = "../tests/extremes/score.rs"]
mod score;

use families::FAMILIES;
use halfline::{Accuracy, Aov, Backend, Error, Method, Renderer, Result, Scene, Settings};
use score::Score;
use std::collections::BTreeMap;

/// The first seed of the test.
const SEED: u64 = 0x5eed_0003;

/// How a column is computed: one form alone, or certified.
type Column = Option<Method>;

fn settings(column: Column) -> Settings {
    let mut settings = Settings { method: column, aovs: vec![Aov::Distance], ..Settings::default() };
    if column.is_none() {
        settings.accuracy = Accuracy::Certified;
        settings.aovs.extend([Aov::Bound, Aov::Certainty]);
    }
    settings
}

/// The judge's frames of some scenes.
fn truths(scenes: &[Scene]) -> Result<Vec<halfline::Frame>> {
    let settings = Settings { backend: Backend::Cpu, accuracy: Accuracy::Exact, ..settings(None) };
    let mut judge = Renderer::new(&settings)?;
    scenes.iter().map(|scene| judge.render(scene, &settings)).collect()
}

fn main() -> Result<()> {
    let adapter = std::env::args().nth(1);
    let mut renderer = Renderer::new(&Settings { adapter, ..Settings::default() })?;
    println!("Adapter: {} ({})\n", renderer.adapter(), renderer.driver());
    let columns: Vec<Column> = Method::ALL.iter().copied().map(Some).chain([None]).collect();
    let name = |column: &Column| column.map_or("certified", Method::name);
    let heads: Vec<_> = columns.iter().map(name).collect();
    println!("| family | pixels | {} | in f32 | error / bound |", heads.join(" | "));
    println!("|---|---{}|---|---|", "|---".repeat(heads.len()));
    // An adapter's refusal of a form is a column's answer, and its reason is told below the table.
    let mut refused: BTreeMap<&str, String> = BTreeMap::new();
    let mut sums = vec![Score::default(); columns.len()];
    for family in FAMILIES {
        let scenes = (family.make)(SEED);
        let exact = truths(&scenes)?;
        let mut cells = Vec::new();
        let mut score = Score::default();
        for (column, sum) in columns.iter().zip(&mut sums) {
            score = Score::default();
            for (scene, exact) in scenes.iter().zip(&exact) {
                match renderer.render(scene, &settings(*column)) {
                    Ok(frame) => score = score.and(Score::of(&frame, exact)),
                    Err(Error::Accuracy { problem, .. }) => {
                        refused.insert(name(column), problem);
                        break;
                    }
                    Err(error) => return Err(error),
                }
            }
            *sum = sum.and(score);
            cells.push(cell(&score, refused.contains_key(name(column))));
        }
        if score.pixels > 0 {
            println!("| {} | {} | {} | {} |", family.name, score.pixels, cells.join(" | "), proof(&score));
        }
    }
    let cells: Vec<_> = sums.iter().zip(&columns).map(|(sum, c)| cell(sum, refused.contains_key(name(c)))).collect();
    let all = sums.last().copied().unwrap_or_default();
    println!("| **all** | {} | {} | {} |", all.pixels, cells.join(" | "), proof(&all));
    for (method, reason) in refused {
        println!("\n`{method}` is refused: {reason}.");
    }
    Ok(())
}

/// Wrong pixels and the largest error.
fn cell(score: &Score, refused: bool) -> String {
    match (refused, score.error) {
        (true, _) => "refused".to_owned(),
        (_, 0.0) => format!("{}, 0", score.wrong),
        (_, error) if error.is_infinite() => format!("{}, inf", score.wrong),
        (_, error) => format!("{}, {error:.0e}", score.wrong),
    }
}

/// Share of the pixels that f32 proves, and the largest share that an error took of its bound there.
fn proof(score: &Score) -> String {
    format!("{:.1} % | {:.2}", 100.0 * score.certified as f64 / score.pixels as f64, score.ratio)
}
