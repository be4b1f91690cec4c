// The data's way, once per pixel: ray, nearest hit, colour, frame.

fn render(tile: vec3<u32>, index: u32) {
    let at = pixel_at(tile, index);
    let to = aim(at);
    let ray = viewing_ray(to.y, to.x);
    let hit = nearest(ray);
    // Only now may invocations outside the window leave: they carried spheres for their subgroup.
    if (!is_shown(at)) {
        return;
    }
    let pixel = place_of(at);
    write_id(pixel, hit);
    write_t(pixel, hit);
    write_normal(pixel, ray, hit);
    write_color(pixel, ray, hit);
}
