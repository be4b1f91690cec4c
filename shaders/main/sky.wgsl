// Rays from the hits of a frame toward the sky and toward lights that are infinitely far, one per invocation:
// docs/certificate.md, section 13. Each leaves a bit if nothing hides what it goes to. Where f32 leaves one ray of a pixel
// unsure, one more bit leaves all of them to the host.

struct Sky {
    first: u32,        // pixel of the band, and one past the last
    end: u32,
    rays: u32,         // of each pixel toward the sky
    lights: u32,       // and toward far lights
    turns: u32,        // of the directions toward the sky, a power of two
    seed: u32,
    chessboard: u32,   // 1: only from every second pixel
    groups: u32,       // workgroups in a row of the dispatch
    sure_limit: f32,   // of rays toward the sky
    limit: f32,
    unused_a: u32,
    unused_b: u32,
}

@group(0) @binding(BIND_SKY) var<uniform> sky: Sky;
@group(0) @binding(BIND_FRAME_ID) var<storage, read> frame_id: array<u32>;
@group(0) @binding(BIND_STARTS) var<storage, read> starts: array<vec4<f32>>;
// The place of every sphere in the order of the tree.
@group(0) @binding(BIND_PLACES) var<storage, read> places: array<u32>;
// Two vectors each, the direction and the reciprocals of its components: those of all turns, then those of the lights.
@group(0) @binding(BIND_DIRECTIONS) var<storage, read> directions: array<vec4<f32>>;
@group(0) @binding(BIND_OPEN) var<storage, read_write> open: array<atomic<u32>>;

var<private> local_index: u32; // of this ray in its workgroup
var<private> own: u32;         // place of the sphere that it leaves from

// The sphere of the hit is decided by the side of its surface.
fn skips(place: u32) -> bool {
    return place == own;
}

// The padding of boxes for a start that was computed in f32, beside its blur: docs/tree.md.
const PAD: f32 = 32.0;
// The error of two places on the grid, 2^-47.
const PLACES: f32 = 7.105427357601002e-15;
// The product of normal and direction, in multiples of UNIT.
const COSINE: f32 = 8.0;

// The place of what hides the end of ray `number` of a pixel, NONE or UNSURE.
fn hider(start: vec4<f32>, at: vec2<u32>, number: u32) -> u32 {
    let toward_sky = number < sky.rays;
    let turn = pcg4d(vec4<u32>(at, 0u, sky.seed)).w & (sky.turns - 1u);
    let index = select(sky.turns * sky.rays + number - sky.rays, turn * sky.rays + number, toward_sky);
    var d = directions[2u * index].xyz;
    var inverse = directions[2u * index + 1u].xyz;
    let cosine = dot3(start.xyz, d);
    if (abs(cosine) <= (start.w + COSINE * UNIT) * sqrt(dot3(d, d)) * INFLATE) {
        return UNSURE;
    }
    if (cosine < 0.0) {
        if (!toward_sky) {
            return own;
        }
        d = -d;
        inverse = -inverse;
    }
    let s = placed_at(own);
    let offset = s.rest + s.radius * start.xyz;
    let blur = (s.radius * start.w + PLACES) * INFLATE;
    let ray = CertifiedRay(
        s.steps, select(MISS, sky.sure_limit, toward_sky), offset, select(MISS, sky.limit, toward_sky), d, blur,
    );
    let origin = vec3<f32>(s.steps) * GIVEN_STEP + offset;
    let aside = select(vec3<f32>(1.0), vec3<f32>(-1.0), inverse < vec3<f32>(0.0)) * (PAD * UNIT + 2.0 * blur);
    let seen = BoxRay(vec4<f32>(origin + aside, 0.0), vec4<f32>(origin - aside, 0.0), vec4<f32>(inverse, 0.0));
    return answer(search_tree(ray, seen));
}

@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let each = sky.rays + sky.lights;
    let n = (group.y * sky.groups + group.x) * GROUP + index;
    let pixel = sky.first + n / each;
    if (pixel >= sky.end) {
        return;
    }
    let number = n % each;
    let id = frame_id[pixel];
    let at = vec2<u32>(view.first_column + pixel % view.columns, view.first_row + pixel / view.columns);
    if (id == NONE || (sky.chessboard == 1u && ((at.x ^ at.y) & 1u) == 1u)) {
        return;
    }
    let start = starts[pixel];
    local_index = index;
    var found = UNSURE;
    if (id != UNSURE && start.w > 0.0) {
        own = places[id];
        found = hider(start, at, number);
    }
    let bit = select(number, each, found == UNSURE);
    if (found == NONE || found == UNSURE) {
        atomicOr(&open[pixel * ((each >> 5u) + 1u) + (bit >> 5u)], 1u << (bit & 31u));
    }
}
