// The closest hit among all spheres, each loaded once per subgroup of any size and shared. Lanes past the end repeat
// the last sphere, which cannot win against itself.
fn nearest(ray: Ray) -> Hit {
    var hit = Hit(MISS, NONE);
    for (var first = 0u; first < view.spheres; first += lanes) {
        let mine = spheres[min(first + lane, view.spheres - 1u)];
        for (var k = 0u; k < lanes; k++) {
            let s = Sphere(subgroupShuffle(mine.ball, k), subgroupShuffle(mine.power, k), subgroupShuffle(mine.scale, k));
            hit = consider(hit, ray, s, first + k);
        }
    }
    return hit;
}
