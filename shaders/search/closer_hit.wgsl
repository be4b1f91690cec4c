// The spheres in the canonical camera, and the choice of the closer hit.

// A sphere's record, scaled by its own power of two 2^-k, so that squares neither overflow nor underflow.
struct SphereRecord {
    center_radius: vec4<f32>, // centre minus eye and radius, 2^-k
    power: f32,               // of the eye: |c - e|^2 - r^2 in higher precision, 2^-2k
    scale: f32,               // t in this record's unit times scale is t in the frame's unit
}

// The errors of rounding a record to f32.
struct SphereResiduals {
    center_radius: vec4<f32>,
    power: f32,
}

@group(0) @binding(BIND_SPHERES) var<storage, read> spheres: array<SphereRecord>;

fn no_hit() -> Hit {
    return Hit(from_f32(MISS), NONE);
}

// The nearer of a hit and the hit of the sphere with this id. Spheres come in the order of their ids, and the comparison is strict:
// of equal t the lower id wins.
fn closer_hit(hit: Hit, ray: Ray, id: u32) -> Hit {
    let s = sphere_of(id);
    let t = intersect(ray, s);
    if (less(t, from_f32(MISS))) {
        let there = scaled(t, s.scale);
        if (less(there, hit.t)) {
            return Hit(there, id);
        }
    }
    return hit;
}

// Unit normal at a hit, in the canonical camera, facing the ray's origin.
fn surface_normal(ray: Ray, hit: Hit) -> vec3<f32> {
    return normal_at(ray, sphere_of(hit.id), hit.t);
}

fn written_id(hit: Hit) -> u32 {
    return hit.id;
}
