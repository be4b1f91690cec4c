// nearest/plain.wgsl in a better arithmetic.
fn nearest(ray: Ray) -> Hit {
    var hit = Hit(number(MISS), NONE);
    for (var id = 0u; id < view.spheres; id++) {
        hit = consider(hit, ray, spheres[id], lows[id], id);
    }
    return hit;
}
