// The search of the certified kernel alone, once per pixel. The host certifies the winners: software adapters store
// each number lane by lane, and read a winner's record so.

var<private> two: NearestTwo;

fn written_id(hit: Hit) -> u32 {
    return hit.id;
}

fn render(tile: vec3<u32>, index: u32) {
    let at = pixel_at(tile, index);
    let to = sample_position(at);
    let s = slopes(to.y, to.x);
    two = nearest_two(s, tile);
    // Invocations outside the crop leave only now, because they loaded spheres for their subgroup.
    if (!in_crop(at)) {
        return;
    }
    write_outputs(pixel_index(at), Ray(vec3<f32>(s.x, s.y, -1.0)), Hit(two.low, two.slot));
}
