// The spheres that a given ray may hit, from the tree.

@group(0) @binding(BIND_BOXES) var<storage, read> boxes: array<BoxRay>;

fn search(ray: CertifiedRay) -> Best {
    let box_ray = boxes[ray_number];
    let spheres_level = level_of_spheres();
    var best = begin(ray);
    var at = Position(0u, 0u, 0u);
    var steps = 0u;
    loop {
        while (at.level < spheres_level && steps < STEPS) {
            at = descend(at, box_ray, best.limit);
            steps++;
        }
        steps++;
        if (steps > STEPS) {
            return undecided();
        }
        if (at.level == NOWHERE) {
            break;
        }
        best = keep(best, ray, at.place, intersect(ray, 0.0, placed_at(at.place)));
        at = resume(at, best.limit);
    }
    return best;
}
