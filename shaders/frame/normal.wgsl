// Unit world normal against the ray; zero on a miss.
@group(0) @binding(5) var<storage, read_write> frame_normal: array<f32>;

fn write_normal(pixel: u32, ray: Ray, hit: Hit) {
    var n = vec3<f32>(0.0, 0.0, 0.0);
    if (hit.id != NONE) {
        n = to_world(surface_normal(ray, hit));
    }
    frame_normal[3u * pixel] = n.x;
    frame_normal[3u * pixel + 1u] = n.y;
    frame_normal[3u * pixel + 2u] = n.z;
}
