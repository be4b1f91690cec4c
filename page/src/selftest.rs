//! The self-test of a page: the adapter's arithmetic, and hard scenes whose answers the judge decides exactly.

use halfline::error::Result;
use halfline::frame::{Aov, Data};
use halfline::render::Renderer;
use halfline::scene::Scene;
use halfline::settings::{Accuracy, Backend, Settings};
use halfline_measure::score::Truths;
use halfline_measure::suite::extremes::{FAMILIES, SEED};
use serde_json::{Value, json};

/// The most pixels of a side: a family is many small pictures.
const SIDE: u32 = 64;

/// The most scenes of a family.
const SCENES: usize = 3;

/// Pixels by how they were answered.
#[derive(Default)]
struct Counts {
    pixels: u64,
    wrong: u64,
    /// Pixels that were not proved in f32, which the judge settled.
    settled: u64,
}

/// The report on a backend.
///
/// # Errors
/// Errors of [`Renderer::new`], of the adapter's self-test, and of scenes.
pub(crate) fn report(backend: Backend) -> Result<Value> {
    let mut renderer = Renderer::new(&Settings { backend, ..Settings::default() })?;
    let checks = renderer.verdict()?.map(|verdict| json!(verdict));
    let mut families = Vec::new();
    let (mut pixels, mut wrong) = (0, 0);
    for family in FAMILIES.iter().filter(|family| family.file().is_none()) {
        let mut counts = Counts::default();
        for scene in family.scenes(SEED, None)?.into_iter().take(SCENES) {
            count(&mut renderer, scene, &mut counts)?;
        }
        pixels += counts.pixels;
        wrong += counts.wrong;
        families.push(json!({
            "name": family.name, "pixels": counts.pixels, "wrong": counts.wrong, "settled": counts.settled,
        }));
    }
    Ok(json!({
        "halfline": env!("CARGO_PKG_VERSION"),
        "adapter": renderer.adapter(),
        "reason": renderer.backend_reason(),
        "checks": checks,
        "pixels": pixels,
        "wrong": wrong,
        "families": families,
    }))
}

fn count(renderer: &mut Renderer, mut scene: Scene, counts: &mut Counts) -> Result<()> {
    scene.image.width = scene.image.width.min(SIDE);
    scene.image.height = scene.image.height.min(SIDE);
    let aovs = vec![Aov::Id, Aov::Distance, Aov::Normal, Aov::Certainty];
    let frame = renderer.render(&scene, &Settings { accuracy: Accuracy::Certified, aovs, ..Settings::default() })?;
    let errors = Truths::of(&scene)?.errors(&frame)?;
    counts.pixels += errors.pixels;
    counts.wrong += errors.false_hit + errors.false_miss + errors.wrong_sphere + errors.wrong_root;
    if let Some(Data::U8(certainty)) = frame.get(Aov::Certainty).map(|buffer| &buffer.data) {
        counts.settled += certainty.iter().filter(|one| **one == 1).count() as u64;
    }
    Ok(())
}
