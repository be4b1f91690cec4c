// The perpendicular form. With p from the ray's origin to the centre, g = p x d and Lagrange's identity
// (p.d)^2 = |p|^2 |d|^2 - |g|^2 the discriminant is a r^2 - g.g, which is no difference of two large squares. The host
// computes the power of the origin, c = |p|^2 - r^2. The root whose sum does not cancel is computed first, the other
// is c/q.
fn discriminant(ray: Ray, s: Sphere, g: vec3<f32>) -> f32 {
    return dot3(ray.d, ray.d) * (s.radius * s.radius) - dot3(g, g);
}

fn intersect(ray: Ray, s: Sphere) -> f32 {
    let p = s.center;
    let g = cross3(p, ray.d);
    let disc = discriminant(ray, s, g);
    if (disc < 0.0) {
        return MISS;
    }
    let b = dot3(p, ray.d);
    let root = sqrt(disc);
    if (b > 0.0) {
        let q = b + root;
        if (s.power > 0.0) {
            return s.power / q;
        }
        return q / dot3(ray.d, ray.d);
    }
    if (s.power < 0.0) {
        return s.power / (b - root);
    }
    return MISS;
}

// The unit normal, facing the ray's origin, from the perpendicular and half the chord:
// |d|^2 (t d - p) = -(d x g) -+ sqrt(D) d, upper sign outside. Nothing cancels at any distance; t is not used.
fn normal_at(ray: Ray, s: Sphere, t: f32) -> vec3<f32> {
    let g = cross3(s.center, ray.d);
    let root = sqrt(positive(discriminant(ray, s, g)));
    let across = cross3(ray.d, g);
    return unit3(select(across, -across, s.power > 0.0) - root * ray.d);
}
