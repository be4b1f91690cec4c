// The data's way, once per pixel, with a certificate: slopes, candidates, the winner's judgement, colour, frame.

const UNSURE: u32 = 0xfffffffeu; // the id where f32 cannot prove the answer: the host decides

var<private> certified_normal: vec3<f32>;

// Unit normal at the hit just judged, in the canonical camera, against the ray.
fn surface_normal(ray: Ray, hit: Hit) -> vec3<f32> {
    return certified_normal;
}

fn render(tile: vec3<u32>, index: u32) {
    let at = pixel_at(tile, index);
    let to = aim(at);
    let s = slopes(to.y, to.x);
    let list = 2u * (tile.y * tile_columns() + tile.x);
    let k = candidates(s, vec2<u32>(lists[list], lists[list + 1u]));
    // Only now may invocations outside the window leave: they carried spheres for their subgroup.
    if (!is_shown(at)) {
        return;
    }
    let pixel = place_of(at);
    let answer = judge(s, k);
    let hit = Hit(answer.offset, answer.id);
    certified_normal = answer.normal;
    let ray = Ray(vec3<f32>(s.x, s.y, -1.0));
    let proved = k.slot == NONE || certain(answer, k);
    write_id(pixel, Hit(answer.offset, select(UNSURE, answer.id, proved)));
    write_t(pixel, hit);
    write_width(pixel, answer.width);
    write_normal(pixel, ray, hit);
    write_color(pixel, ray, hit);
}
