// Numbers as sums of two f32, about 48 bits. Every operation ends with the barrier, because WGSL lets a compiler
// reassociate and fuse; products are split, because WGSL's fma need not be fused.
//
// Sources: Knuth (TwoSum), Dekker 1971 (FastTwoSum, split and product); Joldes, Muller, Popescu, ACM TOMS 44 (2017),
// algorithms 6 (add), 7 and 10 (mul), 17 (div); Lefevre, Louvet, Muller, Picot, Rideau 2023 (square root).
struct Number {
    hi: f32,
    lo: f32,
}

struct Number3 {
    x: Number,
    y: Number,
    z: Number,
}

const SPLIT: f32 = 4097.0; // 2^12 + 1

// The only barrier that held on every tested adapter: the bits XOR a zero that is unknown at compile time. A
// multiplication by one or an identity bitcast is folded away. The self-test checks it on the adapter
// (src/gpu/selftest.rs).
fn fp_barrier(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) ^ view.zero);
}

fn plus(a: f32, b: f32) -> f32 {
    return fp_barrier(a + b);
}

fn minus(a: f32, b: f32) -> f32 {
    return fp_barrier(a - b);
}

fn product(a: f32, b: f32) -> f32 {
    return fp_barrier(a * b);
}

// a + b exactly.
fn two_sum(a: f32, b: f32) -> Number {
    let hi = plus(a, b);
    let bb = minus(hi, a);
    return Number(hi, plus(minus(a, minus(hi, bb)), minus(b, bb)));
}

// a + b exactly, where |a| >= |b|.
fn fast_two_sum(a: f32, b: f32) -> Number {
    let hi = plus(a, b);
    return Number(hi, minus(b, minus(hi, a)));
}

// a as the sum of two numbers of 12 bits.
fn split(a: f32) -> Number {
    let c = product(SPLIT, a);
    let hi = minus(c, minus(c, a));
    return Number(hi, minus(a, hi));
}

// a b exactly.
fn two_product(a: f32, b: f32) -> Number {
    let p = product(a, b);
    let x = split(a);
    let y = split(b);
    let most = minus(product(x.hi, y.hi), p);
    let more = plus(plus(most, product(x.hi, y.lo)), product(x.lo, y.hi));
    return Number(p, plus(more, product(x.lo, y.lo)));
}

fn from_f32(x: f32) -> Number {
    return Number(x, 0.0);
}

fn from_hi_lo(hi: f32, lo: f32) -> Number {
    return Number(hi, lo);
}

fn to_hi(a: Number) -> f32 {
    return a.hi;
}

fn to_lo(a: Number) -> f32 {
    return a.lo;
}

fn less(a: Number, b: Number) -> bool {
    return a.hi < b.hi || (a.hi == b.hi && a.lo < b.lo);
}

fn negate(a: Number) -> Number {
    return Number(-a.hi, -a.lo);
}

// a times a power of two.
fn scaled(a: Number, power: f32) -> Number {
    return Number(a.hi * power, a.lo * power);
}

fn add(a: Number, b: Number) -> Number {
    let s = two_sum(a.hi, b.hi);
    let t = two_sum(a.lo, b.lo);
    let v = fast_two_sum(s.hi, plus(s.lo, t.hi));
    return fast_two_sum(v.hi, plus(v.lo, t.lo));
}

fn sub(a: Number, b: Number) -> Number {
    return add(a, negate(b));
}

fn mul(a: Number, b: Number) -> Number {
    let p = two_product(a.hi, b.hi);
    let cross = plus(product(a.hi, b.lo), product(a.lo, b.hi));
    return fast_two_sum(p.hi, plus(p.lo, cross));
}

fn div(a: Number, b: Number) -> Number {
    let first = fp_barrier(a.hi / b.hi);
    let p = two_product(b.hi, first);
    let v = fast_two_sum(p.hi, product(b.lo, first));
    let back = fast_two_sum(v.hi, plus(v.lo, p.lo));
    let rest = plus(minus(a.hi, back.hi), minus(a.lo, back.lo));
    return fast_two_sum(first, fp_barrier(rest / b.hi));
}

fn root(a: Number) -> Number {
    if (a.hi <= 0.0) {
        return Number(0.0, 0.0);
    }
    let first = fp_barrier(sqrt(a.hi));
    let p = two_product(first, first);
    let rest = plus(a.lo, minus(minus(a.hi, p.hi), p.lo));
    return fast_two_sum(first, fp_barrier(rest / (2.0 * first)));
}

// a minus b times a power of two, each as high and low part.
fn difference(a: f32, a_lo: f32, b: f32, b_lo: f32, power: f32) -> Number {
    return sub(from_hi_lo(a, a_lo), scaled(from_hi_lo(b, b_lo), power));
}
