// A sphere wholly in front of the eye plane, by its projected centre.

// Offset of the pixel from the projected centre. The difference of integers is exact.
fn front_offset(s: Slopes, f: Front) -> vec2<f32> {
    let dx = (f32(s.column - f.column) - f.rest.x) * lens.step_x;
    let dy = (f32(f.row - s.row) - f.rest.y) * lens.step_y;
    return vec2<f32>(dx, dy);
}

fn front_discriminant(s: Slopes, f: Front, o: vec2<f32>) -> f32 {
    let across = s.x * o.y - s.y * o.x;
    return s.a * f.rho2 - (o.x * o.x + o.y * o.y + across * across);
}

// A lower bound of the depth of the near root, or MISS for a certain miss.
fn front_low(s: Slopes, f: Front) -> f32 {
    let o = front_offset(s, f);
    let disc = front_discriminant(s, f, o);
    if (disc < -f.error) {
        return MISS;
    }
    let along = s.x * o.x + s.y * o.y;
    return f.low - (along + sqrt(disc + f.error)) * (f.size * s.inverse);
}

fn front_answer(s: Slopes, f: Front, more: FrontMore) -> Answer {
    let o = front_offset(s, f);
    let disc = front_discriminant(s, f, o);
    let along = s.x * o.x + s.y * o.y;
    let length = f.size * s.inverse;
    let hits = disc > f.error;
    let root = sqrt(positive(disc));
    let low = f.low - (along + sqrt(positive(disc + f.error))) * length;
    let high = more.high - (along + sqrt(positive(disc - f.error))) * length;
    let k = (along + root) * s.inverse;
    let normal = unit3(vec3<f32>(o.x - k * s.x, o.y - k * s.y, k));
    return Answer(hits && disc > more.least, hits, more.id, -(along + root) * length, low, high, normal);
}
