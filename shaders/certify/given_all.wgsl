// All spheres for every given ray.
fn search(ray: CertifiedRay) -> Best {
    var best = begin(ray);
    for (var place = 0u; place < view.spheres && best.limit >= 0.0; place++) {
        best = keep(best, ray, place, intersect(ray, 0.0, placed_at(place)));
    }
    return best;
}
