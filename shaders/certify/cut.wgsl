// Planes cut spheres of the frame: a ray begins at a plane, on the face of the sphere of the least rank.

const FACE: u32 = 0xc0000000u; // in place of a slot

var<private> kept: Kept;
var<private> face: u32; // the least rank of a certain face; NONE where there is none

fn begin_solids(s: Slopes, pixel: u32, pixels: u32) {
    kept = kept_of(s);
    face = ~minima[3u * pixels + pixel];
}

fn with_face(k: NearestTwo) -> NearestTwo {
    if (face == NONE) {
        return k;
    }
    return with_candidate(k, kept.entry.x, FACE);
}

fn face_answer() -> Answer {
    let low = kept.entry.x;
    let high = kept.entry.y;
    // Half of the width, and the rounding of the middle, which is less than the other half.
    let depth_interval = (high - low) * INFLATE;
    let normal = plane_at(kept.plane).normal;
    return Answer(true, true, sphere_of_rank(face), 0.5 * low + 0.5 * high, low, high, depth_interval, normal, 0.0);
}

// The answer of the winner, which is sure where planes certainly leave the root that it is.
fn certify_solid(s: Slopes, k: NearestTwo) -> Answer {
    if (k.slot == FACE) {
        return face_answer();
    }
    var answer = certify_winner(s, k);
    if (k.slot == NONE) {
        return answer;
    }
    var stays = true;
    if ((k.slot & GENERAL) != 0u) {
        stays = keeps_general(s, k.slot & ~GENERAL);
    } else if (rank_of(k.slot) != 0u) {
        stays = cut_hit(kept, projected_roots(s, winner_record(k.slot), projected_detail(k.slot))).at_root;
    }
    answer.sure = answer.sure && stays;
    answer.hits = answer.hits && stays;
    return answer;
}

// The reference depth, to which the depth of a face is relative, as the bits of an f64.
fn depth_of_face(slot: u32) -> vec2<u32> {
    let bits = bitcast<u32>(projection.depth);
    return select(vec2<u32>(0u, 0u), vec2<u32>(bits << 29u, (bits >> 3u) + 0x38000000u), slot == FACE && bits != 0u);
}
