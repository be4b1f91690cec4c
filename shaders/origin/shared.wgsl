// All rays leave from the origin of the canonical camera: the spheres are where the host moved them.
fn sphere_for(ray: Ray, id: u32) -> Sphere {
    return spheres[id];
}
