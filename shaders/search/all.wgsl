// The closest hit among all spheres, in the order of their ids.
fn nearest(ray: Ray) -> Hit {
    var hit = no_hit();
    // Two a step: llvmpipe ends all loops of a shader after 65,536 steps, and there are up to 100,000 spheres. The last one may be
    // tested twice; it is not closer than itself.
    for (var n = 0u; n < view.spheres; n += 2u) {
        hit = closer_hit(hit, ray, n);
        hit = closer_hit(hit, ray, min(n + 1u, view.spheres - 1u));
    }
    return hit;
}
