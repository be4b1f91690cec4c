// Rays from many points: each sphere is translated by the ray's origin.
fn sphere_of(id: u32) -> Sphere {
    let r = spheres[id];
    // A power of two over another: a quotient may be off by 2.5 ulp.
    let shrink = bitcast<f32>(0x7f000000u - bitcast<u32>(r.scale));
    let c = r.center_radius;
    let c_lo = residuals_of(id).center_radius;
    let o = given.origin;
    let o_lo = given.origin_low;
    let center = Number3(
        difference(c.x, c_lo.x, o.x, o_lo.x, shrink),
        difference(c.y, c_lo.y, o.y, o_lo.y, shrink),
        difference(c.z, c_lo.z, o.z, o_lo.z, shrink),
    );
    let radius = from_hi_lo(c.w, c_lo.w);
    let power = sub(number_dot3(center, center), mul(radius, radius));
    return Sphere(center, radius, power, r.scale);
}
