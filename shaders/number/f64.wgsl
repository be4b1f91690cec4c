// f64, on adapters that support it: no barrier, no transforms. WGSL has no f64; naga writes its literals as 1.0lf.
alias Number = f64;
alias Number3 = vec3<f64>;

fn from_f32(x: f32) -> Number {
    return f64(x);
}

fn from_hi_lo(hi: f32, lo: f32) -> Number {
    return f64(hi) + f64(lo);
}

fn to_hi(a: Number) -> f32 {
    return f32(a);
}

fn to_lo(a: Number) -> f32 {
    return f32(a - f64(f32(a)));
}

fn less(a: Number, b: Number) -> bool {
    return a < b;
}

fn negate(a: Number) -> Number {
    return -a;
}

// a times a power of two.
fn scaled(a: Number, power: f32) -> Number {
    return a * f64(power);
}

fn add(a: Number, b: Number) -> Number {
    return a + b;
}

fn sub(a: Number, b: Number) -> Number {
    return a - b;
}

fn mul(a: Number, b: Number) -> Number {
    return a * b;
}

fn div(a: Number, b: Number) -> Number {
    return a / b;
}

fn root(a: Number) -> Number {
    return sqrt(a);
}

// a minus b times a power of two, each as high and low part.
fn difference(a: f32, a_lo: f32, b: f32, b_lo: f32, power: f32) -> Number {
    return sub(from_hi_lo(a, a_lo), scaled(from_hi_lo(b, b_lo), power));
}
