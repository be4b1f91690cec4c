//! Answers of the device beside answers of the CPU path.

use super::Result;
use super::cloud::cloud;
use super::scenes::{Times, looked, report_json};
use halfline::frame::{Data, Frame};
use halfline::{Aov, Backend, Method, Renderer, Settings};
use serde_json::{Map, Value, json};

/// The largest differences of two certified frames: each is within 1e-5 of the true distance and within 1e-3 of the true normal.
/// Colours are made of normals. Ids, masks and shares of the sky have no tolerance.
const DISTANCE: f64 = 2e-5;
const NORMAL: f64 = 2e-3;
/// The share of colours that may differ by more: where a comparison decides, of depths for a line or of a neighbour's rays.
const DECIDED: f64 = 1e-4;

/// The difference of two buffers: the number of values, of those that differ, and the largest differences.
struct Difference {
    values: usize,
    differ: usize,
    /// Values that differ by more than [`NORMAL`].
    beyond: usize,
    most: f64,
    relative: f64,
}

impl Difference {
    fn of(a: &Data, b: &Data) -> Result<Self> {
        fn pairs<T: Copy>(a: &[T], b: &[T], to: impl Fn(T) -> f64) -> Vec<[f64; 2]> {
            a.iter().zip(b).map(|(a, b)| [to(*a), to(*b)]).collect()
        }
        let pairs = match (a, b) {
            (Data::F32(a), Data::F32(b)) => pairs(a, b, f64::from),
            (Data::F64(a), Data::F64(b)) => pairs(a, b, |x| x),
            (Data::I32(a), Data::I32(b)) => pairs(a, b, f64::from),
            (Data::U8(a), Data::U8(b)) => pairs(a, b, f64::from),
            _ => return Err("buffers of other types".into()),
        };
        let differing = pairs.iter().filter(|[a, b]| a != b && !(a.is_nan() && b.is_nan()));
        let none = Self { values: pairs.len(), differ: 0, beyond: 0, most: 0.0, relative: 0.0 };
        Ok(differing.fold(none, |all, [a, b]| {
            let off = (a - b).abs();
            let relative = off / b.abs().max(f64::MIN_POSITIVE);
            let beyond = all.beyond + usize::from(off > NORMAL);
            Self {
                differ: all.differ + 1,
                beyond,
                most: all.most.max(off),
                relative: all.relative.max(relative),
                ..all
            }
        }))
    }

    /// Whether it is within what two certified frames promise.
    fn is_within(&self, aov: Aov) -> bool {
        match aov {
            Aov::Distance => self.relative <= DISTANCE,
            Aov::Normal => self.beyond == 0,
            Aov::Color => self.beyond as f64 <= DECIDED * self.values as f64,
            _ => self.differ == 0,
        }
    }
}

/// A frame of the device and of the CPU path.
pub(crate) fn frames(count: usize, look: &str, side: u32) -> Result {
    let [device, host] = [Backend::Gpu, Backend::Cpu].map(|backend| -> Result<Frame> {
        let (scene, settings) = looked(count, look, side, backend)?;
        Ok(Renderer::new(&settings)?.render(&scene, &settings)?)
    });
    let (device, host) = (device?, host?);
    let (mut buffers, mut good) = (Map::new(), true);
    for buffer in &device.buffers {
        let other = host.get(buffer.aov).ok_or("a buffer is missing")?;
        let difference = Difference::of(&buffer.data, &other.data)?;
        good &= difference.is_within(buffer.aov);
        let Difference { values, differ, beyond, most, relative } = difference;
        let shown = json!({ "values": values, "differ": differ, "beyond": beyond, "most": most, "relative": relative });
        buffers.insert(buffer.aov.name().to_owned(), shown);
    }
    Ok(json!({
        "spheres": count, "look": look, "side": side, "buffers": buffers, "device": report_json(&device), "host": report_json(&host), "good": good,
    }))
}

/// Frames by every method that the adapter runs. Uncertified ids may differ.
pub(crate) fn methods(count: usize, side: u32) -> Result {
    let mut scene = cloud(count);
    (scene.image.width, scene.image.height) = (side, side);
    scene.spheres.share();
    let of = |backend, method| Settings { backend, method, aovs: vec![Aov::Id, Aov::Distance], ..Settings::default() };
    let [device, host] = [Backend::Gpu, Backend::Cpu].map(|backend| Renderer::new(&of(backend, None)));
    let (mut device, mut host) = (device?, host?);
    let mut all: Vec<Value> = Vec::new();
    for &method in Method::ALL {
        let name = method.name();
        if let Err(error) = device.check_method(method) {
            all.push(json!({ "method": name, "refused": error.to_string() }));
            continue;
        }
        let settings = of(Backend::Gpu, Some(method));
        let (mut on, mut times) = (device.render(&scene, &settings)?, Times::default());
        for _ in 0..3 {
            on = device.render(&scene, &settings)?;
            times.add(&on);
        }
        let off = host.render(&scene, &of(Backend::Cpu, Some(method)))?;
        let differ = on.ids().iter().zip(off.ids()).filter(|(a, b)| a != b).count();
        let (times, cpu_ms) = (times.medians(), off.report.frame_ms[0]);
        all.push(json!({ "method": name, "times": times, "cpu_ms": cpu_ms, "ids_differ": differ }));
    }
    Ok(json!({ "spheres": count, "side": side, "methods": all }))
}
