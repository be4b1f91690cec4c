// The candidate lists of the tiles, in whole chunks.

// For every tile its first entry and the one past its last, and the same of its general spheres in a certified kernel.
// Then for every chunk a lower bound for its spheres and all later ones of the list: in a certified kernel of depth,
// relative to the reference depth; otherwise of t. Then the tiles' general spheres, by their places in `others`.
@group(0) @binding(BIND_LISTS) var<storage, read> lists: array<u32>;

// lists[n], for a subgroup.
fn shared_entry(n: u32) -> u32 {
    var entry = 0u;
    if (leads()) {
        entry = lists[n];
    }
    return of_leader(vec4<u32>(entry, 0u, 0u, 0u)).x;
}

fn shared_range(n: u32) -> vec2<u32> {
    var range = vec2<u32>(0u, 0u);
    if (leads()) {
        range = vec2<u32>(lists[n], lists[n + 1u]);
    }
    return of_leader(vec4<u32>(range, 0u, 0u)).xy;
}

// A tile's first entry, and the one past its last.
fn tile_list(tile: vec3<u32>) -> vec2<u32> {
    return shared_range(4u * (tile.y * tile_columns() + tile.x));
}

// The places in lists of a tile's first general sphere, and of the one past its last.
fn tile_generals(tile: vec3<u32>) -> vec2<u32> {
    return shared_range(4u * (tile.y * tile_columns() + tile.x) + 2u);
}

// The first index of the chunks' bounds in lists.
fn chunk_numbers() -> u32 {
    return 4u * tile_columns() * tile_rows();
}
