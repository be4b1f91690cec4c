// The certified kernel, once per pixel: it reads the minima that spheres left there (shaders/splat), certifies the
// winner, and writes the outputs.

// For every pixel of the band the least depth, then the slots, then the second least depths, and where planes cut spheres the ranks of
// faces, all inverted, so that 0 is none.
@group(0) @binding(BIND_MINIMA) var<storage, read_write> minima: array<u32>;

var<private> answer: Answer;
var<private> proved: bool;
var<private> winner: u32; // its slot

fn winner_record(slot: u32) -> Projected {
    return projected_of(uncut(projected[slot - block_pass.first]));
}

// The depth of the winner's centre, in f64.
fn center_depth() -> vec2<u32> {
    var bits = depth_of_face(winner);
    if ((winner & GENERAL) == 0u) {
        let n = winner - block_pass.first;
        let two = bitcast<vec4<u32>>(projected[2u * block_pass.count + n / 2u]);
        bits = select(two.xy, two.zw, n % 2u == 1u);
    }
    return bits;
}

// Unit normal at the hit, in the canonical camera, facing the eye.
fn surface_normal(ray: Ray, hit: Hit) -> vec3<f32> {
    return answer.normal;
}

fn written_id(hit: Hit) -> u32 {
    return select(UNSURE, hit.id, proved);
}

// A workgroup is a tile of 8 x 8 pixels.
@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) tile: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let at = pixel_at(tile, index);
    if (!in_crop(at)) {
        return;
    }
    let pixel = pixel_index(at);
    let pixels = view.columns * view.rows;
    let to = sample_position(at);
    let s = slopes_of(frame_constants(), to);
    let found = NearestTwo(depth_of(minima[pixel]), depth_of(minima[2u * pixels + pixel]), ~minima[pixels + pixel]);
    begin_solids(s, pixel, pixels);
    let k = with_face(nearest_two_generals(s, found, tile));
    // The block of the winner has its record; the first block takes the winners of no block.
    let own = select(k.slot - block_pass.first < block_pass.count, block_pass.first == 0u, (k.slot & GENERAL) != 0u);
    if (!own) {
        return;
    }
    winner = k.slot;
    answer = certify_solid(s, k);
    // A depth without its sphere would be a miss that nothing proves.
    proved = (k.slot == NONE && k.low == BEYOND) || (k.slot != NONE && taken(answer, k));
    if (!proved) {
        // No nearer hit lies behind this depth: the third pass of shaders/splat compares with it.
        minima[2u * pixels + pixel] = select(0u, inverted(answer.high + VANISH), answer.hits && k.slot != NONE);
    }
    keep_start(pixel, s);
    write_outputs(pixel, Ray(vec3<f32>(s.x, s.y, -1.0)), Hit(answer.offset, answer.id));
}
