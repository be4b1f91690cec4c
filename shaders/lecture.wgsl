// Lecture 6 on one page: for each pixel a viewing ray, the closest sphere that it hits, the colour of that sphere.
// examples/lecture.rs runs it. No other shader uses it: it is the beginning that the others improve on.

// The pose of the camera is its eye and the basis u, v, w: right, up and back. The viewport is vw x vh, at distance d.
struct Camera {
    eye: vec3<f32>,
    d: f32,
    u: vec3<f32>,
    pixel_width: f32,  // vw / W
    v: vec3<f32>,
    pixel_height: f32, // vh / H
    w: vec3<f32>,
    spheres: u32,
    width: u32,        // W
    height: u32,       // H
}

struct Sphere {
    center: vec3<f32>,
    radius: f32,
    color: vec3<f32>,  // linear RGB
}

// p + t d. A ray is half a line: t > 0.
struct Ray {
    p: vec3<f32>,
    d: vec3<f32>,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> spheres: array<Sphere>;
@group(0) @binding(2) var<storage, read_write> picture: array<vec4<f32>>; // linear RGB, and the index of the sphere or -1

const MISS: f32 = -1.0; // is not on the ray

// The viewing ray of row i and column j, from 0: u = ((j + 1/2) / W - 1/2) vw and v = -((i + 1/2) / H - 1/2) vh.
fn viewing_ray(i: u32, j: u32) -> Ray {
    let u = (f32(j) + 0.5 - 0.5 * f32(camera.width)) * camera.pixel_width;
    let v = -(f32(i) + 0.5 - 0.5 * f32(camera.height)) * camera.pixel_height;
    return Ray(camera.eye, u * camera.u + v * camera.v - camera.d * camera.w);
}

// The smallest t > 0 where the ray meets the sphere: |p + t d|^2 = r^2 with p from the centre, solved for t.
fn intersect(ray: Ray, sphere: Sphere) -> f32 {
    let d = ray.d;
    let p = ray.p - sphere.center;
    let discriminant = dot(d, p) * dot(d, p) - dot(d, d) * (dot(p, p) - sphere.radius * sphere.radius);
    if (discriminant < 0.0) {
        return MISS;
    }
    let near = (-dot(d, p) - sqrt(discriminant)) / dot(d, d);
    let far = (-dot(d, p) + sqrt(discriminant)) / dot(d, d);
    if (near > 0.0) {
        return near;
    }
    return select(MISS, far, far > 0.0);
}

// The cosine between the normal and the ray, as if the light were at the eye.
fn shade(ray: Ray, sphere: Sphere, t: f32) -> vec3<f32> {
    let normal = normalize(ray.p + t * ray.d - sphere.center);
    return abs(dot(normal, normalize(ray.d))) * sphere.color;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) at: vec3<u32>) {
    let i = at.y;
    let j = at.x;
    if (i >= camera.height || j >= camera.width) {
        return;
    }
    let ray = viewing_ray(i, j);
    var closest = MISS;
    var hit = 0u;
    for (var n = 0u; n < camera.spheres; n++) {
        let t = intersect(ray, spheres[n]);
        if (t > 0.0 && (closest == MISS || t < closest)) {
            closest = t;
            hit = n;
        }
    }
    var pixel = vec4<f32>(0.0, 0.0, 0.0, -1.0);
    if (closest > 0.0) {
        pixel = vec4<f32>(shade(ray, spheres[hit], closest), f32(hit));
    }
    picture[i * camera.width + j] = pixel;
}
