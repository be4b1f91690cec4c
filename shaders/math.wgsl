// The miss, and vectors of f32.

const MISS: f32 = 3.40282347e+38; // t of a ray that hits nothing: the largest f32, since infinity may be assumed away
const NONE: u32 = 0xffffffffu;    // id of a ray that hits nothing

// x where it is positive, else 0; unlike max it says which zero.
fn positive(x: f32) -> f32 {
    return select(0.0, x, x > 0.0);
}

// Spelled out: the order of the sum is part of the answer's last bit.
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
