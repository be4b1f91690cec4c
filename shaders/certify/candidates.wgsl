// The near spheres and those of a tile, nearest first. Invocations that load together leave the list together: to those that
// could leave earlier, what follows makes no difference, since all of it lies behind the sill.
fn candidates(s: Slopes, range: vec2<u32>) -> Kept {
    var k = keep_nears(s, Kept(BEYOND, BEYOND, NONE));
    for (var first = range.x; first < range.y; first += CHUNK) {
        let sill = bitcast<f32>(lists[s.sills + first / CHUNK]);
        let behind = is_behind(s, k, sill);
        k.second = select(k.second, min(k.second, sill), behind);
        if (all_of_us(behind)) {
            break;
        }
        k = ask(s, k, first);
    }
    return k;
}
