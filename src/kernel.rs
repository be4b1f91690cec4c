//! What a kernel is: all that its shader is composed from and its CPU twin is chosen by.

use crate::intersect::Method;
use crate::shade::Shade;
use crate::view::Records;

/// Where a kernel's rays come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Rays {
    /// One viewing ray per pixel.
    Camera,
    /// Given rays that leave from one point, which is then the origin.
    SharedOrigin,
    /// Given rays from many points; their origins come in high and low parts.
    Spread,
}

/// How invocations share the spheres they load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Sharing {
    /// Every invocation loads for itself. Hardware combines loads of a shared address.
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

/// All that a kernel is compiled from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Kernel {
    pub(crate) method: Method,
    pub(crate) rays: Rays,
    pub(crate) sharing: Sharing,
    /// Colour is written, shaded so.
    pub(crate) shade: Option<Shade>,
    /// Spheres have colours of their own.
    pub(crate) colors: bool,
    /// t is written.
    pub(crate) t: bool,
    /// Normals are written.
    pub(crate) normal: bool,
    /// With a certificate instead of `method`.
    pub(crate) certify: bool,
    /// Some spheres are not wholly in front of the eye plane: only a stage tells.
    pub(crate) generals: bool,
    /// `method` tests the candidates of a tile, not every sphere. A certified kernel always does.
    pub(crate) tiles: bool,
    /// The width of the depth's interval is written.
    pub(crate) depth_interval: bool,
    /// Given rays walk a tree instead of testing every sphere.
    pub(crate) tree: bool,
    /// Viewing rays go through samples of their pixels instead of the centres.
    pub(crate) samples: bool,
}

impl Kernel {
    /// A kernel for viewing rays that tests every sphere and writes ids only.
    pub(crate) fn bare(method: Method) -> Self {
        Self {
            method,
            rays: Rays::Camera,
            sharing: Sharing::None,
            shade: None,
            colors: false,
            t: false,
            normal: false,
            certify: false,
            generals: false,
            tiles: false,
            depth_interval: false,
            tree: false,
            samples: false,
        }
    }

    /// Whether subgroups are used; lists are shared by subgroups that divide a chunk of them, or not at all.
    pub(crate) fn shares(&self) -> bool {
        match self.sharing {
            Sharing::None => false,
            Sharing::Shuffle => !self.certify && !self.tiles,
            Sharing::Subgroup4 | Sharing::Subgroup8 => true,
        }
    }

    /// The same, for a scene with spheres that are not wholly in front of the eye plane, or without any.
    pub(crate) fn with_generals(self, generals: bool) -> Self {
        Self { generals, ..self }
    }

    /// Whether normals are made: to be written, or to shade by.
    pub(crate) fn has_normals(&self) -> bool {
        self.normal || self.shade.is_some_and(|shade| shade != Shade::Flat)
    }

    /// Whether it computes in more than f32: it reads the low parts of all inputs and gives t in two parts.
    pub(crate) fn is_wide(&self) -> bool {
        !self.certify && self.method.is_wide()
    }

    /// Whether it reads what rounding took from the spheres.
    pub(crate) fn reads_residuals(&self) -> bool {
        self.rays == Rays::Spread || self.is_wide()
    }

    /// The records of the spheres that it reads, beside those of candidate lists.
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

/// A buffer that kernels write for every pixel, or given ray.
pub(crate) struct KernelOutput {
    /// Its binding's name in WGSL.
    pub(crate) name: &'static str,
    /// The buffer that the host reads it from, where it cannot read the binding's own.
    pub(crate) staging: &'static str,
    /// The WGSL type of its numbers, 4 bytes each.
    pub(crate) number: &'static str,
    /// Numbers per pixel.
    pub(crate) channels: usize,
    /// A pixel's value in WGSL, of `ray` and `hit`: a scalar, or a vector of the channels.
    pub(crate) value: &'static str,
    /// Whether a kernel writes it.
    is_written: fn(&Kernel) -> bool,
}

/// Every such buffer. What a kernel does not write is neither declared nor computed: `gpu/compose.rs` emits the stores.
pub(crate) const OUTPUTS: [KernelOutput; 6] = [
    output!("frame_id", "u32", 1, "written_id(hit)", |_| true),
    output!("frame_t", "f32", 1, "to_hi(hit.t)", |kernel| kernel.t),
    output!("frame_t_low", "f32", 1, "to_lo(hit.t)", |kernel| kernel.t && kernel.is_wide()),
    output!("frame_depth_interval", "f32", 1, "answer.depth_interval", |kernel| kernel.depth_interval),
    output!("frame_normal", "f32", 3, "world_normal(ray, hit)", |kernel| kernel.normal),
    output!("frame_color", "f32", 3, "hit_color(ray, hit)", |kernel| kernel.shade.is_some()),
];

impl KernelOutput {
    /// Those that `kernel` writes.
    pub(crate) fn of(kernel: &Kernel) -> impl Iterator<Item = &'static Self> {
        OUTPUTS.iter().filter(move |output| (output.is_written)(kernel))
    }

    /// Bytes per pixel.
    pub(crate) fn bytes(&self) -> u64 {
        4 * self.channels as u64
    }
}
