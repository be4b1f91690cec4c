// General spheres, with error bounds per ray.

// A sphere that is not completely in front: around the eye, beside it, or close and large. All lengths, and p.d, are
// scaled by 2^-k.
struct General {
    center_radius: vec4<f32>, // centre minus eye and radius
    power: f32,      // of the eye, 2^-2k; its sign is exact
    scale: f32,      // depth in this record's unit times scale is depth in the frame's unit
    form: u32,       // 0: a r^2 - |p x d|^2, 1: b^2 - a c
    id: u32,
    pixel: vec2<i32>, // where p.d is nearly zero; its steps, and p.d there
    by: vec2<f32>,
    start: f32,
    blur: f32,       // error of the host's rounding in p.d
    rank: u32,       // of a sphere that planes cut; 0 for a whole one
}

// From the four vectors of its record.
fn general_of(a: vec4<i32>, b: vec4<i32>, c: vec4<i32>, d: vec4<i32>) -> General {
    return General(
        bitcast<vec4<f32>>(a), bitcast<f32>(b.x), bitcast<f32>(b.y), bitcast<u32>(b.z), bitcast<u32>(b.w), c.xy,
        bitcast<vec2<f32>>(c.zw), bitcast<f32>(d.x), bitcast<f32>(d.y), bitcast<u32>(d.z),
    );
}

// b = p.d, the discriminant, and the bounds of their errors; g = p x d and the sum of its errors.
struct Weighed {
    b: f32,
    b_error: f32,
    disc: f32,
    error: f32,
    g: vec3<f32>,
    g_error: f32,
}

fn general_weigh(s: Slopes, n: General) -> Weighed {
    let p = n.center_radius.xyz;
    let l = abs(s.x) + abs(s.y) + 1.0;
    let right = f32(s.column - n.pixel.x) * n.by.x;
    let down = f32(s.row - n.pixel.y) * n.by.y;
    let b = n.start + right + down;
    let b_sum = START * abs(n.start) + STEP * (abs(right) + abs(down));
    let b_error = (UNIT * b_sum + n.blur + HOST_PARTS * HOST * l) * INFLATE;
    let g = vec3<f32>(-p.y - p.z * s.y, p.z * s.x + p.x, p.x * s.y - p.y * s.x);
    let e = vec3<f32>(
        abs(p.y) + abs(p.z * s.y), abs(p.z * s.x) + abs(p.x), abs(p.x * s.y) + abs(p.y * s.x),
    );
    let g_error = G * UNIT * e + vec3<f32>(HOST_PARTS * HOST * l);
    var disc: f32;
    var error: f32;
    if (n.form == 1u) {
        let ac = s.a * n.power;
        disc = b * b - ac;
        error = 2.0 * abs(b) * b_error + b_error * b_error + UNIT * (B2 * b * b + (AC_A * s.a + AC) * abs(ac));
    } else {
        let gg = g.x * g.x + g.y * g.y + g.z * g.z;
        let ar2 = s.a * (n.center_radius.w * n.center_radius.w);
        disc = ar2 - gg;
        let mixed = abs(g.x) * g_error.x + abs(g.y) * g_error.y + abs(g.z) * g_error.z;
        let small = g_error.x * g_error.x + g_error.y * g_error.y + g_error.z * g_error.z;
        error = UNIT * ((AR2_A * s.a + AR2) * ar2 + GG * gg) + 2.0 * mixed + small;
    }
    let sum = g_error.x + g_error.y + g_error.z;
    return Weighed(b, b_error, disc, error * INFLATE + s.a * VANISH, g, sum);
}

// The relative error of the root, the sum, |d|^2, its reciprocal and the product.
fn sum_error(s: Slopes) -> f32 {
    return UNIT * (SUM + SUM_A * s.a);
}

// A lower bound of the depth of the hit in the record's unit, or MISS for a certain miss.
fn general_below(s: Slopes, n: General, w: Weighed) -> f32 {
    if (n.power >= 0.0 && (w.disc < -w.error || w.b < -w.b_error)) {
        return MISS;
    }
    let most = sqrt(positive(w.disc + w.error));
    let least = sqrt(positive(w.disc - w.error));
    if (n.power > 0.0) {
        let q = w.b + w.b_error + most;
        if (q <= 0.0) {
            return MISS;
        }
        return min(n.power / q * (1.0 - QUOTIENT * UNIT), FAR);
    }
    if (w.b > w.b_error) {
        return (w.b - w.b_error + least) * s.inverse * (1.0 - sum_error(s));
    }
    if (n.power < 0.0) {
        return -n.power / (w.b_error - w.b + most) * (1.0 - QUOTIENT * UNIT);
    }
    return 0.0;
}

fn general_low(s: Slopes, n: General) -> f32 {
    let low = general_below(s, n, general_weigh(s, n));
    if (low < MISS) {
        return low * n.scale;
    }
    return MISS;
}

fn general_answer(s: Slopes, n: General) -> Answer {
    let w = general_weigh(s, n);
    let root = sqrt(positive(w.disc));
    let most = sqrt(positive(w.disc + w.error));
    let least = sqrt(positive(w.disc - w.error));
    let ahead = w.b > w.b_error;
    var hits = w.disc > w.error && (n.power < 0.0 || ahead);
    var depth: f32;
    var high: f32;
    var rounding = sum_error(s);
    if (n.power > 0.0) {
        rounding = QUOTIENT * UNIT;
        depth = n.power / (w.b + root);
        high = n.power / (w.b - w.b_error + least) * (1.0 + rounding);
    } else if (ahead) {
        depth = (w.b + root) * s.inverse;
        high = (w.b + w.b_error + most) * s.inverse * (1.0 + rounding);
    } else {
        let q = least - (w.b + w.b_error);
        depth = -n.power / (root - w.b);
        high = -n.power / q * (1.0 + rounding);
        hits = hits && q > CLEAR * least;
    }
    // |d|^2 (hit - centre) = -+(d x g) - sqrt(D) d, facing the ray: upper sign if the eye is outside.
    let d = vec3<f32>(s.x, s.y, -1.0);
    let across = cross3(d, w.g);
    let normal = unit3(select(across, -across, n.power > 0.0) - root * d);
    let size = sqrt(s.a) * n.center_radius.w;
    let off = w.g_error + (most - least);
    let turn = select(0.0, (off / size + UNIT * SURFACE) * INFLATE, n.power > 0.0);
    let below = general_below(s, n, w);
    let low = below * n.scale;
    // A smaller bound may have been flushed to zero where the other bound was not.
    hits = hits && low > VANISH;
    let depth_interval = (high - below + rounding * high) * INFLATE * n.scale;
    return Answer(hits && off < NORMAL * size, hits, n.id, depth * n.scale, low, high * n.scale, depth_interval, normal, turn);
}
