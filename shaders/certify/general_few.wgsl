// So few general spheres that every ray tests all of them. A uniform takes none of the storage buffers; some adapters bind
// only ten of them.
@group(0) @binding(BIND_GENERALS_UNIFORM) var<uniform> generals_uniform: array<vec4<i32>, 4u * MAX_GENERALS_WITHOUT_LISTS>;

fn general_at(n: u32) -> General {
    let at = 4u * n;
    return general_of(generals_uniform[at], generals_uniform[at + 1u], generals_uniform[at + 2u], generals_uniform[at + 3u]);
}

fn nearest_two_generals(s: Slopes, start: NearestTwo, tile: vec3<u32>) -> NearestTwo {
    var k = start;
    for (var n = 0u; n < projection.generals; n++) {
        k = test_general(s, k, n);
    }
    return k;
}
