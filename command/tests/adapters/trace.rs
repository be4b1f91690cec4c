//! The promise of `halfline trace` on every backend: the same ids, and distances of the same spheres.

use crate::adapter::gpu;
use crate::rng::Rng;
use crate::test_dir::{Output, TestDir};

/// Particles, and rays from many points, as files.
fn dir() -> TestDir {
    let mut rng = Rng::new(14);
    let mut spheres = "x,y,z,radius\n".to_owned();
    for _ in 0..300 {
        let [x, y, z] = rng.cube().map(|x| 5.0 * x);
        spheres += &format!("{x},{y},{z},{}\n", 0.2 + 0.5 * rng.unit());
    }
    let mut rays = String::new();
    for _ in 0..2000 {
        let ([ox, oy, oz], [dx, dy, dz]) = (rng.cube().map(|x| 9.0 * x), rng.cube());
        rays += &format!("{ox},{oy},{oz},{dx},{dy},{dz},{}\n", 20.0 * rng.unit());
    }
    TestDir::new(&[("s.csv", &spheres), ("rays.csv", &rays)])
}

#[test]
fn every_backend_and_search_gives_the_same_hits() {
    let dir = dir();
    let traced = |words: &str| -> Vec<Vec<f64>> {
        let Output { out, err, .. } = dir.good(&format!("trace s.csv --rays rays.csv -o - {words}"));
        assert!(err.contains("tracing on "), "{err}");
        let text = String::from_utf8(out).expect("text");
        text.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().expect("a number")).collect()).collect()
    };
    let cpu = traced("--backend cpu");
    let hits = cpu.iter().filter(|row| row[0] >= 0.0).count();
    assert!((200..1900).contains(&hits), "{hits} hits");
    let mut others = vec![
        "--backend cpu --search all",
        "--backend cpu --search tree",
        "--backend cpu --accuracy exact",
        "--backend cpu --accuracy fast",
    ];
    if gpu().is_some() {
        others.extend(["--backend gpu", "--backend gpu --accuracy fast", "--backend gpu --accuracy fast --search all"]);
    }
    for words in others {
        let other = traced(words);
        for (n, (a, b)) in cpu.iter().zip(&other).enumerate() {
            assert_eq!(a[0], b[0], "{words}: ray {n}");
            let close = |k: usize| a[k] == b[k] || (a[k] / b[k] - 1.0).abs() < 1e-4;
            assert!(close(1) && close(2), "{words}: ray {n}: {a:?}, {b:?}");
        }
        let any = traced(&format!("{words} --any"));
        assert!(any.iter().zip(&cpu).all(|(any, row)| (any[0] == 1.0) == (row[0] >= 0.0)), "{words} --any");
    }
    if let Some(renderer) = gpu() {
        let report = dir.good("trace s.csv --rays rays.csv --backend gpu --accuracy fast --json").json();
        assert_eq!((&report["backend"], &report["adapter"]), (&"gpu".into(), &renderer.adapter().into()));
        let report = dir.good("trace s.csv --rays rays.csv --backend gpu --json").json();
        assert_eq!((&report["backend"], &report["adapter"]), (&"cpu".into(), &"cpu".into()), "certified");
    }
}
