// The closest hit among all spheres, each loaded by every invocation for itself: right on every adapter.
fn nearest(ray: Ray) -> Hit {
    var hit = Hit(MISS, NONE);
    for (var id = 0u; id < view.spheres; id++) {
        hit = consider(hit, ray, sphere_for(ray, id), id);
    }
    return hit;
}
