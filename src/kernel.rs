//! The configuration of a kernel: it determines the parts of its shader and its CPU twin.

use crate::intersect::Method;
use crate::shade::Shade;
use crate::view::Records;

/// The source of a kernel's rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum RaySource {
    /// One viewing ray per pixel.
    Camera,
    /// Given rays with one common origin, which becomes the origin of the frame.
    SharedOrigin,
    /// Given rays with separate origins, in high and low parts.
    Spread,
}

/// The source of the general spheres, those not entirely in front of the eye plane, for a certified kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Generals {
    /// There are none.
    None,
    /// From a uniform buffer: every ray tests all of them.
    Few,
    /// From the lists of the tiles.
    Lists,
}

impl Generals {
    /// The most general spheres that every ray tests without lists.
    pub(crate) const MAX_WITHOUT_LISTS: usize = 4;

    /// The source for `count` general spheres.
    pub(crate) fn of(count: usize) -> Self {
        match count {
            0 => Self::None,
            1..=Self::MAX_WITHOUT_LISTS => Self::Few,
            _ => Self::Lists,
        }
    }
}

/// The answer of a pixel that f32 does not prove.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Unproved {
    /// None yet: the judge decides the pixel.
    Unsure,
    /// Its nearest candidate, without a proof.
    Nearest,
}

/// The task of a kernel: its rays, and the way it finds their hits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Task {
    /// By one form of the quadratic, among all spheres.
    Method { method: Method, rays: RaySource },
    /// Viewing rays with a certificate, from the spheres that a device holds; on the CPU path in strips.
    Certified(Certificate),
    /// Given rays with a certificate, which the host traces.
    Given,
}

/// The parameters of a certified kernel of viewing rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Certificate {
    /// Known only after the spheres are placed.
    pub(crate) generals: Generals,
    pub(crate) unproved: Unproved,
    /// Writes the width of the depth interval.
    pub(crate) depth_interval: bool,
    /// Leaves the starts of rays from the hits on the device.
    pub(crate) starts: bool,
    /// Planes cut some spheres.
    pub(crate) planes: bool,
}

impl Certificate {
    /// The certificate without general spheres and further outputs; the judge decides the unproved pixels.
    pub(crate) const PLAIN: Self = Self {
        generals: Generals::None,
        unproved: Unproved::Unsure,
        depth_interval: false,
        starts: false,
        planes: false,
    };
}

/// The parameters that a kernel is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Kernel {
    pub(crate) task: Task,
    /// Writes colours with this shading.
    pub(crate) shade: Option<Shade>,
    /// The spheres have individual colours.
    pub(crate) colors: bool,
    /// Their faces on planes have others.
    pub(crate) face_colors: bool,
    /// Writes t.
    pub(crate) t: bool,
    /// Writes normals.
    pub(crate) normal: bool,
    /// Viewing rays pass through samples of the pixels, or belong to an off-centre lens: their places are computed
    /// (main/sample.wgsl); otherwise they pass through the pixels' centres.
    pub(crate) samples: bool,
}

impl Kernel {
    /// A kernel that writes ids only.
    pub(crate) fn bare(task: Task) -> Self {
        Self { task, shade: None, colors: false, face_colors: false, t: false, normal: false, samples: false }
    }

    /// A kernel that tests every sphere by `method` for every viewing ray, and writes ids only.
    pub(crate) fn of_method(method: Method) -> Self {
        Self::bare(Task::Method { method, rays: RaySource::Camera })
    }

    /// A certified kernel of viewing rays that writes ids only.
    pub(crate) fn certified() -> Self {
        Self::bare(Task::Certified(Certificate::PLAIN))
    }

    /// The same kernel, with another certificate if it has one.
    pub(crate) fn certified_by(self, change: impl FnOnce(Certificate) -> Certificate) -> Self {
        let task = match self.task {
            Task::Certified(certificate) => Task::Certified(change(certificate)),
            task => task,
        };
        Self { task, ..self }
    }

    /// The same kernel for so many general spheres.
    pub(crate) fn with_generals(self, count: usize) -> Self {
        self.certified_by(|certificate| Certificate { generals: Generals::of(count), ..certificate })
    }

    /// The same kernel that writes ids only.
    pub(crate) fn ids_only(self) -> Self {
        let bare = Self { samples: self.samples, ..Self::bare(self.task) };
        bare.certified_by(|certificate| Certificate { depth_interval: false, ..certificate })
    }

    /// Its certificate, if it certifies viewing rays.
    pub(crate) fn certificate(&self) -> Option<Certificate> {
        match self.task {
            Task::Certified(certificate) => Some(certificate),
            _ => None,
        }
    }

    /// The form of the quadratic, unless its answers are certified.
    pub(crate) fn method(&self) -> Option<Method> {
        match self.task {
            Task::Method { method, .. } => Some(method),
            _ => None,
        }
    }

    /// The number type of its rays and spheres: f32, unless a method has another.
    pub(crate) fn arithmetic(&self) -> Method {
        self.method().unwrap_or(Method::Stable)
    }

    /// Whether it certifies viewing rays.
    pub(crate) fn is_certified(&self) -> bool {
        self.certificate().is_some()
    }

    /// Whether its rays are given.
    pub(crate) fn is_given(&self) -> bool {
        self.task == Task::Given
    }

    /// Whether its rays are the rays of pixels.
    pub(crate) fn has_pixels(&self) -> bool {
        self.is_certified() || matches!(self.task, Task::Method { rays: RaySource::Camera, .. })
    }

    /// Whether it leaves the starts of rays from the hits on the device.
    pub(crate) fn leaves_starts(&self) -> bool {
        self.certificate().is_some_and(|certificate| certificate.starts)
    }

    /// Whether planes cut some of the spheres whose hits it certifies.
    pub(crate) fn has_planes(&self) -> bool {
        self.certificate().is_some_and(|certificate| certificate.planes)
    }

    /// Whether it writes the width of the depth interval.
    pub(crate) fn has_depth_interval(&self) -> bool {
        self.certificate().is_some_and(|certificate| certificate.depth_interval)
    }

    /// Whether it writes the depths of centres, to which its own are relative. Of given rays they are t itself, in f64.
    pub(crate) fn has_depths(&self) -> bool {
        self.is_certified() && (self.t || self.has_depth_interval()) || self.is_given() && self.t
    }

    /// Whether normals are computed, as an output or for shading.
    pub(crate) fn has_normals(&self) -> bool {
        self.normal || self.shade.is_some_and(|shade| shade != Shade::Flat)
    }

    /// Whether the kernel computes in more than f32: it reads the low parts of all inputs and writes t in two parts.
    pub(crate) fn is_wide(&self) -> bool {
        self.method().is_some_and(Method::is_wide)
    }

    /// Whether the kernel reads the rounding residuals of the spheres.
    pub(crate) fn reads_residuals(&self) -> bool {
        self.is_wide() || matches!(self.task, Task::Method { rays: RaySource::Spread, .. })
    }

    /// The sphere records that the kernel reads.
    pub(crate) fn records(&self) -> Records {
        match self.task {
            Task::Method { .. } if self.is_wide() => Records::WithResiduals,
            Task::Method { .. } => Records::Rounded,
            _ => Records::None,
        }
    }
}

/// Values that kernels write, for each pixel or given ray.
pub(crate) struct KernelOutput {
    pub(crate) name: &'static str,
    /// The WGSL type of its values, 4 bytes each.
    pub(crate) number: &'static str,
    /// Values per pixel.
    pub(crate) channels: usize,
    /// The WGSL expression of a pixel's value in terms of `ray` and `hit`: a scalar, or a vector of `channels` values.
    pub(crate) value: &'static str,
    /// Whether a kernel writes it.
    is_written: fn(&Kernel) -> bool,
}

/// All outputs. `gpu/compose.rs` declares, computes and stores only those that a kernel writes.
pub(crate) const OUTPUTS: [KernelOutput; 7] = [
    output("frame_id", "u32", 1, "written_id(hit)", |_| true),
    output("frame_t", "f32", 1, "to_hi(hit.t)", |kernel| kernel.t),
    output("frame_t_low", "f32", 1, "to_lo(hit.t)", |kernel| kernel.t && kernel.is_wide()),
    output("frame_depth_interval", "f32", 1, "answer.depth_interval", Kernel::has_depth_interval),
    output("frame_depth", "u32", 2, "center_depth()", Kernel::has_depths),
    output("frame_normal", "f32", 3, "world_normal(ray, hit)", |kernel| kernel.normal),
    output("frame_color", "f32", 3, "hit_color(ray, hit)", |kernel| kernel.shade.is_some()),
];

/// The buffers of outputs: ids, which other kernels read too, and all others one after the other, because adapters bind few
/// buffers.
pub(crate) const OUTPUT_BUFFERS: [&str; 2] = ["frame_id", "frame_values"];

const fn output(
    name: &'static str,
    number: &'static str,
    channels: usize,
    value: &'static str,
    is_written: fn(&Kernel) -> bool,
) -> KernelOutput {
    KernelOutput { name, number, channels, value, is_written }
}

impl KernelOutput {
    /// The outputs that `kernel` writes.
    pub(crate) fn of(kernel: &Kernel) -> impl Iterator<Item = &'static Self> {
        OUTPUTS.iter().filter(move |output| (output.is_written)(kernel))
    }

    /// The outputs that `kernel` writes to a buffer, each with the values per pixel before it: it begins at so many
    /// times the number of pixels.
    pub(crate) fn in_buffer(kernel: &Kernel, buffer: &str) -> impl Iterator<Item = (&'static Self, usize)> {
        let [ids, _] = OUTPUT_BUFFERS;
        let of_ids = buffer == ids;
        Self::of(kernel).filter(move |output| (output.name == ids) == of_ids).scan(0, |next, output| {
            let before = *next;
            *next += output.channels;
            Some((output, before))
        })
    }

    /// The buffers that `kernel` writes, and their bytes per pixel.
    pub(crate) fn buffers(kernel: &Kernel) -> impl Iterator<Item = (&'static str, u64)> {
        let bytes = |buffer| Self::in_buffer(kernel, buffer).map(|(output, _)| output.bytes()).sum();
        OUTPUT_BUFFERS.map(|buffer| (buffer, bytes(buffer))).into_iter().filter(|(_, bytes)| *bytes > 0)
    }

    /// Bytes per pixel of the largest buffer that `kernel` writes.
    pub(crate) fn largest(kernel: &Kernel) -> u64 {
        Self::buffers(kernel).map(|(_, bytes)| bytes).max().unwrap_or_default()
    }

    /// Bytes per pixel.
    pub(crate) fn bytes(&self) -> u64 {
        4 * self.channels as u64
    }
}
