// The quadratic for d of unit length: t = -d.p +- sqrt((d.p)^2 - p.p + r^2); t/|d| is the parameter of the given ray.
fn intersect(ray: Ray, s: Sphere) -> f32 {
    let p = -s.center;
    let length = sqrt(dot3(ray.d, ray.d));
    let d = vec3<f32>(ray.d.x / length, ray.d.y / length, ray.d.z / length);
    let b = dot3(d, p);
    let discriminant = b * b - dot3(p, p) + s.radius * s.radius;
    if (discriminant < 0.0) {
        return MISS;
    }
    let root = sqrt(discriminant);
    return closest((-b - root) / length, (-b + root) / length);
}

fn normal_at(ray: Ray, s: Sphere, t: f32) -> vec3<f32> {
    return normal_from_point(ray, s, t / s.scale);
}
