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

// The winner's answer and its bounds: docs/certificate.md, section 2.
fn projected_answer(s: Slopes, f: Projected, more: ProjectedDetail) -> Answer {
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
    let high = more.center - (along + least) * length + blur;
    let k = (along + root) * s.inverse;
    let normal = unit3(vec3<f32>(dx - k * s.x, dy - k * s.y, k));
    let off = sqrt(s.a) * (mixed + (most - least)) * s.inverse + UNIT * TURN * (total + sqrt(o2)) + e;
    // A root that is not certainly in front of the eye is not certainly the hit.
    let hits = crosses && projection.depth + low > VANISH;
    let depth_interval = (high - low + blur) * INFLATE;
    let turn = (off / f.rho + UNIT * SURFACE) * INFLATE;
    return Answer(hits && off < NORMAL * f.rho, hits, more.id, -(along + root) * length, low, high, depth_interval, normal, turn);
}
