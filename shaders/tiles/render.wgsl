// The data's way, once per pixel: ray, nearest hit among the candidates of its tile, colour, frame.

// Where in candidates the hit is that is written.
var<private> place: u32;

fn render(tile: vec3<u32>, index: u32) {
    let at = pixel_at(tile, index);
    let to = aim(at);
    let list = 2u * (tile.y * tile_columns() + tile.x);
    let limits = 2u * tile_columns() * tile_rows();
    let ray = viewing_ray(to.y, to.x);
    let found = nearest_in(ray, vec2<u32>(lists[list], lists[list + 1u]), limits);
    // Only now may invocations outside the window leave: they carried spheres for their subgroup.
    if (!is_shown(at)) {
        return;
    }
    let pixel = place_of(at);
    place = found.place;
    write_id(pixel, found.hit);
    write_t(pixel, found.hit);
    write_normal(pixel, ray, found.hit);
    write_color(pixel, ray, found.hit);
}
