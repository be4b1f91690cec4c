// Rays from many points: each sphere is moved once more, to its ray's origin. The large parts are subtracted first and
// the small ones added to the difference, so that two far things near each other keep their distance.
fn sphere_for(ray: Ray, id: u32) -> Sphere {
    let s = spheres[id];
    let shrink = 1.0 / s.scale; // a power of two
    let high = s.ball.xyz - shrink * given.origin.xyz;
    let p = high + (lows[id].ball.xyz - shrink * given.origin_low.xyz);
    let power = dot3(p, p) - s.ball.w * s.ball.w;
    return Sphere(vec4<f32>(p, s.ball.w), power, s.scale);
}
