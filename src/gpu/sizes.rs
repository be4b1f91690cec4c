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
    /// The most spheres of a frame that the host places, pieces of large spheres, and pairs of an unsure pixel and a sphere.
    HOST_SPHERES 1 << 16;
    PIECES 1 << 20;
    PAIRS 1 << 20;
    /// Indices of the summary's words: bounds of the depths, certain and possible; the numbers of spheres for the host, of
    /// pieces and of pairs; a word above 0 where pieces are too many to be counted; the first word of the list of spheres.
    SUMMARY_DEPTHS 0;
    SUMMARY_PERHAPS 2;
    SUMMARY_HOST 4;
    SUMMARY_PIECES 5;
    SUMMARY_PAIRS 6;
    SUMMARY_MORE 7;
    SUMMARY_LIST 8;
    /// Pixels along a side of a piece. A sphere with more than [`CUT`] pieces has pieces up to 2^[`COARSEST`] times as wide.
    PIECE 32;
    CUT 1 << 14;
    COARSEST 3;
    /// The most pixels of a sphere that one invocation visits.
    MAX_PIXELS_PER_INVOCATION 256;
    /// The most general spheres in a uniform.
    MAX_GENERALS_WITHOUT_LISTS Generals::MAX_WITHOUT_LISTS as u32;
    /// Steps through a tree of an invocation before it is left to the host. Each is at most three iterations of loops, and
    /// llvmpipe ends the loops of a vector of up to 16 invocations after 65,536 iterations together.
    STEPS 1300;
    /// The passes of shaders/splat.
    LEAST 0;
    SLOTS 1;
    PAIRS_OF_UNSURE 2;
}
