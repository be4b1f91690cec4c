//! Certified frames on software adapters: the device searches, the host certifies and shades the winners.

use super::Gpu;
use super::input::{Input, Output};
use crate::answers::raw::Raw;
use crate::cpu;
use crate::error::Result;
use crate::kernel::Kernel;
use crate::memory::Pool;
use crate::search::tile_candidates::CandidateList;

impl Gpu {
    /// Fills `output` as `wanted` would on its own, by `search` and then on the host. `go_on` as for [`Gpu::run`].
    ///
    /// # Errors
    /// Those of [`Gpu::run`].
    pub(crate) fn find_winners(
        &mut self,
        search: &Kernel,
        wanted: &Kernel,
        input: &Input<'_>,
        output: &mut Output<'_>,
        pool: &Pool,
        go_on: &dyn Fn(u64) -> bool,
    ) -> Result<()> {
        let mut found = Raw::new(search, input.view.record.pixels(), pool)?;
        self.run(search, input, &mut Output { raw: &mut found, timings: output.timings }, go_on)?;
        let Output { raw, timings } = output;
        if let Some(CandidateList::Certified(binned)) = input.candidates {
            timings.time("finish", || cpu::finish(wanted, input.view, binned, input.colors, &found, raw));
        }
        found.put_back(pool);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certify::binned::{BinnedScene, Binning};
    use crate::frame::report::Timings;
    use crate::gpu::device;
    use crate::gpu::input::KernelRays;
    use crate::gpu::submission_budget::SubmissionBudget;
    use crate::intersect::Method;
    use crate::kernel::{Generals, Sharing};
    use crate::shade::Shade;
    use crate::testing::{adapter_or_skip, near_and_far};
    use crate::view::View;
    use crate::view::raster::Raster;
    use crate::view::ray::NONE;
    use crate::window::Window;

    fn same_bits(a: &Raw, b: &Raw, what: &str) {
        assert!(a.id == b.id, "ids: {what}");
        let numbers = |raw: &Raw| -> Vec<u32> {
            let all = raw.t.iter().chain(&raw.depth_interval).chain(&raw.normal).chain(&raw.color);
            all.map(|x| x.to_bits()).collect()
        };
        assert!(numbers(a) == numbers(b), "numbers: {what}");
    }

    /// A device that only searches gives the frame of the CPU path, whole and in bands, in windows and for samples; and
    /// general spheres as constants give the frame of their lists.
    #[test]
    fn searching_and_finishing_are_the_whole_frame() {
        let Some(found) = adapter_or_skip() else { return };
        let open = || Gpu::new(device::open(&found).expect("a device"), found.summary.clone());
        let (mut gpu, mut cut, mut other) = (open(), open(), open());
        cut.budget = SubmissionBudget::minimal();
        let pool = Pool::default();
        let shaded = Kernel {
            sharing: found.summary.sharing(),
            shade: Some(Shade::Headlight),
            colors: true,
            t: true,
            normal: true,
            certify: true,
            depth_interval: true,
            ..Kernel::bare(Method::Stable)
        };
        for near in [0, 1, 3, 4, 6] {
            let scene = near_and_far(near);
            let colors = scene.spheres.colors.as_deref();
            let part = Window { x0: 37, y0: 11, x1: 102, y1: 59 };
            let samples = Raster::samples(part, 4, 7, &scene.image).expect("room").expect("several samples");
            for raster in [Raster::centres(Window::full(131, 74)), Raster::centres(part), samples] {
                let what = format!("{near} near, {raster:?}");
                let kernel = Kernel { samples: raster.count() > 1, ..shaded };
                let mut view = View::for_rays(&scene, raster, kernel.records()).expect("a view");
                view.record.sample = raster.count() / 2;
                let binned =
                    BinnedScene::new(&Binning::of(&scene, &view, 1e-6, &pool)).expect("a stage").expect("a lens");
                assert_eq!(binned.generals.len(), near);
                let raw = || Raw::new(&kernel, view.record.pixels(), &pool).expect("room");
                let (mut host, mut timings) = (raw(), Timings::default());
                cpu::certified(&kernel, &view, &binned, colors, &mut host, &|| true);
                assert!(host.id.iter().filter(|id| **id != NONE).count() > 1000, "the scene shows something");
                let candidates = Some(CandidateList::Certified(&binned));
                let input = Input { view: &view, colors, rays: KernelRays::Viewing, candidates };
                let search = Kernel { generals: Generals::of(near), ..kernel }.winners();
                let alone = Kernel { sharing: Sharing::None, ..search };
                for (gpu, search) in [(&mut gpu, search), (&mut cut, search), (&mut other, alone)] {
                    let mut raw = raw();
                    let mut output = Output { raw: &mut raw, timings: &mut timings };
                    gpu.find_winners(&search, &kernel, &input, &mut output, &pool, &|_| true).expect("a frame");
                    same_bits(&raw, &host, &what);
                }
            }
        }
    }
}
