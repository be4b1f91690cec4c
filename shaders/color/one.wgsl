// No sphere names a colour: none is uploaded.
override DEFAULT_RED: f32;
override DEFAULT_GREEN: f32;
override DEFAULT_BLUE: f32;

fn sphere_color(id: u32) -> vec3<f32> {
    return vec3<f32>(DEFAULT_RED, DEFAULT_GREEN, DEFAULT_BLUE);
}
