// The geometric form: t_m is the ray's closest approach to the centre, l_m its distance there, delta t half the chord.
// d has unit length; t/|d| is the parameter of the given ray.
fn intersect(ray: Ray, s: Sphere) -> f32 {
    let p = -s.center;
    let length = sqrt(dot3(ray.d, ray.d));
    let d = vec3<f32>(ray.d.x / length, ray.d.y / length, ray.d.z / length);
    let t_m = -dot3(p, d);
    let l_m2 = dot3(p, p) - t_m * t_m;
    let r2 = s.radius * s.radius;
    if (l_m2 > r2) {
        return MISS;
    }
    let delta_t = sqrt(r2 - l_m2);
    return closest((t_m - delta_t) / length, (t_m + delta_t) / length);
}

fn normal_at(ray: Ray, s: Sphere, t: f32) -> vec3<f32> {
    return normal_from_point(ray, s, t / s.scale);
}
