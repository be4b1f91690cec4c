// The candidate lists of the tiles, in whole chunks.

// For every tile its first entry and the one past its last, and the same of its general spheres in a certified kernel.
// Then for every chunk a lower bound for its spheres and all later ones of the list: in a certified kernel of depth,
// relative to the reference depth; otherwise of t. Then the tiles' general spheres, by their places in `others`.
@group(0) @binding(BIND_LISTS) var<storage, read> lists: array<u32>;

// A tile's first entry, and the one past its last.
fn tile_list(tile: vec3<u32>) -> vec2<u32> {
    let list = 4u * (tile.y * tile_columns() + tile.x);
    return vec2<u32>(lists[list], lists[list + 1u]);
}

// The places in lists of a tile's first general sphere, and of the one past its last.
fn tile_generals(tile: vec3<u32>) -> vec2<u32> {
    let list = 4u * (tile.y * tile_columns() + tile.x) + 2u;
    return vec2<u32>(lists[list], lists[list + 1u]);
}

// The first index of the chunks' bounds in lists.
fn chunk_numbers() -> u32 {
    return 4u * tile_columns() * tile_rows();
}
