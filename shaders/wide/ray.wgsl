// ray.wgsl in a better arithmetic: Number, add, mul and the like are the variant's.
struct Number3 {
    x: Number,
    y: Number,
    z: Number,
}

// d rounded, for shading, and as it is.
struct Ray {
    d: vec3<f32>,
    wide: Number3,
}

// The closest hit: t in the frame's unit, never squeezed through one f32 before hits are ordered.
struct Hit {
    t: Number,
    id: u32,
}

// As in ray.wgsl.
fn is_before(a: Hit, b: Hit) -> bool {
    return less(a.t, number(MISS)) && (less(a.t, b.t) || (!less(b.t, a.t) && a.id < b.id));
}

fn ray_of(d: Number3) -> Ray {
    return Ray(rounded(d), d);
}

fn ray_along(d: vec3<f32>, low: vec3<f32>) -> Ray {
    return ray_of(Number3(pair(d.x, low.x), pair(d.y, low.y), pair(d.z, low.z)));
}

fn viewing_ray(i: u32, j: u32) -> Ray {
    let u = mul(number(f32(2 * i32(j) + 1 - i32(view.width))), pair(view.half_du, view.half_du_low));
    let v = mul(number(f32(i32(view.height) - 1 - 2 * i32(i))), pair(view.half_dv, view.half_dv_low));
    return ray_of(Number3(u, v, negate(pair(view.d, view.d_low))));
}

fn rounded(a: Number3) -> vec3<f32> {
    return vec3<f32>(high(a.x), high(a.y), high(a.z));
}

fn dot_wide(a: Number3, b: Number3) -> Number {
    return add(add(mul(a.x, b.x), mul(a.y, b.y)), mul(a.z, b.z));
}

fn minor(a: Number, b: Number, c: Number, d: Number) -> Number {
    return sub(mul(a, b), mul(c, d));
}

fn cross_wide(a: Number3, b: Number3) -> Number3 {
    return Number3(minor(a.y, b.z, a.z, b.y), minor(a.z, b.x, a.x, b.z), minor(a.x, b.y, a.y, b.x));
}
