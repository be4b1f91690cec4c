// The candidate lists of the tiles, in whole chunks.

// Of every tile its first entry and the one past its last; then for every chunk how near its spheres, and those behind it
// in its list, can be: for a certified kernel their least depth, relative to the reference depth; else their least t.
@group(0) @binding(BIND_LISTS) var<storage, read> lists: array<u32>;

// A tile's first entry, and the one past its last.
fn tile_list(tile: vec3<u32>) -> vec2<u32> {
    let list = 2u * (tile.y * tile_columns() + tile.x);
    return vec2<u32>(lists[list], lists[list + 1u]);
}

// Where in lists the chunks' numbers begin.
fn chunk_numbers() -> u32 {
    return 2u * tile_columns() * tile_rows();
}
