//! Compares the kernels that plans select by default, fast and certified, with their CPU twins bit for bit, on a cloud
//! of spheres.

use super::verdict::Check;
use crate::answers::raw::Raw;
use crate::certify::binned::{BinnedScene, Binning};
use crate::certify::placing::Placer;
use crate::certify::projected::ProjectedRecord;
use crate::certify::tiles::Placed;
use crate::cpu;
use crate::frame::report::Timings;
use crate::gpu::Gpu;
use crate::gpu::input::{Input, KernelRays, Output};
use crate::gpu::resident::ResidentFrame;
use crate::intersect::Method;
use crate::kernel::{Certificate, Kernel};
use crate::scene::camera::{Camera, Lens, Look};
use crate::scene::{ImagePlane, Scene, Spheres};
use crate::settings::Tolerance;
use crate::view::raster::Raster;
use crate::view::{View, middle};
use crate::window::Window;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;

/// The check's name.
pub(super) const NAME: &str = "kernels as their twins";

/// The name of the check of records.
pub(super) const PLACES: &str = "spheres placed as in f64";

/// Pixels along a side.
const SIDE: u32 = 64;

/// 97 spheres in front of the eye.
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
    pub(super) fn twin_kernels(&self) -> [Kernel; 2] {
        let certified = Kernel::certified().certified_by(|of| Certificate { depth_interval: true, ..of });
        [Kernel::of_method(Method::Stable), certified].map(|kernel| Kernel { t: true, normal: true, ..kernel })
    }

    pub(super) fn compare_twins(&mut self) -> Result<Check> {
        let scene = scene();
        let pool = Pool::default();
        let (mut values, mut different) = (0.0, 0.0);
        for kernel in self.twin_kernels() {
            let pixels = (SIDE * SIDE) as usize;
            let (mut device, mut host) = (Raw::new(&kernel, pixels, &pool)?, Raw::new(&kernel, pixels, &pool)?);
            if kernel.is_certified() {
                let Some(frame) = self.resident(&scene, &kernel, &mut device)? else { continue };
                cpu::certified(&kernel, &frame.view, &frame.binned, [None; 2], &[], &mut host, &|| true);
            } else {
                let view = View::new(&scene)?;
                cpu::render(&kernel, &view, None, None, &mut host, &|| true);
                let input = Input { view: &view, colors: None, rays: KernelRays::Viewing };
                let mut output = Output { raw: &mut device, timings: &mut Timings::default() };
                self.run(&kernel, &input, &mut output, &|_| true)?;
            }
            let (all, wrong) = compared(&device, &host);
            (values, different) = (values + all, different + wrong);
        }
        let detail = [("values".to_owned(), values), ("different".to_owned(), different)].into();
        Ok(Check { name: NAME.to_owned(), passed: different == 0.0 && values > 0.0, detail })
    }

    /// Renders a scene whose spheres the device holds.
    fn resident(&mut self, scene: &Scene, kernel: &Kernel, raw: &mut Raw) -> Result<Option<Resident>> {
        let pool = Pool::default();
        let raster = Raster::centres(Window::full(scene.image.width, scene.image.height));
        let Some(sizes) = self.hold(scene, u64::MAX)?.and_then(|reach| reach.sizes(scene.camera.eye)) else {
            return Ok(None);
        };
        let view = View::in_unit(scene, raster, Some(middle(sizes)))?;
        let tolerance = Tolerance::default().relative();
        let (Some(placer), Some(binned)) =
            (Placer::new(scene, &view, tolerance)?, BinnedScene::new(&Binning::of(scene, &view, tolerance, &pool))?)
        else {
            return Ok(None);
        };
        let frame = ResidentFrame { scene, view: &view, placer: &placer, pool: &pool };
        let mut output = Output { raw, timings: &mut Timings::default() };
        self.render_resident(kernel, frame, &mut output, &|_| true)?;
        Ok(Some(Resident { view, placer, binned }))
    }

    /// Whether the device places spheres with the bits of the host's f64: near, far, and for parallel rays.
    pub(super) fn compare_places(&mut self) -> Result<Check> {
        let kernel = Kernel::certified();
        let near = scene();
        let far = |lens| {
            let camera = Camera {
                eye: [3.0e4, 1.7e4, 9.1e4].into(),
                look: Look::At([0.0, 0.0, -1.5].into()),
                lens,
                ..near.camera
            };
            Scene { camera, ..near.clone() }
        };
        let lenses = [Lens::Vfov { degrees: 2e-3, distance: 1.0 }, Lens::Orthographic { height: 3.0 }];
        let (mut values, mut different) = (0.0, 0.0);
        for scene in [near.clone()].into_iter().chain(lenses.map(far)) {
            let mut raw = Raw::new(&kernel, (SIDE * SIDE) as usize, &Pool::default())?;
            let Some(frame) = self.resident(&scene, &kernel, &mut raw)? else { continue };
            for (id, placed) in self.records()?.into_iter().enumerate() {
                let Some(device) = placed else { continue };
                values += 1.0;
                let host = frame.placer.placed(&scene, id as u32, frame.binned.projection.depth);
                let bits = |p: &Placed| {
                    let record = ProjectedRecord { low: 0.0, ..p.record };
                    let numbers: [[u32; 4]; 2] = [bytemuck::cast(record), bytemuck::cast(p.detail)];
                    (numbers, p.depth.to_bits())
                };
                let same = host.is_some_and(|host| bits(&host) == bits(&device));
                different += f64::from(u32::from(!same));
            }
        }
        let detail = [("spheres".to_owned(), values), ("different".to_owned(), different)].into();
        Ok(Check { name: PLACES.to_owned(), passed: different == 0.0 && values > 0.0, detail })
    }
}

/// A frame of the device, and what the host needs to compare it.
struct Resident {
    view: View,
    placer: Placer,
    binned: BinnedScene,
}

/// The number of values of two frames, and of those that differ.
fn compared(device: &Raw, host: &Raw) -> (f64, f64) {
    let bits = |raw: &Raw| -> Vec<u32> {
        let numbers = raw.t.iter().chain(&raw.normal).chain(&raw.depth_interval).map(|x| x.to_bits());
        raw.id.iter().copied().chain(numbers).collect()
    };
    let (device, host) = (bits(device), bits(host));
    let different = device.iter().zip(&host).filter(|(a, b)| a != b).count() + device.len().abs_diff(host.len());
    (host.len() as f64, different as f64)
}
