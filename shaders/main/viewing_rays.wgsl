// The kernel of viewing rays, once per pixel: ray, nearest hit, outputs.
fn render(tile: vec3<u32>, index: u32) {
    let at = pixel_at(tile, index);
    let to = sample_position(at);
    let ray = viewing_ray(to.y, to.x);
    let hit = nearest(ray, tile);
    // Invocations outside the crop leave only now, because they loaded spheres for their subgroup.
    if (!in_crop(at)) {
        return;
    }
    write_outputs(pixel_index(at), ray, hit);
}
