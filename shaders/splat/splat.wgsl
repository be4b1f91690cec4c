// What a projected sphere is to a pixel. Two passes leave for every pixel the two smallest lower bounds of depth and the slot of
// the smallest: minima, in any order. A third finds the spheres among which the host decides an unsure pixel.

// For every pixel of the band the least depth, then the slots, then the second least depths, all inverted, so that 0 is none.
@group(0) @binding(BIND_MINIMA) var<storage, read_write> minima: array<atomic<u32>>;
@group(0) @binding(BIND_FRAME_ID) var<storage, read_write> frame_id: array<u32>;
// Pixel of the band and slot.
@group(0) @binding(BIND_PAIRS) var<storage, read_write> pairs: array<vec2<u32>>;

const LEAST: u32 = 0u;
const SLOTS: u32 = 1u;
const PAIRS_OF_UNSURE: u32 = 2u;

// What all tests of an invocation have in common, loaded once: software adapters read a uniform lane by lane inside a loop.
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

// The same numbers as of slopes in certify/projection.wgsl.
fn slopes_of(c: Frame, to: vec2<u32>) -> Slopes {
    let at = vec2<i32>(to);
    let x = f32(2 * at.x - c.middle.x) * c.slope.x;
    let y = f32(c.middle.y - 2 * at.y) * c.slope.y;
    let a = 1.0 + x * x + y * y;
    return Slopes(
        x, y, a, 1.0 / a, at.y, at.x, at.y << c.shift, at.x << c.shift, c.fixed, c.error, c.unit, c.size,
    );
}

fn splat(c: Frame, f: Projected, slot: u32, at: vec2<u32>) {
    let pixel = (at.y - c.first.y) * c.columns + (at.x - c.first.x);
    // Nearly all pixels are proved.
    if (c.mode == PAIRS_OF_UNSURE && frame_id[pixel] != UNSURE) {
        return;
    }
    let low = projected_low(slopes_of(c, sample_position(at)), f);
    if (low >= MISS) {
        return;
    }
    let key = inverted(low);
    if (c.mode == LEAST) {
        if (key > atomicLoad(&minima[pixel])) {
            atomicMax(&minima[pixel], key);
        }
    } else if (c.mode == SLOTS) {
        let second = 2u * c.pixels + pixel;
        if (key == atomicLoad(&minima[pixel])) {
            // An exact tie makes the pixel unsure, whichever comes first.
            if (atomicMax(&minima[c.pixels + pixel], ~slot) != 0u) {
                atomicMax(&minima[second], key);
            }
        } else if (key > atomicLoad(&minima[second])) {
            atomicMax(&minima[second], key);
        }
    } else if (key >= atomicLoad(&minima[2u * c.pixels + pixel])) {
        // main/certified.wgsl has left the depth that the nearest hit does not exceed.
        // The host asks only whether there are more than PAIRS, so the count stops soon after, and cannot wrap.
        if (atomicLoad(&summary[SUMMARY_PAIRS]) <= PAIRS) {
            let place = atomicAdd(&summary[SUMMARY_PAIRS], 1u);
            if (place < PAIRS) {
                pairs[place] = vec2<u32>(pixel, slot);
            }
        }
    }
}

// The rectangle as far as it lies in the band.
fn in_band(r: vec4<i32>) -> vec4<i32> {
    let first = vec2<i32>(i32(view.first_column), i32(view.first_row));
    let last = first + vec2<i32>(i32(view.columns), i32(view.rows)) - vec2<i32>(1);
    return vec4<i32>(max(r.xy, first), min(r.zw, last));
}
