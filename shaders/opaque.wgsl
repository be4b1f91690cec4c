// The only barrier that was seen to hold everywhere: the bits XOR a zero that no compiler knows. A multiplication by one
// or an identity bitcast is folded away. Whether it holds on this adapter is measured (src/gpu/selftest.rs).
fn opaque(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) ^ view.zero);
}
