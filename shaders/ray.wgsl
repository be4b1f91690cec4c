// A viewing ray: origin 0, direction d of any length. Only t > 0 counts: a ray is half a line.
struct Ray {
    d: vec3<f32>,
}

// The closest hit: t in the frame's unit, and which sphere.
struct Hit {
    t: f32,
    id: u32,
}

// Whether a hit takes the place of another where spheres come in an order of their own: it is closer, or as close and of
// the lower id.
fn is_before(a: Hit, b: Hit) -> bool {
    return a.t < MISS && (a.t < b.t || (a.t == b.t && a.id < b.id));
}

// A given ray. What rounding took from its direction is for better arithmetic than this.
fn ray_along(d: vec3<f32>, low: vec3<f32>) -> Ray {
    return Ray(d);
}

// The viewing ray of the pixel in row i and column j, both from 0:
// u = ((j + 1/2)/W - 1/2) vw = (2j + 1 - W) vw/(2W), and v likewise. The odd integer is exact, so nothing cancels near
// the middle of the image.
fn viewing_ray(i: u32, j: u32) -> Ray {
    let u = f32(2 * i32(j) + 1 - i32(view.width)) * view.half_du;
    let v = f32(i32(view.height) - 1 - 2 * i32(i)) * view.half_dv;
    return Ray(vec3<f32>(u, v, -view.d));
}
