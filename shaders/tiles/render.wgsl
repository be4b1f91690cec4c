// The data's way, once per pixel: ray, nearest hit among the candidates of its tile, colour, frame.
const TILE: u32 = 8u; // pixels along a side of a workgroup's tile

// Where in candidates the hit is that is written.
var<private> place: u32;

fn render(tile: vec3<u32>, index: u32) {
    let row = tile.y * TILE + index / TILE;
    let column = tile.x * TILE + index % TILE;
    let tiles = (view.width + TILE - 1u) / TILE;
    let list = 2u * (tile.y * tiles + tile.x);
    let limits = 2u * tiles * ((view.rows + TILE - 1u) / TILE);
    let ray = viewing_ray(view.first_row + row, column);
    let found = nearest_in(ray, vec2<u32>(lists[list], lists[list + 1u]), limits);
    // Only now may invocations outside the image leave: they carried spheres for their subgroup.
    if (row >= view.rows || column >= view.width) {
        return;
    }
    let pixel = row * view.width + column;
    place = found.place;
    write_id(pixel, found.hit);
    write_t(pixel, found.hit);
    write_normal(pixel, ray, found.hit);
    write_color(pixel, ray, found.hit);
}
