// f64, where shaders have it: no barrier, no transforms. WGSL itself has no f64; naga spells its literals 1.0lf.
alias Number = f64;

fn number(x: f32) -> Number {
    return f64(x);
}

fn pair(hi: f32, lo: f32) -> Number {
    return f64(hi) + f64(lo);
}

fn high(a: Number) -> f32 {
    return f32(a);
}

fn low(a: Number) -> f32 {
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
