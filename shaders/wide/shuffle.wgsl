// nearest/shuffle.wgsl in a better arithmetic: high and low parts are shared.
fn nearest(ray: Ray) -> Hit {
    var hit = Hit(number(MISS), NONE);
    for (var first = 0u; first < view.spheres; first += lanes) {
        let mine = min(first + lane, view.spheres - 1u);
        let s = spheres[mine];
        let low = lows[mine];
        for (var k = 0u; k < lanes; k++) {
            let other = Sphere(subgroupShuffle(s.ball, k), subgroupShuffle(s.power, k), subgroupShuffle(s.scale, k));
            let other_low = SphereLow(subgroupShuffle(low.ball, k), subgroupShuffle(low.power, k));
            hit = consider(hit, ray, other, other_low, first + k);
        }
    }
    return hit;
}
