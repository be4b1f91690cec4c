// Adds up the rays toward the sky that main/sky.wgsl traced from the hits of a window. A hit whose rays the host has to trace
// is listed for it.

@group(0) @binding(BIND_FRAME_ID) var<storage, read> frame_id: array<u32>;
@group(0) @binding(BIND_STARTS) var<storage, read> starts: array<vec4<f32>>;

fn is_open(words: u32, ray: u32) -> bool {
    return ((open[words + (ray >> 5u)] >> (ray & 31u)) & 1u) == 1u;
}

@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) tile: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let at = pixel_at(tile, index);
    if (!in_crop(at)) {
        return;
    }
    let place = pixel_index(at);
    let id = frame_id[place];
    let each = sky.rays + sky.lights;
    let words = place * ((each >> 5u) + 1u);
    var normal = vec3<f32>();
    var sums = NO_SUMS;
    if (id != NONE && is_open(words, each)) {
        list_for_host(place, NONE);
    } else if (id != NONE) {
        normal = starts[2u * place].xyz;
        let first = turn_of(at) * sky.rays;
        for (var ray = 0u; ray < sky.rays; ray++) {
            // Directions have length 2.
            let d = 0.5 * bitcast<vec3<f32>>(directions[2u * (first + ray)].xyz);
            let outward = select(d, -d, dot3(normal, d) < 0.0);
            let share = zenith(outward);
            let free = select(0.0, 1.0, is_open(words, ray));
            sums = plus(sums, Sums(outward, free * outward, share * outward, free * share * outward), 1.0);
        }
        sums = plus(NO_SUMS, sums, 1.0 / f32(sky.rays));
    }
    let n = sky_pixels();
    sky_hits[place] = id;
    sky_hits[place + n] = pack2x16snorm(normal.xy);
    sky_hits[place + 2u * n] = pack2x16snorm(vec2<f32>(normal.z, 0.0));
    write_sums(place, sums);
}
