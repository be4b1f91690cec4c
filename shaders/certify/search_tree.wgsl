// The spheres that a ray may hit, from the tree.
fn search_tree(ray: CertifiedRay, seen: BoxRay) -> Best {
    let spheres_level = level_of_spheres();
    var best = begin(ray);
    var at = Position(0u, 0u, 0u);
    loop {
        while (at.level < spheres_level) {
            at = descend(at, seen, best.limit);
        }
        if (at.level == NOWHERE) {
            break;
        }
        if (!skips(at.place)) {
            best = keep(best, ray, at.place, meet(ray, placed_at(at.place)));
        }
        at = resume(at, best.limit);
    }
    return best;
}
