// The closest hit among the general spheres, which every ray tests, and the candidates of the tile. Both are stored in
// spheres, in whole chunks.

// Invocations that share loads leave the list together; those that could leave earlier keep their hit.
fn nearest(ray: Ray, tile: vec3<u32>) -> Hit {
    let range = tile_list(tile);
    let limits = chunk_numbers();
    let generals = view.spheres;
    var found = Found(no_hit(), NONE);
    for (var n = 0u; n < generals + range.y - range.x; n += CHUNK) {
        let first = select(range.x + n - generals, n, n < generals);
        let behind = to_hi(found.hit.t) < bitcast<f32>(shared_entry(limits + first / CHUNK));
        if (all_of_subgroup(behind)) {
            break;
        }
        let closer = test_chunk(ray, found, first, CHUNK);
        if (!behind) {
            found = closer;
        }
    }
    place = found.place;
    return found.hit;
}
