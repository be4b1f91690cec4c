//! Sizes that the host and the shaders share; compose.rs writes them into the shaders.

use crate::kernel::Generals;

macro_rules! sizes {
    ($($(#[$doc:meta])* $name:ident $value:expr;)*) => {
        $($(#[$doc])* pub(crate) const $name: u32 = $value;)*

        /// Their declarations in WGSL.
        pub(crate) fn declarations() -> String {
            [$((stringify!($name), $name)),*].map(|(name, value)| format!("const {name}: u32 = {value}u;\n")).concat()
        }
    };
}

sizes! {
    /// The most spheres of a frame that the host places.
    HOST_SPHERES 1 << 16;
    /// The most pieces of large spheres.
    PIECES 1 << 20;
    /// The most pairs of an unsure pixel and a sphere.
    PAIRS 1 << 20;
    /// First word of the summary: bounds of the depths of spheres that certainly appear.
    SUMMARY_DEPTHS 0;
    /// Bounds of the depths of spheres that may appear.
    SUMMARY_PERHAPS 2;
    /// The number of spheres for the host.
    SUMMARY_HOST 4;
    /// The number of pieces.
    SUMMARY_PIECES 5;
    /// The number of pairs.
    SUMMARY_PAIRS 6;
    /// Above 0 where pieces are too many to be counted.
    SUMMARY_MORE 7;
    /// The least slot of the spheres aside that may be general; more than any slot where there is none.
    SUMMARY_MISSED 8;
    /// First word of the list of spheres for the host.
    SUMMARY_LIST 9;
    /// Pixels along a side of a piece.
    PIECE 32;
    /// The most pieces of this size of a sphere; beyond, its pieces are wider.
    CUT 1 << 14;
    /// The widest pieces are 2^COARSEST times as wide.
    COARSEST 3;
    /// The most pixels of a sphere that one invocation visits.
    MAX_PIXELS_PER_INVOCATION 256;
    /// The most general spheres in a uniform.
    MAX_GENERALS_WITHOUT_LISTS Generals::MAX_WITHOUT_LISTS as u32;
    /// Steps through a tree of an invocation before it is left to the host. Each is at most three iterations of loops, and
    /// llvmpipe ends the loops of a vector of up to 16 invocations after 65,536 iterations together.
    STEPS 1300;
    /// Pass of shaders/splat: the least depth of each pixel.
    LEAST 0;
    /// Pass of shaders/splat: the slot of that sphere, and the second least depth.
    SLOTS 1;
    /// Pass of shaders/splat: the pairs of unsure pixels.
    PAIRS_OF_UNSURE 2;
}
