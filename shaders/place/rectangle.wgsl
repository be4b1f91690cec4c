// The pixels of the image whose rays may hit a projected sphere; docs/certificate.md, section 4.

const NOWHERE: i32 = 0x40000000; // a coordinate of no projected sphere
const FLUSHED: f32 = 4.70197740328915e-38; // 2^-124: above the loss of f32 below its normal numbers

// Half the sides of a projected sphere's rectangle, in pixels of the frame. `from_middle` is the distance of its projected
// centre from the middle of the frame. The sides exceed the host's by the error of f32; the pixels between are certain
// misses.
fn half_sides(rho: f32, from_middle: vec2<f32>) -> vec2<f32> {
    let reach = (placing.reach.x + rho * placing.reach.y) * placing.per_step;
    let steepest = min((abs(from_middle) + reach) * placing.slope, placing.edge);
    let half = (rho + placing.wider) * (vec2<f32>(1.0) + 0.5 * steepest * steepest) * placing.per_step;
    return half * 1.00001 + vec2<f32>(0.001);
}

// The largest integer not above a / b, for b > 0.
fn quotient_below(a: i32, b: i32) -> i32 {
    let q = a / b;
    return q - i32(q * b > a);
}

// First column and row, last column and row; a last one is smaller where there is no pixel.
fn rectangle(x: i32, y: i32, rho: f32) -> vec4<i32> {
    let unit = bitcast<f32>((127u - placing.shift) << 23u);
    let at = vec2<i32>(x, y);
    let half = half_sides(rho, vec2<f32>(at) * unit - placing.middle_f32);
    // Places are within 2^29 units and the image within 2^27 of 0, so 2^30 reaches across it.
    let reach = vec2<i32>(min(half / unit, vec2<f32>(1073741824.0))) + vec2<i32>(1);
    let corner = vec2<i32>(vec2<u32>(view.shift_column, view.shift_row) << vec2<u32>(placing.shift));
    let pixel = i32(placing.fine << placing.shift);
    let low = at - reach - corner + vec2<i32>((1i << placing.shift) - 1);
    let high = at + reach - corner;
    var first: vec2<i32>;
    var last: vec2<i32>;
    if (placing.fine == 1u) {
        first = low >> vec2<u32>(placing.shift);
        last = high >> vec2<u32>(placing.shift);
    } else {
        first = vec2<i32>(quotient_below(low.x, pixel), quotient_below(low.y, pixel));
        last = vec2<i32>(quotient_below(high.x, pixel), quotient_below(high.y, pixel));
    }
    return vec4<i32>(max(first, vec2<i32>(0)), min(last, vec2<i32>(i32(placing.columns), i32(placing.rows)) - vec2<i32>(1)));
}

// Whether one invocation goes through all pixels. Sides come first, for their product may be more than an i32.
fn is_small(r: vec4<i32>) -> bool {
    let sides = r.zw - r.xy + vec2<i32>(1);
    let most = i32(MAX_PIXELS_PER_INVOCATION);
    return any(sides < vec2<i32>(1)) || (all(sides <= vec2<i32>(most)) && sides.x * sides.y <= most);
}
