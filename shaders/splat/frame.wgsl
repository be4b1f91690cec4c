// The slopes of a ray of the frame.

// Constants of all tests of an invocation, loaded once: software adapters read a uniform lane by lane inside a loop.
struct Frame {
    slope: vec2<f32>,
    fixed: vec2<f32>,
    middle: vec2<i32>, // W - 1 and H - 1
    error: vec3<f32>,
    unit: f32,
    size: f32,
    shift: u32,
    first: vec2<u32>,
    columns: u32,
    pixels: u32,
    mode: u32,
}

fn frame_constants() -> Frame {
    return Frame(
        projection.slope, projection.fixed, vec2<i32>(i32(view.width) - 1, i32(view.height) - 1), projection.errors,
        projection.unit, projection.size, projection.shift, vec2<u32>(view.first_column, view.first_row), view.columns,
        view.columns * view.rows, block_pass.mode,
    );
}

fn slopes_of(c: Frame, to: vec2<u32>) -> Slopes {
    let at = vec2<i32>(to);
    let x = f32(2 * at.x - c.middle.x) * c.slope.x;
    let y = f32(c.middle.y - 2 * at.y) * c.slope.y;
    let a = 1.0 + x * x + y * y;
    return Slopes(
        x, y, a, 1.0 / a, at.y, at.x, at.y << c.shift, at.x << c.shift, c.fixed, c.error, c.unit, c.size,
    );
}
