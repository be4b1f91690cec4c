//! The cost of a certificate: whole frames of fast and certified, alternating so that other load affects both.
//!
//! ```sh
//! cargo run --release --example price -- 1024 5 scenes/weekend.toml cloud:100000
//! ```
//! Image side, frames of each kind, scenes; `cloud:N` makes N equal spheres uniform in a unit cube, 3 % of its volume.

mod cloud;

use cloud::cloud;
use halfline::{Accuracy, Aov, Backend, Renderer, Scene, Settings};
use halfline_files::read::{self, ReadOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [side, repeat, scenes @ ..] = arguments.as_slice() else {
        return Err("give the image side, frames of each kind, and scenes".into());
    };
    let (side, repeat): (u32, usize) = (side.parse()?, repeat.parse()?);
    let settings = |accuracy| Settings {
        accuracy,
        backend: Backend::Gpu,
        aovs: vec![Aov::Color, Aov::Id, Aov::Distance, Aov::Normal],
        ..Settings::default()
    };
    let kinds = [settings(Accuracy::Fast), settings(Accuracy::Certified)];
    let mut renderer = Renderer::new(&kinds[0])?;
    println!(
        "adapter {} ({}), {side} x {side}, colour + id + distance + normal",
        renderer.adapter(),
        renderer.driver()
    );
    println!("| scene | fast first / steady ms | certified first / steady ms | certified / fast | certified share |");
    println!("|---|---|---|---|---|");
    for name in scenes {
        let mut scene = match name.strip_prefix("cloud:") {
            Some(count) => cloud(count.parse()?),
            // Viewing rays alone.
            None => Scene { lighting: Default::default(), ..read::scene(name.as_ref(), &ReadOptions::default())? },
        };
        (scene.image.width, scene.image.height) = (side, side);
        let mut times = [Vec::new(), Vec::new()];
        let mut share = 0.0;
        for _ in 0..repeat + 1 {
            for (kind, times) in kinds.iter().zip(&mut times) {
                let frame = renderer.render(&scene, kind)?;
                times.extend(&frame.report.frame_ms);
                share = frame.report.certified;
            }
        }
        let median = |times: &[f64]| {
            let mut steady = times[1..].to_vec();
            steady.sort_by(f64::total_cmp);
            steady[steady.len() / 2]
        };
        let [fast, certified] = [median(&times[0]), median(&times[1])];
        println!(
            "| {name} | {:.0} / {fast:.0} | {:.0} / {certified:.0} | {:.2} | {share:.5} |",
            times[0][0],
            times[1][0],
            certified / fast
        );
    }
    Ok(())
}
