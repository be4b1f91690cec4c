// What the rays of a tile are asked by a form that runs alone: the near spheres, and the list of the tile.

// A sphere in a list: what Sphere holds, and whose it is. Closer hits are told from it, ties by its id.
struct Candidate {
    ball: vec4<f32>,
    power: f32,
    scale: f32,
    id: u32,
}

// Of vectors, since software adapters load a vector at once, a struct number by number; of bits, since ids that are
// taken for f32 are subnormal. The near spheres first, then the lists of the band; both in whole chunks.
@group(0) @binding(17) var<storage, read> candidates: array<vec4<u32>>;
// Of every tile of 8 x 8 pixels its first candidate and the one past its last; then for every CHUNK candidates the t
// beyond which neither they nor what is behind them in their list can be hit.
@group(0) @binding(12) var<storage, read> lists: array<u32>;

const CHUNK: u32 = 8u;

// The two vectors of a candidate.
struct Packed {
    ball: vec4<u32>,
    rest: vec4<u32>,
}

fn packed(n: u32) -> Packed {
    return Packed(candidates[2u * n], candidates[2u * n + 1u]);
}

fn candidate(p: Packed) -> Candidate {
    return Candidate(bitcast<vec4<f32>>(p.ball), bitcast<f32>(p.rest.x), bitcast<f32>(p.rest.y), p.rest.z);
}

fn sphere_of(c: Candidate) -> Sphere {
    return Sphere(c.ball, c.power, c.scale);
}

// The closest hit so far, and where in candidates it is.
struct Found {
    hit: Hit,
    place: u32,
}

// Invocations that load together leave the list together: those that could leave earlier keep what they have.
fn nearest_in(ray: Ray, range: vec2<u32>, limits: u32) -> Found {
    let nears = view.spheres;
    var found = Found(missed(), NONE);
    for (var n = 0u; n < nears + range.y - range.x; n += CHUNK) {
        let first = select(range.x + n - nears, n, n < nears);
        let behind = is_behind(found.hit, bitcast<f32>(lists[limits + first / CHUNK]));
        if (all_of_us(behind)) {
            break;
        }
        let more = ask(ray, found, first);
        if (!behind) {
            found = more;
        }
    }
    return found;
}
