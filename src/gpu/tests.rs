//! A frame that is split into bands, by time or by the size of a binding, has the same bits.

use super::submission_budget::SubmissionBudget;
use crate::answers::raw::Raw;
use crate::frame::report::Timings;
use crate::gpu::input::{Input, KernelRays, Output};
use crate::gpu::{Gpu, device};
use crate::intersect::Method;
use crate::kernel::Kernel;
use crate::shade::Shade;
use crate::testing::{adapter_or_skip, amount};
use crate::view::View;
use halfline_ground::error::Error;
use halfline_ground::memory::Pool;
use std::cell::Cell;

/// Columns and rows, neither a multiple of a tile's side.
const SIZE: [u32; 2] = [67, 45];

/// A frame of weekend, cancelled after this many bands; and the number of its bands.
fn frame(gpu: &mut Gpu, kernel: &Kernel, bands: usize) -> (Result<Raw, Error>, usize) {
    frame_while(gpu, kernel, &|begun| begun <= bands)
}

/// The same; `go_on` is called before every band, with its number from 1.
fn frame_while(gpu: &mut Gpu, kernel: &Kernel, go_on: &dyn Fn(usize) -> bool) -> (Result<Raw, Error>, usize) {
    let scene = crate::testing::weekend(SIZE);
    let mut view = View::new(&scene).expect("a view");
    view.keep_residuals(&scene.spheres.centers, &scene.spheres.radii);
    let pool = Pool::default();
    let mut raw = Raw::new(kernel, (SIZE[0] * SIZE[1]) as usize, &pool).expect("room");
    let input = Input { view: &view, colors: scene.spheres.colors.as_deref(), rays: KernelRays::Viewing };
    let mut output = Output { raw: &mut raw, timings: &mut Timings::default() };
    let progress = Cell::new(Vec::new());
    let next = |done| {
        let mut all = progress.take();
        all.push(done);
        let on = go_on(all.len());
        progress.set(all);
        on
    };
    let outcome = gpu.run(kernel, &input, &mut output, &next);
    let progress = progress.take();
    assert!(
        progress.first().is_none_or(|done| *done == 0)
            && progress.is_sorted()
            && progress.iter().all(|done| done % u64::from(SIZE[0]) == 0),
        "{progress:?}"
    );
    (outcome.map(|()| raw), progress.len())
}

/// The pinned adapter, opened twice.
fn two() -> Option<[Gpu; 2]> {
    let found = adapter_or_skip()?;
    let open = || Gpu::new(device::open(&found).expect("a device"), found.summary.clone());
    Some([open(), open()])
}

/// Kernels of methods in f32 and in wider arithmetic.
fn kernels() -> [Kernel; 2] {
    [Method::Stable, Method::DoubleFloat].map(|method| Kernel {
        shade: Some(Shade::Flat),
        colors: true,
        t: true,
        ..Kernel::of_method(method)
    })
}

/// A frame in bands has the same bits, also after a cancelled frame.
#[test]
fn a_frame_of_several_bands_has_the_same_bits() {
    let Some([mut whole, mut cut]) = two() else { return };
    cut.budget = SubmissionBudget::minimal();
    for kernel in kernels() {
        let (one, bands) = frame(&mut whole, &kernel, usize::MAX);
        assert_eq!(bands, 1, "{kernel:?} is light");
        for ended in [3, usize::MAX] {
            let (many, bands) = frame(&mut cut, &kernel, ended);
            match many {
                Err(Error::Interrupted) => assert_eq!((bands, ended), (4, 3)),
                Err(error) => panic!("{error}"),
                Ok(many) => {
                    assert!(bands > 3, "{bands} bands");
                    assert!(many == *one.as_ref().expect("a frame"), "{kernel:?} differs");
                }
            }
        }
    }
}

/// A device that is lost before a frame or between any two of its bands is reported as lost, for that frame and all later
/// ones.
#[test]
fn a_lost_device_is_reported() {
    for last in (0..4).step_by(4 / amount("bands after which a device is lost", [2, 4, 4])) {
        let Some([mut gpu, _]) = two() else { return };
        gpu.budget = SubmissionBudget::minimal();
        for kernel in kernels() {
            frame(&mut gpu, &kernel, usize::MAX).0.expect("a frame");
            let device = gpu.open.device.clone();
            if last == 0 {
                device.destroy();
            }
            let lose = |band| {
                if band == last {
                    device.destroy();
                }
                true
            };
            for again in 0..3 {
                match frame_while(&mut gpu, &kernel, &lose).0 {
                    Err(Error::DeviceLost(why)) => assert!(!why.is_empty()),
                    other => panic!("after {last} bands, {again}: {:?}", other.map(|_| "a frame")),
                }
            }
            let Some([another, _]) = two() else { return };
            gpu = another;
            gpu.budget = SubmissionBudget::minimal();
        }
    }
}

/// An adapter that is listed but does not open is skipped, and the reason is stored.
#[test]
fn an_adapter_that_does_not_open_is_skipped() {
    let Some(_) = adapter_or_skip() else { return };
    let found = || device::find().expect("adapters");
    let count = found().len();
    let shut = |found: &device::FoundAdapter| -> Result<device::Open, Error> {
        let problem = format!("{} does not open: it is a test", found.summary.name);
        Err(Error::Adapter { problem, mend: String::new() })
    };
    let mut passed_over = Vec::new();
    assert!(device::open_first(&found(), shut, &mut passed_over).is_none());
    assert!(
        passed_over.len() == count && passed_over.iter().all(|why| why.contains("it is a test")),
        "{passed_over:?}"
    );
    let first = Cell::new(true);
    let all: Vec<_> = found().into_iter().chain(found()).collect();
    let open = |found: &device::FoundAdapter| if first.replace(false) { shut(found) } else { device::open(found) };
    passed_over.clear();
    assert!(device::open_first(&all, open, &mut passed_over).is_some() && passed_over.len() == 1, "{passed_over:?}");
}

/// A scene that exceeds a binding is refused with the number of spheres that fits.
#[test]
fn a_scene_beyond_a_binding_is_refused_with_the_number_that_fits() {
    let Some([mut small, _]) = two() else { return };
    let [plain, _] = kernels();
    for (binding, fit) in [(8 << 10, 256), (4 << 10, 128)] {
        small.limits.max_storage_buffer_binding_size = binding;
        match frame(&mut small, &plain, usize::MAX).0 {
            Err(Error::Limits { mend, .. }) => assert!(mend.contains(&format!("at most {fit} spheres")), "{mend}"),
            other => panic!("{binding} bytes a binding: {:?}", other.map(|_| "a frame")),
        }
    }
}
