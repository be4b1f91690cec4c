// A sphere's record, with its residuals: for arithmetic of more bits than f32 and for
// rays from many points.
struct Record {
    center_radius: vec4<f32>,
    power: f32,
    scale: f32,
    id: u32,
    center_radius_residual: vec4<f32>,
    power_residual: f32,
}

@group(0) @binding(BIND_RESIDUALS) var<storage, read> residuals: array<SphereResiduals>;

fn record_at(n: u32) -> Record {
    let s = spheres[n];
    let residual = residuals[n];
    return Record(s.center_radius, s.power, s.scale, s.id, residual.center_radius, residual.power);
}

fn residuals_of(r: Record) -> SphereResiduals {
    return SphereResiduals(r.center_radius_residual, r.power_residual);
}
