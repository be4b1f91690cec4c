//! The promise of a prediction: no error of any method is larger than was predicted.
mod common;

use common::{admitted, cpu, gpu};
use halfline::frame::Aov;
use halfline::intersect::Method;
use halfline::measure::score::Truths;
use halfline::measure::suite::extremes::FAMILIES;
use halfline::plan::Settings;
use halfline::predict::Prediction;
use halfline::render::Renderer;

fn settings(method: Method) -> Settings {
    Settings { method: Some(method), aovs: vec![Aov::Distance, Aov::Normal], ..Settings::default() }
}

fn data() -> std::path::PathBuf {
    let beside = std::path::PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data"));
    std::env::var_os("HALFLINE_DATA").map_or(beside, Into::into)
}

#[test]
fn no_error_is_larger_than_predicted() {
    let mut places: Vec<(&str, Vec<Method>, Renderer)> = vec![("cpu", Method::ALL.to_vec(), cpu())];
    if let Some(mut gpu) = gpu() {
        places.push(("gpu", admitted(&mut gpu), gpu));
    }
    let mut faulty = Vec::new();
    for family in FAMILIES {
        let mut worst = vec![[0.0f64; 2]; Method::ALL.len()];
        for (n, scene) in family.scenes(0x5eed_0003, Some(&data())).expect("scenes").iter().enumerate() {
            let truths = Truths::of(scene).expect("truths");
            for (m, &method) in Method::ALL.iter().enumerate() {
                let Some(predicted) = Prediction::of(scene, method).expect("a prediction") else { continue };
                for (place, methods, renderer) in &mut places {
                    if !methods.contains(&method) {
                        continue;
                    }
                    let frame = renderer.render(scene, &settings(method)).expect("a frame");
                    let errors = truths.score(&frame).expect("a score").errors_given(&predicted);
                    let none = f64::INFINITY;
                    let (outline, distance) = (errors.outline.unwrap_or(none), errors.relative.max.unwrap_or(none));
                    let ratio = |seen: f64, most: f64| {
                        if seen <= most {
                            if most.is_finite() { seen / most } else { 0.0 }
                        } else {
                            f64::INFINITY.min(seen / most)
                        }
                    };
                    worst[m][0] = worst[m][0].max(ratio(outline, predicted.outline));
                    worst[m][1] = worst[m][1].max(ratio(distance, predicted.distance));
                    if !(outline <= predicted.outline && distance <= predicted.distance) {
                        faulty.push(format!(
                            "{} [{n}] {} {place}: {outline:e} {distance:e} of {predicted:?}",
                            family.name,
                            method.name()
                        ));
                    }
                }
            }
        }
        let words: Vec<_> =
            Method::ALL.iter().zip(&worst).map(|(m, w)| format!("{} {:.3} {:.3}", m.name(), w[0], w[1])).collect();
        println!("{:30} {}", family.name, words.join("; "));
    }
    assert!(faulty.is_empty(), "{}\n{}", faulty.len(), faulty.join("\n"));
}
