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
    pub(crate) nears: bool,
    /// `method` tests the candidates of a tile, not every sphere. A certified kernel always does.
    pub(crate) tiles: bool,
    /// The width of the depth's interval is written.
    pub(crate) width: bool,
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
            nears: false,
            tiles: false,
            width: false,
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
    pub(crate) fn with_nears(self, nears: bool) -> Self {
        Self { nears, ..self }
    }

    /// Whether normals are made: to be written, or to shade by.
    pub(crate) fn has_normals(&self) -> bool {
        self.normal || self.shade.is_some_and(|shade| shade != Shade::Flat)
    }

    /// Whether it computes in more than f32: it reads the low parts of all inputs and gives t in two parts.
    pub(crate) fn is_wide(&self) -> bool {
        !self.certify && self.method.is_wide()
    }

    /// The records of the spheres that it reads, beside those of candidate lists.
    pub(crate) fn records(&self) -> Records {
        match self.certify || self.tiles {
            true => Records::None,
            false if self.is_wide() => Records::WithLows,
            false => Records::Rounded,
        }
    }
}
