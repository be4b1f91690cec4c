// The search of the certified kernel alone, for ROWS pixels of a column. The host certifies the winners: software adapters
// store each number lane by lane, and read a winner's record so.

var<private> two: NearestTwo;

fn written_id(hit: Hit) -> u32 {
    return hit.id;
}

fn slopes_at(at: vec2<u32>) -> Slopes {
    let to = sample_position(at);
    return slopes(to.y, to.x);
}

fn write(at: vec2<u32>, s: Slopes, k: NearestTwo) {
    if (in_crop(at)) {
        two = k;
        write_outputs(pixel_index(at), Ray(vec3<f32>(s.x, s.y, -1.0)), Hit(k.low, k.slot));
    }
}

fn render(tile: vec3<u32>, index: u32) {
    let at = pixel_at(tile, index % TILE + (index / TILE) * ROWS * TILE);
    let down = vec2<u32>(0u, 1u);
    let s = Column(slopes_at(at), slopes_at(at + down), slopes_at(at + 2u * down), slopes_at(at + 3u * down));
    let k = nearest_two(s, tile);
    write(at, s.a, k.a);
    write(at + down, s.b, k.b);
    write(at + 2u * down, s.c, k.c);
    write(at + 3u * down, s.d, k.d);
}
