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

/// How the invocations of a subgroup share loaded spheres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Sharing {
    /// Every invocation loads for itself; the hardware combines loads of the same address.
    None,
    /// Broadcast within subgroups of 4.
    Subgroup4,
    /// Broadcast within subgroups of 8.
    Subgroup8,
    /// Shuffle within subgroups of any size.
    Shuffle,
}

impl Sharing {
    #[cfg(test)]
    pub(crate) const ALL: [Self; 4] = [Self::None, Self::Subgroup4, Self::Subgroup8, Self::Shuffle];
}

/// How a certified kernel reads the spheres that are not entirely in front of the eye plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Generals {
    /// There are none.
    None,
    /// So many, from a uniform buffer at constant places: every ray tests all of them.
    Few(u32),
    /// From the lists of the tiles.
    Lists,
}

/// The most general spheres that every ray tests without lists.
const FEW: usize = 4;

impl Generals {
    /// For so many.
    pub(crate) fn of(count: usize) -> Self {
        match count {
            0 => Self::None,
            1..=FEW => Self::Few(count as u32),
            _ => Self::Lists,
        }
    }
}

/// The parameters that a kernel is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Kernel {
    pub(crate) method: Method,
    pub(crate) rays: RaySource,
    pub(crate) sharing: Sharing,
    /// Writes colours with this shading.
    pub(crate) shade: Option<Shade>,
    /// The spheres have individual colours.
    pub(crate) colors: bool,
    /// Writes t.
    pub(crate) t: bool,
    /// Writes normals.
    pub(crate) normal: bool,
    /// Certifies its answers; `method` is unused. Given rays are then [`RaySource::Spread`], and only ids are written:
    /// places in the order of the tree.
    pub(crate) certify: bool,
    /// Spheres that are not entirely in front of the eye plane. Known only after binning.
    pub(crate) generals: Generals,
    /// Searches candidate lists and writes what it found, instead of the certified answers: the slot of the winner as id,
    /// and the two smallest lower bounds. The host does the rest (`cpu::finish`). Any other certified kernel of viewing rays
    /// finds the winners that spheres left in the pixels (gpu/resident.rs).
    pub(crate) winners: bool,
    /// `method` tests the candidates of the ray's tile instead of every sphere. Always the case for certified viewing rays.
    pub(crate) tiles: bool,
    /// Writes the width of the depth interval.
    pub(crate) depth_interval: bool,
    /// Certified given rays traverse a tree instead of testing every sphere.
    pub(crate) tree: bool,
    /// Certified given rays: whether anything is hit, instead of what is hit first.
    pub(crate) any: bool,
    /// Viewing rays pass through samples of the pixels, or belong to an off-centre lens: their places are computed
    /// (main/sample.wgsl); otherwise they pass through the pixels' centres.
    pub(crate) samples: bool,
    /// A resident kernel leaves the starts of rays from the hits on the device.
    pub(crate) starts: bool,
}

impl Kernel {
    /// A kernel for viewing rays that tests every sphere and writes ids only.
    pub(crate) fn bare(method: Method) -> Self {
        Self {
            method,
            rays: RaySource::Camera,
            sharing: Sharing::None,
            shade: None,
            colors: false,
            t: false,
            normal: false,
            certify: false,
            generals: Generals::None,
            winners: false,
            tiles: false,
            depth_interval: false,
            tree: false,
            any: false,
            samples: false,
            starts: false,
        }
    }

    /// Whether the kernel uses subgroup operations. The subgroup size has to divide the chunk of a list; else it does
    /// not share.
    pub(crate) fn shares(&self) -> bool {
        match self.sharing {
            Sharing::None => false,
            Sharing::Shuffle => !self.certify && !self.tiles,
            Sharing::Subgroup4 | Sharing::Subgroup8 => true,
        }
    }

    /// The kernel that only searches what this certified kernel certifies.
    pub(crate) fn winners(self) -> Self {
        Self {
            winners: true,
            shade: None,
            colors: false,
            t: false,
            normal: false,
            depth_interval: false,
            starts: false,
            ..self
        }
    }

    /// Whether it certifies what the spheres of a device left in the pixels.
    pub(crate) fn is_resident(&self) -> bool {
        self.certify && self.rays == RaySource::Camera && !self.winners
    }

    /// Whether it writes the depths of centres, to which its own are relative.
    pub(crate) fn has_depths(&self) -> bool {
        self.is_resident() && (self.t || self.depth_interval)
    }

    /// The rows of a tile that an invocation renders: as many as shaders/certify/search_column.wgsl has.
    pub(crate) fn rows(&self) -> u32 {
        if self.winners { 4 } else { 1 }
    }

    /// Whether normals are computed, as an output or for shading.
    pub(crate) fn has_normals(&self) -> bool {
        self.normal || self.shade.is_some_and(|shade| shade != Shade::Flat)
    }

    /// Whether the kernel computes in more than f32: it reads the low parts of all inputs and writes t in two parts.
    pub(crate) fn is_wide(&self) -> bool {
        !self.certify && self.method.is_wide()
    }

    /// Whether the kernel reads the rounding residuals of the spheres.
    pub(crate) fn reads_residuals(&self) -> bool {
        !self.certify && (self.rays == RaySource::Spread || self.is_wide())
    }

    /// The sphere records that the kernel reads, besides those of candidate lists.
    pub(crate) fn records(&self) -> Records {
        match self.certify || self.tiles {
            true => Records::None,
            false if self.is_wide() => Records::WithResiduals,
            false => Records::Rounded,
        }
    }
}

macro_rules! output {
    ($name:literal, $number:literal, $channels:literal, $value:literal, $is_written:expr) => {
        KernelOutput {
            name: $name,
            staging: concat!("read ", $name),
            number: $number,
            channels: $channels,
            value: $value,
            is_written: $is_written,
        }
    };
}

/// A buffer that kernels write, with one entry per pixel or given ray.
pub(crate) struct KernelOutput {
    /// Its binding's name in WGSL.
    pub(crate) name: &'static str,
    /// The buffer from which the host reads it where the binding's own buffer cannot be mapped.
    pub(crate) staging: &'static str,
    /// The WGSL type of its values, 4 bytes each.
    pub(crate) number: &'static str,
    /// Values per pixel.
    pub(crate) channels: usize,
    /// The WGSL expression of a pixel's value in terms of `ray` and `hit`: a scalar, or a vector of `channels` values.
    pub(crate) value: &'static str,
    /// Whether a kernel writes it.
    is_written: fn(&Kernel) -> bool,
}

/// All output buffers. `gpu/compose.rs` declares, computes and stores only those that a kernel writes.
pub(crate) const OUTPUTS: [KernelOutput; 9] = [
    output!("frame_id", "u32", 1, "written_id(hit)", |_| true),
    output!("frame_t", "f32", 1, "to_hi(hit.t)", |kernel| kernel.t),
    output!("frame_t_low", "f32", 1, "to_lo(hit.t)", |kernel| kernel.t && kernel.is_wide()),
    output!("frame_depth_interval", "f32", 1, "answer.depth_interval", |kernel| kernel.depth_interval),
    output!("frame_depth", "u32", 2, "center_depth()", Kernel::has_depths),
    output!("frame_low", "f32", 1, "two.low", |kernel| kernel.winners),
    output!("frame_second", "f32", 1, "two.second", |kernel| kernel.winners),
    output!("frame_normal", "f32", 3, "world_normal(ray, hit)", |kernel| kernel.normal),
    output!("frame_color", "f32", 3, "hit_color(ray, hit)", |kernel| kernel.shade.is_some()),
];

impl KernelOutput {
    /// The outputs that `kernel` writes.
    pub(crate) fn of(kernel: &Kernel) -> impl Iterator<Item = &'static Self> {
        OUTPUTS.iter().filter(move |output| (output.is_written)(kernel))
    }

    /// Bytes per pixel.
    pub(crate) fn bytes(&self) -> u64 {
        4 * self.channels as u64
    }
}
