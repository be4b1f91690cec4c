//! Interleaves arrays of components into triples, lane after lane, as buffers of normals and colours hold them.

/// Interleaves components.
pub(in crate::cpu) trait Triples: Copy + Send + Sync {
    /// The components of every lane.
    fn of<const N: usize>(self, components: &[[f32; N]; 3]) -> [[f32; 3]; N];
}

/// For every processor.
#[derive(Debug, Clone, Copy)]
pub(in crate::cpu) struct Portable;

impl Triples for Portable {
    #[inline(always)]
    fn of<const N: usize>(self, components: &[[f32; N]; 3]) -> [[f32; 3]; N] {
        let mut all = [[0.0; 3]; N];
        for l in 0..N {
            for k in 0..3 {
                all[l][k] = components[k][l];
            }
        }
        all
    }
}

/// Of the loop above compilers make a shuffle for every number, where vectors of 512 bits need six in all.
#[cfg(target_arch = "x86_64")]
impl Triples for pulp::x86::V4 {
    #[inline(always)]
    fn of<const N: usize>(self, components: &[[f32; N]; 3]) -> [[f32; 3]; N] {
        let mut all = [[0.0; 3]; N];
        let vectors = components.each_ref().map(|x| x.as_chunks().0);
        for ((out, x), (y, z)) in
            all.as_chunks_mut::<16>().0.iter_mut().zip(vectors[0]).zip(vectors[1].iter().zip(vectors[2]))
        {
            let [x, y, z] = [*x, *y, *z].map(pulp::cast::<[f32; 16], std::arch::x86_64::__m512>);
            let part = |n: usize| {
                let two = self.avx512f._mm512_permutex2var_ps(x, pulp::cast(INDICES[n][0]), y);
                self.avx512f._mm512_permutex2var_ps(two, pulp::cast(INDICES[n][1]), z)
            };
            *out = pulp::cast([part(0), part(1), part(2)]);
        }
        all
    }
}

/// For each of three vectors of results: where its first two components lie in x and y, and then all in these and z.
#[cfg(target_arch = "x86_64")]
const INDICES: [[[u32; 16]; 2]; 3] = {
    let mut indices = [[[0; 16]; 2]; 3];
    let mut n = 0;
    while n < 48 {
        let (lane, component, place) = (n / 3, n % 3, n % 16);
        indices[(n / 16) as usize][0][place as usize] = if component == 1 { 16 + lane } else { lane };
        indices[(n / 16) as usize][1][place as usize] = if component == 2 { 16 + lane } else { place };
        n += 1;
    }
    indices
};
