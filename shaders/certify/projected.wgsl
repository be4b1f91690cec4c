// Projected spheres: spheres completely in front of the eye plane.

// a rho^2 - |o|^2 - (slopes x o)^2: positive where the ray at offset o from the projected centre hits.
fn projected_discriminant(s: Slopes, rho: f32, o: vec2<f32>) -> f32 {
    let across = s.x * o.y - s.y * o.x;
    return s.a * (rho * rho) - (o.x * o.x + o.y * o.y + across * across);
}

// A lower bound of the depth of the near root, or MISS for a certain miss.
fn projected_low(s: Slopes, f: Projected) -> f32 {
    let o = vec2<f32>(f32(s.fixed_column - f.x) * s.fixed.x, f32(f.y - s.fixed_row) * s.fixed.y);
    let disc = projected_discriminant(s, f.rho, o);
    let error = s.error.x + f.rho * (s.error.y + f.rho * s.error.z);
    // Slope along the offset plus root, in the order that Mesa's compiler gives a sum that is used once.
    let total = s.x * o.x + (s.y * o.y + sqrt(positive(disc + error)));
    let size = f.low * s.unit + s.size;
    let low = f.low - total * (size * s.inverse);
    return select(low, MISS, disc < -error);
}

// The near root of a sphere, and the numbers that its bounds are made of: docs/certificate.md, section 2.
struct Solved {
    o: vec2<f32>,  // the offset, and its square
    o2: f32,
    disc: f32,
    error: f32,
    root: f32,     // of the discriminant, and its bounds
    most: f32,
    least: f32,
    along: f32,    // the slope along the offset; it and the largest root
    total: f32,
    length: f32,   // the depth of a unit of the roots
    mixed: f32,    // the error in that unit, and of a depth
    blur: f32,
    low: f32,
    hits: bool,
}

fn projected_solved(s: Slopes, f: Projected, more: ProjectedDetail) -> Solved {
    let half = 1i << (projection.shift - 1u);
    let column = (f.x + half) >> projection.shift;
    let row = (f.y + half) >> projection.shift;
    let dx = (f32(s.column - column) - more.subpixel_offset.x) * projection.step.x;
    let dy = (f32(row - s.row) - more.subpixel_offset.y) * projection.step.y;
    let disc = projected_discriminant(s, f.rho, vec2<f32>(dx, dy));
    let slant2 = s.x * s.x + s.y * s.y;
    let o2 = dx * dx + dy * dy;
    let e = projection.edge;
    let roundings = (RHO2 + RHO2_SLANT * slant2) * (f.rho * f.rho) + (OFFSET2 + OFFSET2_SLANT * slant2) * o2;
    let error = (UNIT * roundings + s.a * e * (2.0 * sqrt(o2) + e)) * INFLATE + VANISH * s.a;
    let slant = sqrt(slant2);
    let crosses = disc > error;
    let root = sqrt(positive(disc));
    let most = sqrt(positive(disc + error));
    let least = sqrt(positive(disc - error));
    let along = s.x * dx + s.y * dy;
    let total = abs(along) + most;
    let depth = projection.depth + more.center;
    let length = (more.center * projection.unit + projection.size) * s.inverse;
    let steep = abs(s.x * dx) + abs(s.y * dy);
    let mixed = UNIT * ((TOTAL + TOTAL_SLANT * slant2) * total + ALONG * steep + ROOT * most) + slant * e;
    let blur = (mixed * length + UNIT * CENTER * abs(more.center)) * INFLATE + DEPTH * depth;
    let low = more.center - (along + most) * length - blur;
    // A root that is not certainly in front of the eye is not certainly the hit.
    let hits = crosses && projection.depth + low > VANISH;
    return Solved(vec2<f32>(dx, dy), o2, disc, error, root, most, least, along, total, length, mixed, blur, low, hits);
}

// The winner's answer and its bounds.
fn projected_answer(s: Slopes, f: Projected, more: ProjectedDetail) -> Answer {
    let n = projected_solved(s, f, more);
    let high = more.center - (n.along + n.least) * n.length + n.blur;
    let k = (n.along + n.root) * s.inverse;
    let normal = unit3(vec3<f32>(n.o.x - k * s.x, n.o.y - k * s.y, k));
    let e = projection.edge;
    let off = sqrt(s.a) * (n.mixed + (n.most - n.least)) * s.inverse + UNIT * TURN * (n.total + sqrt(n.o2)) + e;
    let depth_interval = (high - n.low + n.blur) * INFLATE;
    let turn = (off / f.rho + UNIT * SURFACE) * INFLATE;
    return Answer(n.hits && off < NORMAL * f.rho, n.hits, more.id, -(n.along + n.root) * n.length, n.low, high, depth_interval, normal, turn);
}
