// The closest hit among all spheres, each loaded once per subgroup of 4 and shared. Lanes past the end repeat the last
// sphere, which cannot win against itself. A broadcast takes constant lanes only, hence the 4 lines.
fn nearest(ray: Ray) -> Hit {
    var hit = Hit(MISS, NONE);
    for (var first = 0u; first < view.spheres; first += 4u) {
        let mine = spheres[min(first + lane, view.spheres - 1u)];
        hit = consider(hit, ray, Sphere(subgroupBroadcast(mine.ball, 0u), subgroupBroadcast(mine.power, 0u), subgroupBroadcast(mine.scale, 0u)), first + 0u);
        hit = consider(hit, ray, Sphere(subgroupBroadcast(mine.ball, 1u), subgroupBroadcast(mine.power, 1u), subgroupBroadcast(mine.scale, 1u)), first + 1u);
        hit = consider(hit, ray, Sphere(subgroupBroadcast(mine.ball, 2u), subgroupBroadcast(mine.power, 2u), subgroupBroadcast(mine.scale, 2u)), first + 2u);
        hit = consider(hit, ray, Sphere(subgroupBroadcast(mine.ball, 3u), subgroupBroadcast(mine.power, 3u), subgroupBroadcast(mine.scale, 3u)), first + 3u);
    }
    return hit;
}
