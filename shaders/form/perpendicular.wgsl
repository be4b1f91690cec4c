// The perpendicular form of stable.wgsl, operation for operation, in a Number of more bits than f32.
fn is_positive(a: Number) -> bool {
    return less(from_f32(0.0), a);
}

fn is_negative(a: Number) -> bool {
    return less(a, from_f32(0.0));
}

fn discriminant(ray: Ray, s: Sphere, g: Number3) -> Number {
    return sub(mul(number_dot3(ray.d, ray.d), mul(s.radius, s.radius)), number_dot3(g, g));
}

fn intersect(ray: Ray, s: Sphere) -> Number {
    let g = number_cross3(s.center, ray.d);
    let disc = discriminant(ray, s, g);
    if (is_negative(disc)) {
        return from_f32(MISS);
    }
    let b = number_dot3(s.center, ray.d);
    let half = root(disc);
    if (is_positive(b)) {
        let q = add(b, half);
        if (is_positive(s.power)) {
            return div(s.power, q);
        }
        return div(q, number_dot3(ray.d, ray.d));
    }
    if (is_negative(s.power)) {
        return div(s.power, sub(b, half));
    }
    return from_f32(MISS);
}

// As in stable.wgsl; rounded at the end.
fn normal_at(ray: Ray, s: Sphere, t: Number) -> vec3<f32> {
    let d = ray.d;
    let g = number_cross3(s.center, d);
    let disc = discriminant(ray, s, g);
    var half = from_f32(0.0);
    if (is_positive(disc)) {
        half = root(disc);
    }
    var n = number_cross3(d, g);
    if (is_positive(s.power)) {
        n = negate3(n);
    }
    n = Number3(sub(n.x, mul(half, d.x)), sub(n.y, mul(half, d.y)), sub(n.z, mul(half, d.z)));
    let length = root(number_dot3(n, n));
    return rounded(Number3(div(n.x, length), div(n.y, length), div(n.z, length)));
}
