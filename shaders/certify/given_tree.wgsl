// Given rays find their spheres in the tree.

@group(0) @binding(BIND_BOXES) var<storage, read> boxes: array<BoxRay>;

fn search(ray: CertifiedRay) -> Best {
    return search_tree(ray, boxes[ray_number]);
}

fn skips(place: u32) -> bool {
    return false;
}
