// The starts of rays that leave from proved hits, two vectors a pixel: the unit normal in world space and the bound of
// its error, 0 where the host has to trace them; the way from the eye to the hit, in the frame's unit and the world's
// axes, and the bound of its error as a length.
@group(0) @binding(BIND_STARTS) var<storage, read_write> starts: array<vec4<f32>>;

fn keep_start(pixel: u32, s: Slopes) {
    let depth = projection.depth + 0.5 * (answer.low + answer.high);
    let doubt = 0.5 * answer.depth_interval + UNIT * WAY * depth;
    starts[2u * pixel] = vec4<f32>(to_world(answer.normal), answer.turn);
    starts[2u * pixel + 1u] = vec4<f32>(depth * to_world(vec3<f32>(s.x, s.y, -1.0)), sqrt(s.a) * doubt * INFLATE);
}
