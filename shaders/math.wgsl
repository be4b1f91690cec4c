// Constants of a miss, and vectors of f32.

const MISS: f32 = 0x1.fffffep+127; // t of a miss: the largest f32, because WGSL has no reliable infinity
const NONE: u32 = 0xffffffffu;     // id of a ray that hits nothing
const UNSURE: u32 = 0xfffffffeu;   // id where f32 cannot prove the answer; the host settles the pixel

// x if it is positive, else +0; the sign of a zero from max is not defined.
fn positive(x: f32) -> f32 {
    return select(0.0, x, x > 0.0);
}

// Written out, because the order of the sum decides the last bit.
fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn cross3(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

fn unit3(a: vec3<f32>) -> vec3<f32> {
    let length = sqrt(dot3(a, a));
    return vec3<f32>(a.x / length, a.y / length, a.z / length);
}
