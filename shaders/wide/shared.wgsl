// origin/shared.wgsl in a better arithmetic: the sphere as the host moved it, high and low parts.
fn wide_sphere(s: Sphere, low: SphereLow) -> WideSphere {
    let p = Number3(pair(s.ball.x, low.ball.x), pair(s.ball.y, low.ball.y), pair(s.ball.z, low.ball.z));
    return WideSphere(p, pair(s.ball.w, low.ball.w), pair(s.power, low.power));
}
