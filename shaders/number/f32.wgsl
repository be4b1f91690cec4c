// Plain f32. The low parts of the inputs are used only where two positions are subtracted.
alias Number = f32;
alias Number3 = vec3<f32>;

fn from_f32(x: f32) -> Number {
    return x;
}

fn from_hi_lo(hi: f32, lo: f32) -> Number {
    return hi;
}

fn to_hi(a: Number) -> f32 {
    return a;
}

fn less(a: Number, b: Number) -> bool {
    return a < b;
}

fn negate(a: Number) -> Number {
    return -a;
}

// a times a power of two.
fn scaled(a: Number, power: f32) -> Number {
    return a * power;
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

// a minus b times a power of two, each as high and low part. The high parts are subtracted first and the low parts added
// to the difference, so that the distance of two far points near each other stays accurate.
fn difference(a: f32, a_lo: f32, b: f32, b_lo: f32, power: f32) -> Number {
    return (a - power * b) + (a_lo - power * b_lo);
}
