// Planes that cut spheres: the part of a ray that they keep, and the hits there. Depths are relative to the reference;
// docs/certificate.md, section 9a.

// First column and row of the middle pixel, the bits of a bound of the distance of every point of a cut sphere from the reference
// depth, and the number of planes. Then three vectors for each plane. Then the cut spheres, four in a vector, by rank.
@group(0) @binding(BIND_PLANES) var<storage, read> planes: array<vec4<i32>>;

const HOLDS_EYE: u32 = 1u;
const OUT_OF_RANGE: u32 = 2u;

// A plane N.p = D, whose depth is a numerator over a denominator, both linear in the pixel.
struct Plane {
    num: vec4<f32>,  // at the middle pixel, per column, per row; and a bound of the host's error
    den: vec4<f32>,
    normal: vec3<f32>, // N / |N| to the right, up and back
    state: u32,
}

fn plane_at(n: u32) -> Plane {
    let at = 1u + 3u * n;
    let last = planes[at + 2u];
    return Plane(
        bitcast<vec4<f32>>(planes[at]), bitcast<vec4<f32>>(planes[at + 1u]), bitcast<vec3<f32>>(last.xyz), bitcast<u32>(last.w),
    );
}

// The id of the cut sphere of a rank, from 1 on.
fn sphere_of_rank(rank: u32) -> u32 {
    let n = rank - 1u;
    return bitcast<u32>(planes[1u + 3u * u32(planes[0].w) + n / 4u][n % 4u]);
}

// The part of a ray that planes keep.
struct Kept {
    entry: vec2<f32>, // bounds of the depth where it begins
    exit: vec2<f32>,  // and where it ends
    plane: u32,       // through which it enters; NONE where it begins at the eye
    is_empty: bool,   // the planes certainly keep nothing of it
    is_unknown: bool, // the bounds do not tell through which plane it enters, or whether it leaves
}

// A sum that is linear in the pixel, and a bound of its error.
fn linear(v: vec4<f32>, pixels: vec2<f32>) -> vec2<f32> {
    let right = pixels.x * v.y;
    let down = pixels.y * v.z;
    let sizes = START * abs(v.x) + STEP * (abs(right) + abs(down));
    return vec2<f32>(v.x + right + down, (UNIT * sizes + v.w + VANISH) * INFLATE);
}

// The part that one more plane, with this number, keeps of a ray.
fn cut_by(kept: Kept, s: Slopes, plane: Plane, n: u32, reach: f32) -> Kept {
    let pixels = vec2<f32>(vec2<i32>(s.column, s.row) - planes[0].xy);
    let num = linear(plane.num, pixels);
    let den = linear(plane.den, pixels);
    let size = abs(num.x);
    let width = abs(den.x);
    // A plane that no part of the ray within reach of the spheres passes.
    let far = (width + den.y) * reach * INFLATE < size - num.y;
    let clear = !far && den.y + den.y < width;
    let at = num.x / select(1.0, den.x, clear);
    let error = ((num.y + abs(at) * den.y) / select(1.0, width - den.y, clear) + UNIT * PLANE_QUOTIENT * abs(at) + VANISH) * INFLATE;
    let place = vec2<f32>(at - error, at + error);
    let leaves = clear && 0.0 < den.x;
    let enters = clear && den.x < 0.0;
    // Behind the eye, or through it.
    let behind = place.y < -projection.depth || (plane.state & HOLDS_EYE) != 0u;
    let ahead = enters && !behind;
    let later = ahead && kept.entry.y < place.x;
    let sooner = ahead && place.y < kept.entry.x;
    let doubtful = (ahead && !later && !sooner) || !(far || clear) || (plane.state & OUT_OF_RANGE) != 0u;
    return Kept(
        select(kept.entry, place, vec2<bool>(ahead) & (kept.entry < place)),
        select(kept.exit, place, vec2<bool>(leaves) & (place < kept.exit)),
        select(kept.plane, n, later),
        kept.is_empty || (far && num.x < 0.0) || (leaves && behind),
        kept.is_unknown || doubtful,
    );
}

fn kept_of(s: Slopes) -> Kept {
    var kept = Kept(vec2<f32>(-projection.depth), vec2<f32>(BEYOND), NONE, false, false);
    let reach = bitcast<f32>(planes[0].z);
    let count = u32(planes[0].w);
    for (var n = 0u; n < count; n++) {
        kept = cut_by(kept, s, plane_at(n), n, reach);
    }
    return kept;
}

// The hit of a cut sphere within what planes keep of a ray.
struct CutHit {
    low: f32,      // a lower bound of its depth, or MISS for a certain miss
    at_root: bool, // it is certainly hit at its near root, from inside at its far one
    at_face: bool, // it is certainly hit at its face, between the bounds of the part's begin
}

fn cut_hit(kept: Kept, roots: Roots) -> CutHit {
    // From inside, a ray that no plane lets in hits the far root.
    let from_inside = roots.inside && kept.plane == NONE && !kept.is_unknown;
    let first = select(roots.near, roots.far, from_inside);
    let gone = roots.misses || kept.is_empty || kept.exit.y < kept.entry.x || roots.far.y < kept.entry.x
        || kept.exit.y < first.x;
    let known = roots.hits && !kept.is_unknown && !gone;
    let low = select(first.x, kept.entry.x, first.x < kept.entry.x);
    return CutHit(
        select(low, MISS, gone),
        known && kept.entry.y < first.x && first.y < kept.exit.x,
        known && kept.plane != NONE && roots.near.y < kept.entry.x && kept.entry.y < roots.far.x
            && kept.entry.y < kept.exit.x,
    );
}

// The rank of a sphere of the block, behind the depths of all; 0 for a whole one.
fn rank_of(slot: u32) -> u32 {
    let n = slot - block_pass.first;
    return bitcast<u32>(projected[2u * block_pass.count + (block_pass.count + 1u) / 2u + n / 4u][n % 4u]);
}
