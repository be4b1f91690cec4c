// The data's way, once per pixel: ray, nearest hit, colour, frame.
const TILE: u32 = 8u; // pixels along a side of a workgroup's tile

fn render(tile: vec3<u32>, index: u32) {
    let row = tile.y * TILE + index / TILE;
    let column = tile.x * TILE + index % TILE;
    let ray = viewing_ray(view.first_row + row, column);
    let hit = nearest(ray);
    // Only now may invocations outside the image leave: they carried spheres for their subgroup.
    if (row >= view.rows || column >= view.width) {
        return;
    }
    let pixel = row * view.width + column;
    write_id(pixel, hit);
    write_t(pixel, hit);
    write_normal(pixel, ray, hit);
    write_color(pixel, ray, hit);
}
