// Rays, spheres and hits in the Number of the kernel: f32, f64 or a sum of two f32.

// A viewing ray: origin 0, direction d of any length. Only t > 0 is a hit: a ray is half a line.
struct Ray {
    d: Number3,
}

// A sphere seen from the ray's origin, in the unit of its own record.
struct Sphere {
    center: Number3,
    radius: Number,
    power: Number, // of the origin: |c|^2 - r^2
    scale: f32,    // t in this unit times scale is t in the frame's unit
}

// The closest hit: t in the frame's unit, not rounded to f32 before hits are ordered, and the sphere's id.
struct Hit {
    t: Number,
    id: u32,
}

fn rounded(a: Number3) -> vec3<f32> {
    return vec3<f32>(to_hi(a.x), to_hi(a.y), to_hi(a.z));
}

fn negate3(a: Number3) -> Number3 {
    return Number3(negate(a.x), negate(a.y), negate(a.z));
}

fn number_dot3(a: Number3, b: Number3) -> Number {
    return add(add(mul(a.x, b.x), mul(a.y, b.y)), mul(a.z, b.z));
}

fn minor(a: Number, b: Number, c: Number, d: Number) -> Number {
    return sub(mul(a, b), mul(c, d));
}

fn number_cross3(a: Number3, b: Number3) -> Number3 {
    return Number3(minor(a.y, b.z, a.z, b.y), minor(a.z, b.x, a.x, b.z), minor(a.x, b.y, a.y, b.x));
}

// The viewing ray of the pixel in row i and column j, both from 0:
// u = ((j + 1/2)/W - 1/2) vw = (2j + 1 - W) vw/(2W), and v likewise. The odd integer is exact, so nothing cancels near
// the middle of the image.
fn viewing_ray(i: u32, j: u32) -> Ray {
    let u = mul(from_f32(f32(2 * i32(j) + 1 - i32(view.width))), from_hi_lo(view.half_du, view.half_du_low));
    let v = mul(from_f32(f32(i32(view.height) - 1 - 2 * i32(i))), from_hi_lo(view.half_dv, view.half_dv_low));
    return Ray(Number3(u, v, negate(from_hi_lo(view.d, view.d_low))));
}
