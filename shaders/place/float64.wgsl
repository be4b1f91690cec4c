// Numbers of f64 by integers, rounded as the host rounds them: to nearest, ties to even. Defined operations of u32, which no
// compiler may change, so a sphere's record has the host's bits on every device. Numbers below 2^-1022 count as 0.

// +-m 2^e with the highest bit of m set, its last 11 bits clear; m = 0 for 0.
struct Float {
    m: vec2<u32>, // low, high
    e: i32,
    s: u32,       // 1 if negative
}

const ZERO_EXPONENT: i32 = -100000;

fn float_of_bits(low: u32, high: u32) -> Float {
    let exponent = (high >> 20u) & 0x7ffu;
    let top = (high & 0xfffffu) | 0x100000u;
    if (exponent == 0u) {
        return Float(vec2<u32>(0u, 0u), ZERO_EXPONENT, 0u);
    }
    return Float(vec2<u32>(low << 11u, (top << 11u) | (low >> 21u)), i32(exponent) - 1086, high >> 31u);
}

// The bits of a number within the range of f64.
fn bits_of_float(a: Float) -> vec2<u32> {
    let high = (a.s << 31u) | (bitcast<u32>(a.e + 1086) << 20u) | ((a.m.y >> 11u) & 0xfffffu);
    return select(vec2<u32>((a.m.x >> 11u) | (a.m.y << 21u), high), vec2<u32>(0u, 0u), a.m.y == 0u);
}

fn float_of_words(w: vec4<u32>) -> Float {
    return Float(w.xy, bitcast<i32>(w.z), w.w);
}

fn float_of_int(n: i32) -> Float {
    let size = u32(abs(n));
    let shift = countLeadingZeros(size) & 31u;
    return Float(vec2<u32>(0u, size << shift), select(-32 - i32(shift), ZERO_EXPONENT, n == 0), u32(n < 0));
}

fn minus_of(a: Float) -> Float {
    return Float(a.m, a.e, a.s ^ 1u);
}

// a 2^k.
fn times_power(a: Float, k: i32) -> Float {
    return Float(a.m, a.e + k, a.s);
}

// The 64-bit number v shifted right, its last bit set if any bit was lost.
fn shifted_right(v: vec2<u32>, by: u32) -> vec2<u32> {
    let n = by & 31u;
    let up = (32u - n) & 31u;
    // The bits that the high word loses on the right, as high bits of the low word; 0 for n = 0.
    let carried = select(v.y << up, 0u, n == 0u);
    let lost = select(v.x << up, 0u, n == 0u);
    let near = vec2<u32>((v.x >> n) | carried | u32(lost != 0u), v.y >> n);
    let far = vec2<u32>((v.y >> n) | u32((carried | v.x) != 0u), 0u);
    let all = vec2<u32>(u32((v.x | v.y) != 0u), 0u);
    return select(select(near, far, by >= 32u), all, by >= 64u);
}

fn add64(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2<u32>(low, a.y + b.y + u32(low < a.x));
}

fn sub64(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    return vec2<u32>(a.x - b.x, a.y - b.y - u32(a.x < b.x));
}

fn less64(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

// v shifted left by less than 64.
fn shifted_left(v: vec2<u32>, by: u32) -> vec2<u32> {
    let n = by & 31u;
    let carried = select(v.x >> ((32u - n) & 31u), 0u, n == 0u);
    return select(vec2<u32>(v.x << n, (v.y << n) | carried), vec2<u32>(0u, v.x << n), by >= 32u);
}

// m with its highest bit set, rounded to 53 bits; the last of its 64 stands for all that follow.
fn rounded53(m: vec2<u32>, e: i32, s: u32) -> Float {
    let sum = add64(m, vec2<u32>(0x3ffu + ((m.x >> 11u) & 1u), 0u));
    let over = sum.y < m.y;
    return Float(vec2<u32>(sum.x & 0xfffff800u, select(sum.y, 0x80000000u, over)), e + i32(over), s);
}

// a + b.
fn plus64(a: Float, b: Float) -> Float {
    let swap = a.e < b.e || (a.e == b.e && less64(a.m, b.m));
    let am = select(a.m, b.m, swap);
    let bm = select(b.m, a.m, swap);
    let ae = select(a.e, b.e, swap);
    let be = select(b.e, a.e, swap);
    let s = select(a.s, b.s, swap);
    let apart = u32(min(ae - be, 100));
    let differ = a.s != b.s;
    // One bit of room for a carry; the last 11 bits are clear, so nothing is lost.
    let wide = vec2<u32>((am.x >> 1u) | (am.y << 31u), am.y >> 1u);
    let other = shifted_right(bm, apart + 1u);
    let m = select(add64(wide, other), sub64(wide, other), vec2<bool>(differ));
    let high = m.y != 0u;
    let lead = countLeadingZeros(select(m.x, m.y, high)) + select(32u, 0u, high);
    if ((m.x | m.y) == 0u) {
        return Float(vec2<u32>(0u, 0u), ZERO_EXPONENT, 0u);
    }
    return rounded53(shifted_left(m, lead), ae + 1 - i32(lead), s);
}

fn minus64(a: Float, b: Float) -> Float {
    return plus64(a, minus_of(b));
}

// The 64 bits of a b.
fn product32(a: u32, b: u32) -> vec2<u32> {
    let al = a & 0xffffu;
    let ah = a >> 16u;
    let bl = b & 0xffffu;
    let bh = b >> 16u;
    let low = al * bl;
    let one = al * bh;
    let two = ah * bl;
    let middle = (low >> 16u) + (one & 0xffffu) + (two & 0xffffu);
    return vec2<u32>(a * b, ah * bh + (one >> 16u) + (two >> 16u) + (middle >> 16u));
}

// m shifted right by the 11 bits that are clear.
fn significand(m: vec2<u32>) -> vec2<u32> {
    return vec2<u32>((m.x >> 11u) | (m.y << 21u), m.y >> 11u);
}

// a b.
fn times64(a: Float, b: Float) -> Float {
    let x = significand(a.m);
    let y = significand(b.m);
    let low = product32(x.x, y.x);
    let one = product32(x.x, y.y);
    let two = product32(x.y, y.x);
    let high = product32(x.y, y.y);
    // The product has 106 bits at most, in four words.
    let first = low.y + one.x;
    let second = first + two.x;
    let carry = u32(first < low.y) + u32(second < first);
    let upper = add64(add64(high, vec2<u32>(one.y, 0u)), add64(vec2<u32>(two.y, 0u), vec2<u32>(carry, 0u)));
    let rest = u32(((second << 22u) | low.x) != 0u);
    let m = vec2<u32>((upper.x << 22u) | (second >> 10u) | rest, (upper.y << 22u) | (upper.x >> 10u));
    let short = (m.y >> 31u) == 0u;
    let full = select(m, vec2<u32>(m.x << 1u, (m.y << 1u) | (m.x >> 31u)), short);
    if ((a.m.y == 0u) || (b.m.y == 0u)) {
        return Float(vec2<u32>(0u, 0u), ZERO_EXPONENT, 0u);
    }
    return rounded53(full, a.e + b.e + 64 - i32(short), a.s ^ b.s);
}

// v as f32, within a few units of the last place.
fn estimate64(v: vec2<u32>) -> f32 {
    return f32(v.y) * 4294967296.0 + f32(v.x);
}

// 1 / b. Five digits of 11 bits of 2^52 / m: each is estimated in f32 and corrected by its exact remainder.
fn inverse64(b: Float) -> Float {
    let divisor = significand(b.m);
    let per = 1.0 / estimate64(divisor);
    var rest = vec2<u32>(0u, 0x100000u);
    var quotient = vec2<u32>(0u, 0u);
    for (var k = 0u; k < 5u; k++) {
        rest = shifted_left(rest, 11u);
        var digit = u32(estimate64(rest) * per);
        let part = product32(digit, divisor.x);
        rest = sub64(rest, vec2<u32>(part.x, part.y + digit * divisor.y));
        if ((rest.y >> 31u) == 1u) {
            rest = add64(rest, divisor);
            digit -= 1u;
        }
        let over = sub64(rest, divisor);
        if ((over.y >> 31u) == 0u) {
            rest = over;
            digit += 1u;
        }
        quotient = add64(shifted_left(quotient, 11u), vec2<u32>(digit, 0u));
    }
    // Between 2^54 and 2^55.
    let shift = countLeadingZeros(quotient.y);
    let m = shifted_left(quotient, shift);
    return rounded53(vec2<u32>(m.x | u32((rest.x | rest.y) != 0u), m.y), -118 - b.e - i32(shift), b.s);
}

// a rounded to f32; 0 below the normal numbers.
fn f32_of_float(a: Float) -> f32 {
    let exponent = a.e + 190;
    let rest = (a.m.y & 0xffu) | u32(a.m.x != 0u);
    let significand = a.m.y >> 8u;
    let beyond = a.m.y & 0xffu;
    let up = beyond > 0x80u || (beyond == 0x80u && (a.m.x != 0u || (significand & 1u) == 1u));
    // The leading bit adds one to the exponent, and so does a carry.
    let bits = (u32(max(exponent, 1) - 1) << 23u) + significand + u32(up && rest != 0u);
    let finite = select(bits, 0x7f000000u, exponent > 253);
    return bitcast<f32>(select(finite, 0u, exponent < 1 || a.m.y == 0u) | (a.s << 31u));
}

// a 2^k rounded to an integer, ties to even, where its size is below 2^31.
fn integer_of_float(a: Float, k: i32) -> i32 {
    // Two more bits: the half, and whether anything follows.
    let kept = shifted_right(a.m, u32(clamp(-(a.e + k) - 2, 0, 64)));
    let whole = (kept.x >> 2u) | (kept.y << 30u);
    let rest = kept.x & 3u;
    let up = rest == 3u || (rest == 2u && (whole & 1u) == 1u);
    let size = bitcast<i32>(whole + u32(up));
    return select(size, -size, a.s == 1u);
}
