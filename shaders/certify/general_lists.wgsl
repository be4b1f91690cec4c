// The general spheres of a tile, from its list.

// The general spheres, four vectors each.
@group(0) @binding(BIND_GENERALS_STORAGE) var<storage, read> generals_storage: array<vec4<i32>>;
// For every tile where its list begins and where it ends; then the lists, of places in `generals_storage`.
@group(0) @binding(BIND_LISTS) var<storage, read> lists: array<u32>;

fn general_at(n: u32) -> General {
    let at = 4u * n;
    return general_of(generals_storage[at], generals_storage[at + 1u], generals_storage[at + 2u], generals_storage[at + 3u]);
}

fn nearest_two_generals(s: Slopes, start: NearestTwo, tile: vec3<u32>) -> NearestTwo {
    var k = start;
    let own = 2u * (tile.y * tile_columns() + tile.x);
    for (var n = lists[own]; n < lists[own + 1u]; n++) {
        k = test_general(s, k, lists[n]);
    }
    return k;
}
