// Records are taken as exact.
fn residuals_of(id: u32) -> SphereResiduals {
    return SphereResiduals(vec4<f32>(0.0), 0.0);
}
