use halfline::scene::*;
use halfline::*;
use glam::DVec3;
fn main() {
    let mut s = Spheres::default();
    s.push([0.0, -1000.0, 0.0], 1000.0, Some([0.5, 0.5, 0.5]));
    let mut k = 7u64;
    let mut r = || { k = k.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407); (k >> 33) as f64 / (1u64 << 31) as f64 };
    for a in -11..11 { for b in -11..11 {
        let c = [a as f64 + 0.9 * r(), 0.2, b as f64 + 0.9 * r()];
        s.push(c, 0.2, Some([r() as f32, r() as f32, r() as f32]));
    } }
    s.push([0.0, 1.0, 0.0], 1.0, Some([0.8, 0.8, 0.8]));
    s.push([-4.0, 1.0, 0.0], 1.0, Some([0.4, 0.2, 0.1]));
    s.push([4.0, 1.0, 0.0], 1.0, Some([0.7, 0.6, 0.5]));
    let camera = Camera { eye: DVec3::new(13.0, 2.0, 3.0), look: Look::At(DVec3::ZERO), up: DVec3::Y, lens: Lens::Vfov { degrees: 20.0, distance: 1.0 } };
    let image = ImagePlane { width: 1200, height: 675, background: [0.7, 0.8, 1.0] };
    let mode = std::env::args().nth(1).unwrap();
    let lighting = match mode.as_str() {
        "sun" => Lighting { lights: vec![Light::white(LightSource::Direction(DVec3::new(1.0, 2.0, 1.5)))], shadows: true, sky: None },
        "sky" => Lighting { lights: vec![], shadows: true, sky: Some(Sky::default()) },
        "ball" => Lighting { lights: vec![Light::white(LightSource::Ball { center: DVec3::new(6.0, 8.0, 6.0), radius: 1.5 })], shadows: true, sky: Some(Sky::default()) },
        _ => Lighting::default(),
    };
    let scene = Scene { camera, image, spheres: s, skipped: Default::default(), lighting };
    let samples = std::env::args().nth(2).map_or(1, |s| s.parse().unwrap());
    let accuracy = match std::env::args().nth(3).as_deref() { Some("fast") => Accuracy::Fast, Some("exact") => Accuracy::Exact, _ => Accuracy::Certified };
    let mut aovs = vec![Aov::Color, Aov::Certainty];
    if mode != "sky" && mode != "none" { aovs.push(Aov::Shadow); }
    aovs.push(Aov::Occlusion);
    let settings = Settings { backend: Backend::Cpu, accuracy, samples, aovs, ..Default::default() };
    let mut renderer = Renderer::new(&settings).unwrap();
    let frame = renderer.render(&scene, &settings).unwrap();
    println!("{:?} {:?} {:?}", frame.report.stages_ms, frame.report.frame_ms, frame.report.warnings);
    let Data::U8(c) = &frame.get(Aov::Certainty).unwrap().data else { panic!() };
    println!("settled {}", c.iter().filter(|x| **x == 1).count());
    frame.image().unwrap().save(format!("/tmp/light_{mode}.png")).unwrap();
}
use halfline::frame::Data;
