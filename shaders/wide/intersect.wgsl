// The perpendicular form of stable.wgsl, operation for operation, in the variant's Number. One text for all of them, so
// that no copy can drift.
struct WideSphere {
    center: Number3,
    radius: Number,
    power: Number,
}

fn is_positive(a: Number) -> bool {
    return less(number(0.0), a);
}

fn is_negative(a: Number) -> bool {
    return less(a, number(0.0));
}

fn discriminant(ray: Ray, s: WideSphere, g: Number3) -> Number {
    return sub(mul(dot_wide(ray.wide, ray.wide), mul(s.radius, s.radius)), dot_wide(g, g));
}

fn intersect(ray: Ray, s: WideSphere) -> Number {
    let g = cross_wide(s.center, ray.wide);
    let disc = discriminant(ray, s, g);
    if (is_negative(disc)) {
        return number(MISS);
    }
    let b = dot_wide(s.center, ray.wide);
    let half = root(disc);
    if (is_positive(b)) {
        let q = add(b, half);
        if (is_positive(s.power)) {
            return div(s.power, q);
        }
        return div(q, dot_wide(ray.wide, ray.wide));
    }
    if (is_negative(s.power)) {
        return div(s.power, sub(b, half));
    }
    return number(MISS);
}

// As in stable.wgsl; rounded at the very end.
fn normal_at(ray: Ray, s: WideSphere) -> vec3<f32> {
    let d = ray.wide;
    let g = cross_wide(s.center, d);
    let disc = discriminant(ray, s, g);
    var half = number(0.0);
    if (is_positive(disc)) {
        half = root(disc);
    }
    var n = cross_wide(d, g);
    if (is_positive(s.power)) {
        n = Number3(negate(n.x), negate(n.y), negate(n.z));
    }
    n = Number3(sub(n.x, mul(half, d.x)), sub(n.y, mul(half, d.y)), sub(n.z, mul(half, d.z)));
    let length = root(dot_wide(n, n));
    return rounded(Number3(div(n.x, length), div(n.y, length), div(n.z, length)));
}
