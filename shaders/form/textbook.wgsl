// The general quadratic: |p + t d|^2 = r^2 with p from the centre to the ray's origin and d of any length.
fn intersect(ray: Ray, s: Sphere) -> f32 {
    let p = -s.center;
    let a = dot3(ray.d, ray.d);
    let b = dot3(ray.d, p);
    let c = dot3(p, p) - s.radius * s.radius;
    let discriminant = b * b - a * c;
    if (discriminant < 0.0) {
        return MISS;
    }
    let root = sqrt(discriminant);
    return closest((-b - root) / a, (-b + root) / a);
}

fn normal_at(ray: Ray, s: Sphere, t: f32) -> vec3<f32> {
    return normal_from_point(ray, s, t / s.scale);
}
