//! The promise: a method that needs more than WGSL promises runs where the adapter was measured to be right, gives what
//! it is for there, and is refused with the reason and exit code 7 elsewhere.
//!
//! Gold standard of the pictures: exact arithmetic, the CPU twin in f64, and the spheres themselves, on which the hit
//! points must lie. Tolerance of the ids: 1 pixel in 1000, for inputs are sums of two f32 (5e6 steps to a radius at 1e8
//! radii); none between f64 and its twin on adapters whose f64 is IEEE's (all that were seen).

mod common;

use common::{admitted, cpu, gpu};
use glam::DVec3;
use halfline::camera::{Camera, Lens, Look};
use halfline::frame::Aov;
use halfline::intersect::Method;
use halfline::measure::suite::Random;
use halfline::scene::{ImagePlane, Scene, Skipped, Spheres};
use halfline::settings::{Accuracy, Settings};
use std::process::Command;

/// Spheres of radius 1 in a cube of half side 4, seen along (1, 2, 3) from `distance` so that they fill the image.
fn cluster(distance: f64) -> Scene {
    let mut random = Random(0xc105);
    let mut spheres = Spheres::default();
    for _ in 0..40 {
        spheres.push(random.cube().map(|x| 4.0 * x), 1.0, None);
    }
    let eye = DVec3::new(-1.0, -2.0, -3.0).normalize() * distance;
    Scene {
        camera: Camera {
            eye,
            look: Look::At(DVec3::ZERO),
            up: DVec3::new(0.0, 1.0, 0.0),
            lens: Lens::Viewport { vw: 16.0, vh: 12.0, distance },
        },
        image: ImagePlane { width: 160, height: 120, background: [0.0; 3] },
        spheres,
        skipped: Skipped::default(),
    }
}

fn settings(method: Method) -> Settings {
    Settings { method: Some(method), aovs: vec![Aov::Distance, Aov::Position, Aov::Normal], ..Settings::default() }
}

#[test]
fn far_clusters_keep_their_order_in_better_arithmetic() {
    let Some(mut gpu) = gpu() else { return };
    let methods = admitted(&mut gpu);
    for distance in [1e6, 1e7, 1e8] {
        let scene = cluster(distance);
        let twin = cpu().render(&scene, &settings(Method::Native64)).expect("a frame");
        let exact = Settings { method: None, accuracy: Accuracy::Exact, ..settings(Method::Stable) };
        let truth = cpu().render(&scene, &exact).expect("a frame");
        assert!(truth.report.hits > 5000, "the cluster is in the picture: {} hits", truth.report.hits);
        for method in [Method::Stable, Method::Native64, Method::DoubleFloat] {
            if !methods.contains(&method) {
                continue;
            }
            let frame = gpu.render(&scene, &settings(method)).expect("a frame");
            let wrong = frame.ids().iter().zip(truth.ids()).filter(|(a, b)| a != b).count();
            let both = frame.f64(Aov::Distance).expect("asked for").iter().zip(truth.f64(Aov::Distance).expect("same"));
            let same = both.zip(frame.ids().iter().zip(truth.ids())).filter(|(_, (a, b))| a == b && **a >= 0);
            let off = same.map(|((t, u), _)| (t - u).abs()).fold(0.0, f64::max);
            let points = frame.f64(Aov::Position).expect("asked for").chunks_exact(3).zip(frame.ids());
            let outside = points.filter(|(_, id)| **id >= 0).map(|(p, &id)| {
                let from_center = DVec3::from_slice(p) - DVec3::from_array(scene.spheres.centers[id as usize]);
                (from_center.length() - 1.0).abs()
            });
            let outside = outside.fold(0.0, f64::max);
            let name = method.name();
            println!("{distance:e}, {name}: {wrong} wrong ids, distance off {off:.1e}, off the sphere {outside:.1e}");
            match method {
                Method::Stable => assert!(distance < 1e8 || wrong > 100, "f32 suffices? {wrong}"),
                _ => assert!(wrong <= 19 && off.max(outside) <= distance * 1e-12, "{wrong} wrong, off by {off}"),
            }
            if method == Method::Native64 {
                let same = frame.ids() == twin.ids() && frame.f64(Aov::Distance) == twin.f64(Aov::Distance);
                assert!(same, "f64 and its twin differ");
            }
        }
    }
}

/// What the command line says of methods that cannot run, and of the adapter.
#[test]
fn a_method_that_cannot_run_here_ends_with_code_7_and_the_reason() {
    let Some(mut gpu) = gpu() else { return };
    let methods = admitted(&mut gpu);
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/canonical.toml");
    let halfline =
        |arguments: &[&str]| Command::new(env!("CARGO_BIN_EXE_halfline")).args(arguments).output().expect("runs");
    for &method in Method::ALL {
        let output =
            halfline(&["render", scene, "--size", "16x16", "--backend", "gpu", "--json", "--method", method.name()]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        if methods.contains(&method) {
            assert_eq!(output.status.code(), Some(0), "{}: {said}", method.name());
        } else {
            assert_eq!(output.status.code(), Some(7), "{}: {said}", method.name());
            assert!(said.contains("cannot run on") && output.stdout.is_empty(), "{said}");
        }
        let on_cpu =
            halfline(&["render", scene, "--size", "16x16", "--backend", "cpu", "--json", "--method", method.name()]);
        assert_eq!(on_cpu.status.code(), Some(0), "{} runs on the CPU", method.name());
    }
    let cache = tempfile::tempdir().expect("a folder");
    for arguments in [&["adapters", "--json"][..], &["adapters", "--json"], &["adapters", "--json", "--retest"]] {
        let output = Command::new(env!("CARGO_BIN_EXE_halfline"))
            .args(arguments)
            .env("XDG_CACHE_HOME", cache.path())
            .env("LOCALAPPDATA", cache.path())
            .output()
            .expect("runs");
        let object: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let verdict = &object["adapters"][0]["verdict"];
        assert_eq!(verdict["f64"]["reason"].is_null(), methods.contains(&Method::Native64), "{object}");
        assert_eq!(verdict["double_float"]["reason"].is_null(), methods.contains(&Method::DoubleFloat), "{object}");
        assert!(verdict["checks"].as_array().is_some_and(|checks| checks.len() > 20), "{object}");
    }
    assert!(std::fs::read_dir(cache.path().join("halfline")).expect("kept").count() > 0);
}
