// The kernel of viewing rays, once per pixel: ray, nearest hit, outputs. A workgroup is a tile of 8 x 8 pixels.
@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) tile: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let at = pixel_at(tile, index);
    if (!in_crop(at)) {
        return;
    }
    let to = sample_position(at);
    let ray = viewing_ray(to.y, to.x);
    write_outputs(pixel_index(at), ray, nearest(ray));
}
