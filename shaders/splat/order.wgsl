// Depths as integers in the reverse order, above 0.
fn inverted(x: f32) -> u32 {
    let bits = bitcast<u32>(x);
    return ~select(bits | 0x80000000u, ~bits, (bits >> 31u) == 1u);
}

// Its inverse; BEYOND for 0.
fn depth_of(key: u32) -> f32 {
    let bits = ~key;
    return select(bitcast<f32>(select(~bits, bits & 0x7fffffffu, (bits >> 31u) == 1u)), BEYOND, key == 0u);
}
