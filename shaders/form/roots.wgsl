// Shared by the lecture's three forms.

// The smaller positive one of two ordered roots: a ray is half a line, t > 0.
fn closest(near: f32, far: f32) -> f32 {
    if (near > 0.0) {
        return near;
    }
    if (far > 0.0) {
        return far;
    }
    return MISS;
}

// The unit normal from the hit point minus the centre, oriented to face the ray's origin.
fn normal_from_point(ray: Ray, s: Sphere, t: f32) -> vec3<f32> {
    let n = unit3(t * ray.d - s.center);
    return select(n, -n, dot3(n, ray.d) > 0.0);
}
