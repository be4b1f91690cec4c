// origin/spread.wgsl in a better arithmetic: the sphere moved once more, to its ray's origin.
fn moved(ball: f32, low: f32, origin: f32, origin_low: f32, shrink: f32) -> Number {
    return sub(pair(ball, low), scaled(pair(origin, origin_low), shrink));
}

fn wide_sphere(s: Sphere, low: SphereLow) -> WideSphere {
    let shrink = 1.0 / s.scale; // a power of two
    let p = Number3(
        moved(s.ball.x, low.ball.x, given.origin.x, given.origin_low.x, shrink),
        moved(s.ball.y, low.ball.y, given.origin.y, given.origin_low.y, shrink),
        moved(s.ball.z, low.ball.z, given.origin.z, given.origin_low.z, shrink),
    );
    let r = pair(s.ball.w, low.ball.w);
    return WideSphere(p, r, sub(dot_wide(p, p), mul(r, r)));
}
