// Both roots of a sphere, by depths relative to the reference, with bounds; planes may leave either.
struct Roots {
    near: vec2<f32>,
    far: vec2<f32>,
    hits: bool,   // the ray certainly hits, and in front of the eye
    misses: bool, // or it certainly misses
    inside: bool, // the eye may be inside or on the surface: what the ray hits first is the far root
}

fn projected_roots(s: Slopes, f: Projected, more: ProjectedDetail) -> Roots {
    let n = projected_solved(s, f, more);
    let high = more.center - (n.along + n.least) * n.length + n.blur;
    let far = vec2<f32>(more.center - (n.along - n.least) * n.length - n.blur, more.center - (n.along - n.most) * n.length + n.blur);
    // Under parallel projection, a sphere that may intersect the eye plane has no depth.
    let has_depth = projection.depth + more.center > 0.0;
    return Roots(vec2<f32>(n.low, high), vec2<f32>(far.x, select(BEYOND, far.y, has_depth)), n.hits, n.disc < -n.error, false);
}
