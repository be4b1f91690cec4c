//! Frames of random numbers, special values among them, and parts cut from them: for tests of files, which need no renderer.

use crate::rng::Rng;
use halfline::frame::provenance::Origin;
use halfline::frame::{Aov, Buffer, Data, Frame};
use halfline::report::Report;
use halfline::scene::Sky;
use halfline::settings::Settings;
use halfline::window::Window;

/// The lights of the frames.
const LIGHTS: usize = 3;

/// A full frame of every buffer. A third of its pixels are misses, with the values that a miss has.
pub(crate) fn frame(seed: u64, full: [u32; 2]) -> Frame {
    let [width, height] = full;
    let pixels = width as usize * height as usize;
    let mut rng = Rng::new(seed + 1);
    let misses: Vec<bool> = (0..pixels).map(|_| rng.below(3) == 0).collect();
    let mut buffers = Vec::new();
    for aov in Aov::ALL {
        let mut values = |miss: f64, hit: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let channels = misses.iter().flat_map(|miss| std::iter::repeat_n(*miss, aov.channels(LIGHTS)));
            channels.map(|missed| if missed { miss } else { hit(rng.unit()) }).collect()
        };
        let f32s = |values: Vec<f64>| Data::F32(values.into_iter().map(|x| x as f32).collect());
        let data = match aov {
            Aov::Color => f32s(values(0.0, &|x| 1.25 * x)),
            Aov::Distance | Aov::Depth => Data::F64(values(f64::INFINITY, &|x| 80.0 * x * x + 1e-5)),
            Aov::Normal => f32s(values(0.0, &|x| 2.0 * x - 1.0)),
            Aov::Position => Data::F64(values(f64::NAN, &|x| 1e3 * (x - 0.5))),
            Aov::Id => Data::I32(values(-1.0, &|x| (x * 2e9).floor()).into_iter().map(|x| x as i32).collect()),
            Aov::Mask => Data::U8(values(0.0, &|_| 1.0).into_iter().map(|x| x as u8).collect()),
            Aov::Certainty => {
                let known = |x: f64| [0.0, 1.0, 255.0][(3.0 * x) as usize];
                Data::U8(values(0.0, &known).into_iter().map(|x| x as u8).collect())
            }
            Aov::Bound => Data::F64(values(0.0, &|x| 1e-6 * x)),
            Aov::Shadow => f32s(values(0.0, &|x| x)),
            Aov::Occlusion => f32s(values(1.0, &|x| x)),
            Aov::Alpha => f32s(values(0.0, &|x| (1.0 + (3.0 * x).floor()) / 4.0)),
        };
        buffers.push(Buffer::new(aov, width as usize, height as usize, data).expect("a whole buffer"));
    }
    let report = Report {
        halfline: "0.0.0",
        adapter: "a test's".into(),
        driver: "Ω \"5\"".into(),
        method: "stable",
        accuracy: "certified",
        shade: Some("headlight"),
        lights: LIGHTS as u64,
        occlusion: Some(Sky { rays: 64, reach: 2.5, ..Sky::default() }),
        ..Report::default()
    };
    Frame { width, height, window: Window::full(width, height), full, buffers, coverage: None, report }
}

/// A part of a full frame, as rendering that part alone gives it.
pub(crate) fn cut(frame: &Frame, window: Window) -> Frame {
    fn rows<T: Copy>(values: &[T], frame: &Frame, window: Window) -> Vec<T> {
        let channels = values.len() / (frame.width * frame.height) as usize;
        let at = |y: u32, x: u32| (y * frame.width + x) as usize * channels;
        (window.y0..window.y1).flat_map(|y| values[at(y, window.x0)..at(y, window.x1)].to_vec()).collect()
    }
    let part = |buffer: &Buffer| {
        let data = match &buffer.data {
            Data::F32(values) => Data::F32(rows(values, frame, window)),
            Data::F64(values) => Data::F64(rows(values, frame, window)),
            Data::I32(values) => Data::I32(rows(values, frame, window)),
            Data::U8(values) => Data::U8(rows(values, frame, window)),
            _ => panic!("a new kind of data"),
        };
        Buffer::new(buffer.aov, window.width() as usize, window.height() as usize, data).expect("a whole buffer")
    };
    Frame {
        width: window.width(),
        height: window.height(),
        window,
        buffers: frame.buffers.iter().map(part).collect(),
        ..frame.clone()
    }
}

/// The provenance of `frame`, with `fingerprint` for its scene.
pub(crate) fn origin<'a>(frame: &'a Frame, settings: &Settings, fingerprint: &str) -> Origin<'a> {
    Origin {
        fingerprint: fingerprint.into(),
        tolerance: settings.promise().relative(),
        seed: settings.seed,
        report: &frame.report,
        window: frame.window,
        full: frame.full,
    }
}
