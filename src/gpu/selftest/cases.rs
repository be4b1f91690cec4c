//! The cases of the self-test: random ones with fixed seeds, then directed ones.

/// Random cases of a trial.
pub(super) const COUNT: usize = 1 << 16;

/// Cases for which the sign of the discriminant is checked.
const SOLVES: usize = 1 << 10;

/// xorshift64* (Vigna 2016).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// An integer in least..=most.
    fn within(&mut self, least: i32, most: i32) -> i32 {
        least + ((self.bits() >> 33) % (most - least + 1) as u64) as i32
    }

    /// A float with random sign and significand, and this exponent.
    fn float(&mut self, exponent: i32) -> f32 {
        let bits = (self.bits() >> 32) as u32;
        f32::from_bits((bits & 0x807f_ffff) | (((exponent + 127) as u32) << 23))
    }

    fn double(&mut self, exponent: i32) -> f64 {
        f64::from_bits((self.bits() & 0x800f_ffff_ffff_ffff) | (((exponent + 1023) as u64) << 52))
    }
}

fn words(numbers: impl IntoIterator<Item = f32>) -> Vec<u32> {
    numbers.into_iter().map(f32::to_bits).collect()
}

/// a and b with exponent gaps from 0 to 30, either the larger, and with a = -b(1 + 2^-23); RN(a b); x, y, z for (x - y)
/// z with x and y near 10^6 and near each other. All products and their errors stay above 2^-120.
pub(super) fn transforms() -> Vec<u32> {
    let mut random = Random(0x5eed_0001);
    words((0..COUNT).flat_map(|n| {
        let exponent = random.within(-20, 20);
        let a = random.float(exponent);
        let b = match n % 8 {
            0 => -a * (1.0 + f32::EPSILON),
            _ => random.float(exponent - (n % 31) as i32),
        };
        let (a, b) = if random.bits() >> 63 == 0 { (a, b) } else { (b, a) };
        let y = 1e6 * random.float(0).abs();
        let x = f32::from_bits(y.to_bits() + random.within(1, 1 << 10) as u32);
        [a, b, a * b, x, y, random.float(0)]
    }))
}

/// Sums that reveal the rounding direction, with the results to nearest even and toward zero; then the same negated.
pub(super) const ROUNDING: [[f32; 4]; 4] = {
    let half = f32::EPSILON / 2.0;
    [
        [1.0, half, 1.0, 1.0],
        [1.0, 3.0 * half, 1.0 + 2.0 * f32::EPSILON, 1.0 + f32::EPSILON],
        [1.0, 1.5 * half, 1.0 + f32::EPSILON, 1.0],
        [16_777_216.0, 1.0, 16_777_216.0, 16_777_216.0],
    ]
};

/// 2^k, for every power of two in f32, subnormal numbers included.
pub(super) const fn two_to(k: i32) -> f32 {
    if k >= -126 { f32::from_bits(((k + 127) as u32) << 23) } else { f32::from_bits(1 << (k + 149)) }
}

/// Pairs with subnormals, the word of the answer (0 sum, 1 difference, 2 product, 6 store, 7 bitcast) and its expected
/// value.
pub(super) const SUBNORMAL: [(&str, [f32; 2], usize, f32); 6] = [
    ("into sum", [two_to(-127), two_to(-126)], 0, 1.5 * two_to(-126)),
    ("out of difference", [1.5 * two_to(-126), two_to(-126)], 1, two_to(-127)),
    ("into product", [two_to(-130), two_to(20)], 2, two_to(-110)),
    ("out of product", [two_to(-70), two_to(-60)], 2, two_to(-130)),
    ("load and store", [two_to(-135), 1.0], 6, two_to(-135)),
    ("bitcast", [two_to(-140), 1.0], 7, two_to(-140)),
];

/// Pairs that are or give infinities or NaN, and the word of the answer that must show it (8 a, 9 a/b, 10 a b).
pub(super) const SPECIAL: [([f32; 2], usize); 6] = [
    ([f32::NAN, 1.0], 8),
    ([f32::INFINITY, 1.0], 8),
    ([f32::NEG_INFINITY, 1.0], 8),
    ([0.0, 0.0], 9),
    ([f32::INFINITY, f32::INFINITY], 9),
    ([f32::MAX, f32::MAX], 10),
];

/// Pairs in the range of the kernels, 2^-40 to 2^40, then [`ROUNDING`] twice, [`SUBNORMAL`] and [`SPECIAL`].
pub(super) fn operations() -> Vec<u32> {
    let mut random = Random(0x5eed_0002);
    let pairs = (0..COUNT).map(|n| {
        let exponent = random.within(-40, 40);
        let gap = if n % 2 == 0 { (n % 31) as i32 } else { random.within(-40, 40) };
        [random.float(exponent), random.float((exponent - gap).clamp(-40, 40))]
    });
    let rounding = ROUNDING.iter().map(|[a, b, ..]| [*a, *b]);
    let negated = ROUNDING.iter().map(|[a, b, ..]| [-a, -b]);
    let subnormal = SUBNORMAL.iter().map(|(_, pair, ..)| *pair);
    let special = SPECIAL.iter().map(|(pair, _)| *pair);
    words(pairs.chain(rounding).chain(negated).chain(subnormal).chain(special).flatten())
}

/// Double-floats a, b, c; every fourth c nearly cancels a b.
pub(super) fn pairs() -> Vec<u32> {
    let mut random = Random(0x5eed_0003);
    let mut pair = || {
        let e = random.within(-10, 10);
        let hi = random.float(e);
        // lo is below half an ulp of hi, 2^(e - 24), so that hi is the rounded sum.
        let gap = random.within(25, 31);
        [hi, random.float(e - gap)]
    };
    words((0..COUNT / 4).flat_map(|n| {
        let (a, b) = (pair(), pair());
        let c = match n % 4 {
            0 => [-(a[0] * b[0]), a[0] * b[0] * pair()[1]],
            _ => pair(),
        };
        let sum = crate::double_double::Dd::sum(f64::from(c[0]), f64::from(c[1])).value();
        let c = [sum as f32, (sum - f64::from(sum as f32)) as f32];
        [a, b, c].concat()
    }))
}

/// p, d, r of integers with r^2 as close to |p x d|^2/|d|^2 as integers allow: about one ulp of f32.
pub(super) fn solve() -> Vec<u32> {
    let mut random = Random(0x5eed_0004);
    words((0..SOLVES).flat_map(|_| {
        let p: [i64; 3] = std::array::from_fn(|_| i64::from(random.within(-(1 << 23), 1 << 23)));
        let d: [i64; 3] = std::array::from_fn(|_| i64::from(random.within(-(1 << 10), 1 << 10)));
        let (aa, gg) = quadratic(p, d);
        let r = (gg as f64 / aa.max(1) as f64).sqrt().round();
        // The sphere is in front of the ray's origin.
        let d = if ahead(p, d) < 0 { d.map(|x| -x) } else { d };
        let c = (power(p, r as i64)) as f64;
        let [high, low] = [c as f32, (c - f64::from(c as f32)) as f32];
        p.iter().chain(&d).map(|x| *x as f32).chain([r as f32, high, low]).collect::<Vec<_>>()
    }))
}

/// |d|^2 and |p x d|^2.
pub(super) fn quadratic(p: [i64; 3], d: [i64; 3]) -> (i128, i128) {
    let minor = |i: usize, j: usize| i128::from(p[i]) * i128::from(d[j]) - i128::from(p[j]) * i128::from(d[i]);
    let g = [minor(1, 2), minor(2, 0), minor(0, 1)];
    (d.iter().map(|x| i128::from(*x).pow(2)).sum(), g.iter().map(|x| x.pow(2)).sum())
}

/// p.d
pub(super) fn ahead(p: [i64; 3], d: [i64; 3]) -> i128 {
    (0..3).map(|k| i128::from(p[k]) * i128::from(d[k])).sum()
}

/// |p|^2 - r^2, below 2^48 and so exact in f64 and in two f32.
pub(super) fn power(p: [i64; 3], r: i64) -> i128 {
    p.iter().map(|x| i128::from(*x).pow(2)).sum::<i128>() - i128::from(r).pow(2)
}

/// Pairs of f64.
pub(super) fn wide() -> Vec<u32> {
    let mut random = Random(0x5eed_0005);
    let numbers = (0..COUNT).flat_map(|n| {
        let exponent = random.within(-100, 100);
        let gap = if n % 2 == 0 { (n % 60) as i32 } else { random.within(-100, 100) };
        [random.double(exponent), random.double(exponent - gap)]
    });
    bytemuck::pod_collect_to_vec(&numbers.collect::<Vec<f64>>())
}
