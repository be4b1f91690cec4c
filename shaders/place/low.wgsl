// The bound of all errors of a candidate's depth: the twin of LowTerms in src/certify/projection.rs.

fn low_blurred(rho: f32) -> f32 {
    return sqrt(placing.low_blurred.x + rho * (placing.low_blurred.y + rho * placing.low_blurred.z));
}

// `center` is the size of the depth relative to the reference, `coordinates` the sum of the sizes of x, y and z.
fn low_error(rho: f32, depth: f32, center: f32, coordinates: f32) -> f32 {
    let blurred = low_blurred(rho);
    let size = depth * placing.low_scale.x + placing.low_scale.y;
    let offset = placing.low_offset.x + rho * placing.low_offset.y + blurred * placing.low_offset.z;
    let error = size * offset + center * placing.low_center + coordinates * placing.low_coordinates;
    // The kernel takes the size from this bound, which makes it smaller by the error.
    let total = placing.low_total.x + rho * placing.low_total.y + blurred;
    return error / (1.0 - total * placing.low_scale.x) + FLUSHED;
}
