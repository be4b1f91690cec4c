//! Frames that nobody rendered: random numbers in every buffer, the awkward among them, and parts cut from them.

use halfline::frame::file::Target;
use halfline::frame::provenance::Origin;
use halfline::frame::sheet::Sheet;
use halfline::frame::{Aov, Buffer, Data, Frame};
use halfline::report::Report;
use halfline::settings::Settings;
use halfline::window::Window;
use std::path::Path;

/// SplitMix64: the same numbers everywhere.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number of `from` to `to`, the end excluded.
    pub(crate) fn within(&mut self, from: u32, to: u32) -> u32 {
        from + (self.next() % u64::from(to - from)) as u32
    }

    /// From 0 to 1.
    pub(crate) fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A part of a frame.
    pub(crate) fn window(&mut self, [width, height]: [u32; 2]) -> Window {
        let (x0, y0) = (self.within(0, width), self.within(0, height));
        Window { x0, y0, x1: self.within(x0, width) + 1, y1: self.within(y0, height) + 1 }
    }
}

/// A full frame of every buffer; a third of its pixels are misses, with the values that are promised there.
pub(crate) fn frame(seed: u64, full: [u32; 2]) -> Frame {
    let [width, height] = full;
    let pixels = width as usize * height as usize;
    let mut random = Random(seed);
    let misses: Vec<bool> = (0..pixels).map(|_| random.next().is_multiple_of(3)).collect();
    let mut buffers = Vec::new();
    for aov in Aov::ALL {
        let mut values = |miss: f64, hit: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let channels = misses.iter().flat_map(|miss| std::iter::repeat_n(*miss, aov.channels()));
            channels.map(|missed| if missed { miss } else { hit(random.share()) }).collect()
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
        ..Report::default()
    };
    Frame { width, height, window: Window::full(width, height), full, buffers, report }
}

/// The part of a full frame, as rendering it alone would give it.
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

/// Where `frame` comes from: the scene `fingerprint`.
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

/// Writes the file of `frame` and reads it back.
pub(crate) fn written(frame: &Frame, target: &Target) -> (Vec<u8>, Sheet<'static>) {
    let settings = Settings::default();
    target.write(frame, &origin(frame, &settings, "scene")).expect("written");
    let bytes = std::fs::read(target.path()).expect("there");
    let (format, sheet) = read(target.path());
    assert_eq!(format, target.format());
    (bytes, sheet)
}

/// The file's format and content.
pub(crate) fn read(path: &Path) -> (halfline::frame::format::Format, Sheet<'static>) {
    Sheet::read(path).unwrap_or_else(|error| panic!("{error}"))
}
