// Where rays leave from a proved hit: the unit normal in world space, and the bound of its error; 0 where there is none.
@group(0) @binding(BIND_STARTS) var<storage, read_write> starts: array<vec4<f32>>;

fn keep_start(pixel: u32) {
    starts[pixel] = vec4<f32>(to_world(answer.normal), answer.turn);
}
