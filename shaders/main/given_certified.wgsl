// Certified answers of given rays, one ray per invocation: the sphere that is hit. The host computes t and the normal.

@group(0) @binding(BIND_CERTIFIED_RAYS) var<storage, read> certified_rays: array<CertifiedRay>;

var<private> ray_number: u32;
var<private> local_index: u32; // of this ray in its workgroup

fn written_id(hit: Hit) -> u32 {
    return hit.id;
}

// Here view.width is the number of rays of this dispatch, and view.first_row the number of rays before it.
@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let n = group.x * GROUP + index;
    local_index = index;
    ray_number = view.first_row + min(n, view.width - 1u);
    let found = answer(search(certified_rays[ray_number]));
    if (n < view.width) {
        write_outputs(n, Ray(vec3<f32>(0.0)), Hit(0.0, found));
    }
}
