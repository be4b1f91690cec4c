// All rays start at the origin of the canonical camera, so spheres are used as the host transformed them.
fn sphere_of(id: u32) -> Sphere {
    let r = spheres[id];
    let residual = residuals_of(id);
    let c = r.center_radius;
    let c_lo = residual.center_radius;
    let center = Number3(from_hi_lo(c.x, c_lo.x), from_hi_lo(c.y, c_lo.y), from_hi_lo(c.z, c_lo.z));
    return Sphere(center, from_hi_lo(c.w, c_lo.w), from_hi_lo(r.power, residual.power), r.scale);
}
