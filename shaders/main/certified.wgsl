// The certified kernel, once per pixel: slopes, candidates, the winner's certificate, outputs.

const UNSURE: u32 = 0xfffffffeu; // the id where f32 cannot prove the answer; the host settles the pixel

var<private> answer: Answer;
var<private> proved: bool;

// Unit normal at the hit, in the canonical camera, facing the eye.
fn surface_normal(ray: Ray, hit: Hit) -> vec3<f32> {
    return answer.normal;
}

fn written_id(hit: Hit) -> u32 {
    return select(UNSURE, hit.id, proved);
}

fn render(tile: vec3<u32>, index: u32) {
    let at = pixel_at(tile, index);
    let to = sample_position(at);
    let s = slopes(to.y, to.x);
    let k = nearest_two(s, tile);
    // Invocations outside the crop leave only now, because they loaded spheres for their subgroup.
    if (!in_crop(at)) {
        return;
    }
    answer = certify_winner(s, k);
    proved = k.slot == NONE || certain(answer, k);
    write_outputs(pixel_index(at), Ray(vec3<f32>(s.x, s.y, -1.0)), Hit(answer.offset, answer.id));
}
