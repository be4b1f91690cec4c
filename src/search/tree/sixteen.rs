//! Vectors of sixteen f32: for processors with AVX-512 or AVX2 by name, for all others as loops. Every operation is rounded as for a
//! single f32, so the answers are the same.

use super::bounding::SIXTEEN;

/// Work that is compiled for vectors of each kind.
pub(crate) trait Work16 {
    type Output;
    fn work<S: Sixteen>(self, lanes: S) -> Self::Output;
}

/// Does the work with the processor's widest vectors.
#[inline(always)]
pub(crate) fn dispatch<W: Work16>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    match pulp::Arch::new() {
        pulp::Arch::V4(lanes) => return lanes.vectorize(x86::Vectorized { lanes, work }),
        pulp::Arch::V3(lanes) => return lanes.vectorize(x86::Vectorized { lanes, work }),
        _ => {}
    }
    work.work(Loops)
}

/// Sixteen numbers.
pub(crate) trait Sixteen: Copy + Send + Sync {
    type Number: Copy;
    fn load(self, numbers: &[f32; SIXTEEN]) -> Self::Number;
    fn store(self, numbers: Self::Number) -> [f32; SIXTEEN];
    fn splat(self, number: f32) -> Self::Number;
    fn add(self, a: Self::Number, b: Self::Number) -> Self::Number;
    fn sub(self, a: Self::Number, b: Self::Number) -> Self::Number;
    fn mul(self, a: Self::Number, b: Self::Number) -> Self::Number;
    /// One bit for each lane where a <= b.
    fn at_most(self, a: Self::Number, b: Self::Number) -> u32;
    /// Writes the numbers of the lanes with a bit, one after the other; what follows them has no meaning.
    fn pack(self, mask: u32, numbers: Self::Number, out: &mut [f32; SIXTEEN]);
    /// Writes the numbers of the lanes with a bit, from `first` on, one after the other; what follows them has no meaning.
    fn pack_lanes(self, mask: u32, first: u32, out: &mut [u32; SIXTEEN]);
}

/// Lanes as arrays, for every processor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Loops;

/// Writes what `of` has for the lanes with a bit, one after the other, without branches.
#[inline(always)]
fn pack<T: Copy>(mask: u32, of: impl Fn(usize) -> T, out: &mut [T; SIXTEEN]) {
    let mut count = 0;
    for l in 0..SIXTEEN {
        out[count & (SIXTEEN - 1)] = of(l);
        count += (mask >> l & 1) as usize;
    }
}

macro_rules! by_lane {
    ($($name:ident $operation:tt)*) => {$(
        #[inline(always)]
        fn $name(self, a: Self::Number, b: Self::Number) -> Self::Number {
            std::array::from_fn(|l| a[l] $operation b[l])
        }
    )*};
}

impl Sixteen for Loops {
    type Number = [f32; SIXTEEN];
    #[inline(always)]
    fn load(self, numbers: &[f32; SIXTEEN]) -> Self::Number {
        *numbers
    }
    #[inline(always)]
    fn store(self, numbers: Self::Number) -> [f32; SIXTEEN] {
        numbers
    }
    #[inline(always)]
    fn splat(self, number: f32) -> Self::Number {
        [number; SIXTEEN]
    }
    by_lane! { add + sub - mul * }
    #[inline(always)]
    fn at_most(self, a: Self::Number, b: Self::Number) -> u32 {
        (0..SIXTEEN).fold(0, |mask, l| mask | u32::from(a[l] <= b[l]) << l)
    }
    #[inline(always)]
    fn pack(self, mask: u32, numbers: Self::Number, out: &mut [f32; SIXTEEN]) {
        pack(mask, |l| numbers[l], out);
    }
    #[inline(always)]
    fn pack_lanes(self, mask: u32, first: u32, out: &mut [u32; SIXTEEN]) {
        pack(mask, |l| first + l as u32, out);
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{SIXTEEN, Sixteen, Work16};
    use pulp::x86::{V3, V4};
    use pulp::{NullaryFnOnce, cast};
    use std::arch::x86_64::{__m256, __m512, __m512i};

    /// Work as pulp takes it.
    pub(super) struct Vectorized<S, W> {
        pub(super) lanes: S,
        pub(super) work: W,
    }

    impl<S: Sixteen, W: Work16> NullaryFnOnce for Vectorized<S, W> {
        type Output = W::Output;
        #[inline(always)]
        fn call(self) -> W::Output {
            self.work.work(self.lanes)
        }
    }

    macro_rules! by_instruction {
        ($number:ty: $($name:ident $of:ident)*) => {$(
            #[inline(always)]
            fn $name(self, a: $number, b: $number) -> $number {
                self.avx512f.$of(a, b)
            }
        )*};
    }

    impl Sixteen for V4 {
        type Number = __m512;
        #[inline(always)]
        fn load(self, numbers: &[f32; SIXTEEN]) -> __m512 {
            cast(*numbers)
        }
        #[inline(always)]
        fn store(self, numbers: __m512) -> [f32; SIXTEEN] {
            cast(numbers)
        }
        #[inline(always)]
        fn splat(self, number: f32) -> __m512 {
            self.avx512f._mm512_set1_ps(number)
        }
        by_instruction! { __m512: add _mm512_add_ps sub _mm512_sub_ps mul _mm512_mul_ps }
        #[inline(always)]
        fn at_most(self, a: __m512, b: __m512) -> u32 {
            // 18: less or equal, quiet, false for NaN.
            self.avx512f._mm512_cmp_ps_mask::<18>(a, b).into()
        }
        #[inline(always)]
        fn pack(self, mask: u32, numbers: __m512, out: &mut [f32; SIXTEEN]) {
            *out = cast(self.avx512f._mm512_maskz_compress_ps(mask as u16, numbers));
        }
        #[inline(always)]
        fn pack_lanes(self, mask: u32, first: u32, out: &mut [u32; SIXTEEN]) {
            let lanes: [u32; SIXTEEN] = std::array::from_fn(|l| first.wrapping_add(l as u32));
            let lanes: __m512i = cast(lanes);
            *out = cast(self.avx512f._mm512_maskz_compress_epi32(mask as u16, lanes));
        }
    }

    macro_rules! by_halves {
        ($($name:ident $of:ident)*) => {$(
            #[inline(always)]
            fn $name(self, a: [__m256; 2], b: [__m256; 2]) -> [__m256; 2] {
                [self.avx.$of(a[0], b[0]), self.avx.$of(a[1], b[1])]
            }
        )*};
    }

    impl Sixteen for V3 {
        type Number = [__m256; 2];
        #[inline(always)]
        fn load(self, numbers: &[f32; SIXTEEN]) -> [__m256; 2] {
            cast(*numbers)
        }
        #[inline(always)]
        fn store(self, numbers: [__m256; 2]) -> [f32; SIXTEEN] {
            cast(numbers)
        }
        #[inline(always)]
        fn splat(self, number: f32) -> [__m256; 2] {
            [self.avx._mm256_set1_ps(number); 2]
        }
        by_halves! { add _mm256_add_ps sub _mm256_sub_ps mul _mm256_mul_ps }
        #[inline(always)]
        fn at_most(self, a: [__m256; 2], b: [__m256; 2]) -> u32 {
            let half = |n: usize| self.avx._mm256_movemask_ps(self.avx._mm256_cmp_ps::<18>(a[n], b[n])) as u32;
            half(0) | half(1) << 8
        }
        #[inline(always)]
        fn pack(self, mask: u32, numbers: [__m256; 2], out: &mut [f32; SIXTEEN]) {
            let (first, second) = (cast(PACKED[mask as usize & 255]), cast(PACKED[mask as usize >> 8]));
            let first = self.avx2._mm256_permutevar8x32_ps(numbers[0], first);
            join(mask, cast(first), cast(self.avx2._mm256_permutevar8x32_ps(numbers[1], second)), out);
        }
        #[inline(always)]
        fn pack_lanes(self, mask: u32, first: u32, out: &mut [u32; SIXTEEN]) {
            let (mut low, mut high) = (PACKED[mask as usize & 255], PACKED[mask as usize >> 8]);
            low.iter_mut().for_each(|lane| *lane += first);
            high.iter_mut().for_each(|lane| *lane += first + 8);
            join(mask, low, high, out);
        }
    }

    /// Writes two packed halves one after the other.
    #[inline(always)]
    fn join<T: Copy>(mask: u32, first: [T; 8], second: [T; 8], out: &mut [T; SIXTEEN]) {
        let count = (mask & 255).count_ones() as usize;
        out[..8].copy_from_slice(&first);
        out[count..count + 8].copy_from_slice(&second);
    }

    /// For each mask of eight lanes those with a bit, one after the other.
    static PACKED: [[u32; 8]; 256] = {
        let (mut all, mut mask) = ([[0; 8]; 256], 0);
        while mask < 256 {
            let (mut lane, mut count) = (0, 0);
            while lane < 8 {
                if mask >> lane & 1 == 1 {
                    all[mask][count] = lane as u32;
                    count += 1;
                }
                lane += 1;
            }
            mask += 1;
        }
        all
    };
}
