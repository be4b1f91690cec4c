// A viewing ray: origin 0, direction d of any length. Only t > 0 counts: a ray is half a line.
struct Ray {
    d: vec3<f32>,
}

// The closest hit: t in the frame's unit, and which sphere.
struct Hit {
    t: f32,
    id: u32,
}

const MISS: f32 = 3.40282347e+38; // t of a ray that hits nothing: the largest f32, since infinity may be assumed away
const NONE: u32 = 0xffffffffu;    // id of a ray that hits nothing

// The viewing ray of the pixel in row i and column j, both from 0:
// u = ((j + 1/2)/W - 1/2) vw = (2j + 1 - W) vw/(2W), and v likewise. The odd integer is exact, so nothing cancels near
// the middle of the image.
fn viewing_ray(i: u32, j: u32) -> Ray {
    let u = f32(2 * i32(j) + 1 - i32(view.width)) * view.half_du;
    let v = f32(i32(view.height) - 1 - 2 * i32(i)) * view.half_dv;
    return Ray(vec3<f32>(u, v, -view.d));
}

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
