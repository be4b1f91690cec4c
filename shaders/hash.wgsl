// Jarzynski and Olano, "Hash Functions for GPU Rendering", Journal of Computer Graphics Techniques 9(3), 2020.
fn pcg4d(seed: vec4<u32>) -> vec4<u32> {
    let v = mix4(seed * 1664525u + vec4<u32>(1013904223u));
    return mix4(v ^ (v >> vec4<u32>(16u)));
}

fn mix4(v: vec4<u32>) -> vec4<u32> {
    let x = v.x + v.y * v.w;
    let y = v.y + v.z * x;
    let z = v.z + x * y;
    let w = v.w + y * z;
    return vec4<u32>(x, y, z, w);
}
