//! Compares the kernels that plans select by default, fast and certified, with their CPU twins bit for bit, on a cloud
//! of spheres.

use super::verdict::Check;
use crate::answers::raw::Raw;
use crate::certify::TERMS;
use crate::certify::binned::BinnedScene;
use crate::cpu;
use crate::error::Result;
use crate::frame::report::Timings;
use crate::gpu::Gpu;
use crate::gpu::input::{Input, KernelRays, Output};
use crate::intersect::Method;
use crate::kernel::{Generals, Kernel};
use crate::memory::Pool;
use crate::scene::camera::Camera;
use crate::scene::{ImagePlane, Scene, Spheres};
use crate::search::tile_candidates::{CandidateList, TileCandidates};
use crate::settings::Tolerance;
use crate::view::View;

/// The check's name.
pub(super) const NAME: &str = "kernels as their twins";

/// Pixels along a side.
const SIDE: u32 = 64;

/// 97 spheres in front of the eye; not a multiple of any subgroup size.
fn scene() -> Scene {
    cloud(97, SIDE)
}

/// Spheres in front of the eye, which overlap about as much whatever their number.
pub(super) fn cloud(count: u32, side: u32) -> Scene {
    let mut spheres = Spheres::default();
    // A Weyl sequence: fractions of multiples of irrationals fill the cube evenly (Roberts 2018, the plastic number).
    let weyl = |n: f64, x: f64| 2.0 * (n * x).fract() - 1.0;
    let size = (97.0 / f64::from(count)).cbrt();
    for n in 1..=count {
        let n = f64::from(n);
        let [x, y, z] = [0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9].map(|irrational| weyl(n, irrational));
        spheres.push([x, y, -1.5 + z], (0.05 + 0.1 * z.abs()) * size, None);
    }
    let image = ImagePlane { width: side, height: side, background: [0.0; 3] };
    Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() }
}

impl Gpu {
    /// The kernels that are compared. The lecture's forms use no other operations, and compilation dominates the time.
    pub(super) fn twin_kernels(&self) -> Vec<Kernel> {
        let kernel = |certify: bool, tiles: bool| Kernel {
            sharing: self.summary.sharing(),
            t: true,
            normal: true,
            certify,
            generals: if certify { Generals::Lists } else { Generals::None },
            tiles,
            depth_interval: certify,
            ..Kernel::bare(Method::Stable)
        };
        vec![kernel(false, false), kernel(false, true), kernel(true, false)]
    }

    pub(super) fn compare_twins(&mut self) -> Result<Check> {
        let scene = scene();
        let pool = Pool::default();
        let view = View::new(&scene)?;
        let binned = BinnedScene::new(&scene, &view, Tolerance::default().relative(), &TERMS, 0, &pool)?;
        let (mut values, mut different) = (0.0, 0.0);
        for kernel in self.twin_kernels() {
            let pixels = (SIDE * SIDE) as usize;
            let (mut device, mut host) = (Raw::new(&kernel, pixels, &pool)?, Raw::new(&kernel, pixels, &pool)?);
            let candidates = match &binned {
                Some(binned) if kernel.tiles => {
                    Some(CandidateList::Uncertified(TileCandidates::new(&view, &scene.spheres, binned, false, &pool)))
                }
                Some(binned) if kernel.certify => Some(CandidateList::Certified(binned)),
                // This scene can always be binned; without lists there is nothing to compare.
                None if kernel.tiles || kernel.certify => continue,
                _ => None,
            };
            match &candidates {
                Some(CandidateList::Certified(binned)) => {
                    cpu::certified(&kernel, &view, binned, None, &mut host, &|| true)
                }
                Some(CandidateList::Uncertified(tile_candidates)) => {
                    cpu::by_tiles(&kernel, tile_candidates, None, &mut host, &|| true)
                }
                None => cpu::render(&kernel, &view, None, &mut host, &|| true),
            }
            let input = Input { view: &view, colors: None, rays: KernelRays::Viewing, candidates };
            let mut output = Output { raw: &mut device, timings: &mut Timings::default() };
            self.run(&kernel, &input, &mut output, &|_| true)?;
            let bits = |raw: &Raw| -> Vec<u32> {
                let numbers = raw.t.iter().chain(&raw.normal).chain(&raw.depth_interval).map(|x| x.to_bits());
                raw.id.iter().copied().chain(numbers).collect()
            };
            let (device, host) = (bits(&device), bits(&host));
            values += host.len() as f64;
            different += device.iter().zip(&host).filter(|(a, b)| a != b).count() as f64;
            different += device.len().abs_diff(host.len()) as f64;
        }
        let detail = [("values".to_owned(), values), ("different".to_owned(), different)].into();
        Ok(Check { name: NAME.to_owned(), passed: different == 0.0 && values > 0.0, detail })
    }
}
