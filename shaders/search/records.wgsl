// A sphere's record, without residuals.
alias Record = SphereRecord;

fn record_at(n: u32) -> Record {
    return spheres[n];
}

fn residuals_of(r: Record) -> SphereResiduals {
    return SphereResiduals(vec4<f32>(0.0), 0.0);
}
