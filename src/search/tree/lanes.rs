//! Vectors of eight f32. The compiler does not make good vectors of these loops by itself, so processors with AVX2 get
//! their instructions by name; all others get loops.

use super::WIDE;

/// Rays that one task answers.
pub(crate) const RAYS_PER_TASK: usize = 256;

/// Work that is compiled for vectors of each kind. A trait, because a closure would not be compiled with
/// the vector instructions of its caller.
pub(crate) trait Work {
    type Output;
    fn work<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Does the work with the processor's widest vectors.
#[inline(always)]
pub(crate) fn dispatch<W: Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(lanes) = pulp::x86::V3::try_new() {
        return lanes.vectorize(avx2::Vectorized { lanes, work });
    }
    work.work(Portable)
}

/// Eight numbers, with every operation rounded as for a single f32.
pub(crate) trait Lanes: Copy + Send + Sync {
    type Number: Copy;
    type Keys: Copy;
    fn load(self, numbers: &[f32; WIDE]) -> Self::Number;
    fn splat(self, number: f32) -> Self::Number;
    fn add(self, a: Self::Number, b: Self::Number) -> Self::Number;
    fn sub(self, a: Self::Number, b: Self::Number) -> Self::Number;
    fn mul(self, a: Self::Number, b: Self::Number) -> Self::Number;
    /// The lesser; of NaN the second.
    fn min(self, a: Self::Number, b: Self::Number) -> Self::Number;
    /// The greater; of NaN the second.
    fn max(self, a: Self::Number, b: Self::Number) -> Self::Number;
    /// One bit for each lane where a <= b.
    fn at_most(self, a: Self::Number, b: Self::Number) -> u32;
    /// The numbers of `near`, none of them negative, as keys that compare like them: their bits, with the lane
    /// in place of the last three. [`NEVER`] where `near` is not at most `far`.
    fn keys(self, near: Self::Number, far: Self::Number) -> Self::Keys;
    /// The least key, which is replaced by [`NEVER`].
    fn take_least(self, keys: &mut Self::Keys) -> u32;
}

/// The bits of a key that tell the lane.
pub(crate) const LANE: u32 = WIDE as u32 - 1;

/// Above every key.
pub(crate) const NEVER: u32 = u32::MAX;

/// Lanes as arrays, for every processor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Portable;

macro_rules! by_lane {
    ($($name:ident($a:ident, $b:ident) $result:expr;)*) => {$(
        #[inline(always)]
        fn $name(self, a: Self::Number, b: Self::Number) -> Self::Number {
            std::array::from_fn(|lane| {
                let ($a, $b) = (a[lane], b[lane]);
                $result
            })
        }
    )*};
}

impl Lanes for Portable {
    type Number = [f32; WIDE];
    type Keys = [u32; WIDE];
    #[inline(always)]
    fn load(self, numbers: &[f32; WIDE]) -> Self::Number {
        *numbers
    }
    #[inline(always)]
    fn splat(self, number: f32) -> Self::Number {
        [number; WIDE]
    }
    by_lane! {
        add(a, b) a + b;
        sub(a, b) a - b;
        mul(a, b) a * b;
        min(a, b) if a < b { a } else { b };
        max(a, b) if a > b { a } else { b };
    }
    #[inline(always)]
    fn at_most(self, a: Self::Number, b: Self::Number) -> u32 {
        (0..WIDE).fold(0, |mask, lane| mask | u32::from(a[lane] <= b[lane]) << lane)
    }
    #[inline(always)]
    fn keys(self, near: Self::Number, far: Self::Number) -> Self::Keys {
        let key = |lane: usize| near[lane].to_bits() & !LANE | lane as u32;
        std::array::from_fn(|lane| if near[lane] <= far[lane] { key(lane) } else { NEVER })
    }
    #[inline(always)]
    fn take_least(self, keys: &mut Self::Keys) -> u32 {
        let least = keys.iter().fold(NEVER, |least, key| least.min(*key));
        *keys = keys.map(|key| if key == least { NEVER } else { key });
        least
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{LANE, Lanes, WIDE, Work};
    use pulp::x86::V3;
    use pulp::{NullaryFnOnce, cast};
    use std::arch::x86_64::{__m256, __m256i};

    /// Work as pulp takes it.
    pub(super) struct Vectorized<W> {
        pub(super) lanes: V3,
        pub(super) work: W,
    }

    impl<W: Work> NullaryFnOnce for Vectorized<W> {
        type Output = W::Output;
        #[inline(always)]
        fn call(self) -> W::Output {
            self.work.work(self.lanes)
        }
    }

    macro_rules! by_instruction {
        ($($name:ident $instruction:ident)*) => {$(
            #[inline(always)]
            fn $name(self, a: __m256, b: __m256) -> __m256 {
                self.avx.$instruction(a, b)
            }
        )*};
    }

    impl Lanes for V3 {
        type Number = __m256;
        type Keys = __m256i;
        #[inline(always)]
        fn load(self, numbers: &[f32; WIDE]) -> __m256 {
            cast(*numbers)
        }
        #[inline(always)]
        fn splat(self, number: f32) -> __m256 {
            self.avx._mm256_set1_ps(number)
        }
        by_instruction! {
            add _mm256_add_ps
            sub _mm256_sub_ps
            mul _mm256_mul_ps
            min _mm256_min_ps
            max _mm256_max_ps
        }
        #[inline(always)]
        fn at_most(self, a: __m256, b: __m256) -> u32 {
            // 18: less or equal, quiet, false for NaN.
            self.avx._mm256_movemask_ps(self.avx._mm256_cmp_ps::<18>(a, b)) as u32
        }
        #[inline(always)]
        fn keys(self, near: __m256, far: __m256) -> __m256i {
            let lanes: __m256i = cast([0u32, 1, 2, 3, 4, 5, 6, 7]);
            // 22: not less or equal, quiet, true for NaN. All ones in the lanes that are absent.
            let absent: __m256i = cast(self.avx._mm256_cmp_ps::<22>(near, far));
            let high = self.avx2._mm256_andnot_si256(self.avx._mm256_set1_epi32(LANE as i32), cast(near));
            self.avx2._mm256_or_si256(self.avx2._mm256_or_si256(high, lanes), absent)
        }
        #[inline(always)]
        fn take_least(self, keys: &mut __m256i) -> u32 {
            let avx2 = self.avx2;
            let least = avx2._mm256_min_epu32(*keys, avx2._mm256_permute2x128_si256::<1>(*keys, *keys));
            let least = avx2._mm256_min_epu32(least, avx2._mm256_shuffle_epi32::<0b01_00_11_10>(least));
            let least = avx2._mm256_min_epu32(least, avx2._mm256_shuffle_epi32::<0b10_11_00_01>(least));
            *keys = avx2._mm256_or_si256(*keys, avx2._mm256_cmpeq_epi32(*keys, least));
            self.sse2._mm_cvtsi128_si32(self.avx._mm256_castsi256_si128(least)) as u32
        }
    }
}
