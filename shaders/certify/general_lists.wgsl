// The general spheres of a tile, from its list.

// The general spheres, four vectors each. Then numbers, four to a vector: for every tile where its list begins and where it
// ends, counted from the first number, and then the lists, of places among the spheres. Adapters bind few buffers, so this is one.
@group(0) @binding(BIND_GENERALS_STORAGE) var<storage, read> generals_storage: array<vec4<i32>>;

fn general_at(n: u32) -> General {
    let at = 4u * n;
    return general_of(generals_storage[at], generals_storage[at + 1u], generals_storage[at + 2u], generals_storage[at + 3u]);
}

// A number behind the spheres, which are `first` vectors.
fn listed(first: u32, n: u32) -> u32 {
    return bitcast<u32>(generals_storage[first + n / 4u][n % 4u]);
}

fn nearest_two_generals(s: Slopes, start: NearestTwo, tile: vec3<u32>) -> NearestTwo {
    var k = start;
    let first = 4u * projection.generals;
    let own = 2u * (tile.y * tile_columns() + tile.x);
    let end = listed(first, own + 1u);
    for (var n = listed(first, own); n < end; n++) {
        k = test_general(s, k, listed(first, n));
    }
    return k;
}
