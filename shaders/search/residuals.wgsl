// The rounding errors of records: for arithmetic of more bits than f32, and for rays from many points.
@group(0) @binding(BIND_RESIDUALS) var<storage, read> residuals: array<SphereResiduals>;

fn residuals_of(id: u32) -> SphereResiduals {
    return residuals[id];
}
