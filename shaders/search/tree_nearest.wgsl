// The closest hit among the spheres of a tree. The nearest box is visited first, and boxes behind the current hit are
// skipped. A box as near as the hit is still visited, because it may contain a lower id.
fn nearest(ray: Ray, group: vec3<u32>) -> Hit {
    let seen = boxes[ray_number];
    let spheres_level = level_of_spheres();
    var found = Found(no_hit(), NONE);
    var limit = MISS;
    var at = Position(0u, 0u, 0u);
    loop {
        while (at.level < spheres_level) {
            at = descend(at, seen, limit);
        }
        if (at.level == NOWHERE) {
            break;
        }
        found = test(ray, found, load(at.place), at.place);
        limit = select(MISS, to_hi(found.hit.t) * seen.leave.w - seen.enter.w, found.hit.id != NONE);
        at = resume(at, limit);
    }
    place = found.place;
    return found.hit;
}
