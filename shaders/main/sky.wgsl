// Rays from the hits of a frame toward the sky and toward lights without a size: docs/certificate.md, section 13. A ray
// sets its bit if nothing hides its target. If f32 leaves one ray of a pixel unsure, one more bit is set, which leaves
// all rays of the pixel to the host.

@group(0) @binding(BIND_FRAME_ID) var<storage, read> frame_id: array<u32>;
@group(0) @binding(BIND_STARTS) var<storage, read> starts: array<vec4<f32>>;
// The place of every sphere in the order of the tree.
@group(0) @binding(BIND_PLACES) var<storage, read> places: array<u32>;
var<private> local_index: u32; // of this pixel in its workgroup
var<private> own: u32;         // place of the sphere of the hit, which is decided by the side of its surface

// The padding of boxes for a start that was computed in f32, beside its blur: docs/certificate.md, section 13.
const PAD: f32 = 40.0;
// The smallest component of a direction for the boxes, 2^-32, as of the host.
const LEAST: f32 = 2.3283064365386963e-10;
// The error of two places on the grid, 2^-47.
const PLACES: f32 = 7.105427357601002e-15;
// Least bound of a start's error, relative to the radius, 2^-45: so f64 decides what f32 decides.
const BLURRED: f32 = 2.842170943040401e-14;
// Error of the product of normal and direction, in multiples of UNIT.
const COSINE: f32 = 8.0;
// Error of the way to a light, in multiples of UNIT and of its length and the lengths of the places that it is made of.
const AIM: f32 = 4.0;
// Bound of a direction's relative error, 2^-12: with a larger one the ray is unsure.
const MAX_TILT: f32 = 2.44140625e-4;

// The start of all rays of a pixel.
struct Start {
    at: vec2<u32>,     // column and row in the full frame
    normal: vec3<f32>,
    turn: f32,         // bound of the normal's error
    steps: vec3<i32>,  // of the sphere's centre on the grid of places, or of the eye
    offset: vec3<f32>, // from there
    blur: f32,
    origin: vec3<f32>, // the same place in f32, for the boxes
}

// A ray of a pixel, and the part of its answer that needs no tree.
struct Next {
    ray: CertifiedRay,
    tilt: f32,         // bound of its direction's error, relative to its length
    box_ray: BoxRay,
    found: u32,        // own: the sphere itself hides it; UNSURE: the side of its surface is not known; else NONE
}

fn start_of(pixel: u32, at: vec2<u32>) -> Start {
    let surface = starts[2u * pixel];
    let way = starts[2u * pixel + 1u];
    let s = placed_at(own);
    var steps = s.steps;
    var offset = s.rest + s.radius * surface.xyz;
    var blur = s.radius * surface.w;
    // A sphere that is large beside its distance: the ground.
    if (sky.unit > 0.0 && way.w * sky.unit < blur) {
        steps = sky.eye;
        offset = sky.eye_rest + sky.unit * way.xyz;
        blur = way.w * sky.unit;
    }
    // No compiler may take the sum apart: others rely on its rounding.
    offset = bitcast<vec3<f32>>(bitcast<vec3<u32>>(offset) ^ vec3<u32>(view.zero));
    blur = (max(blur, BLURRED * s.radius) + PLACES) * INFLATE;
    return Start(at, surface.xyz, surface.w, steps, offset, blur, vec3<f32>(steps) * GIVEN_STEP + offset);
}

fn next_ray(start: Start, number: u32) -> Next {
    let toward_sky = number < sky.rays;
    let index = select(sky.turns * sky.rays + number - sky.rays, turn_of(start.at) * sky.rays + number, toward_sky);
    let first = directions[2u * index];
    let second = bitcast<vec3<f32>>(directions[2u * index + 1u].xyz);
    var d = bitcast<vec3<f32>>(first.xyz);
    var inverse = second;
    var tilt = 0.0;
    var limit = select(vec2<f32>(MISS), vec2<f32>(sky.sure_limit, sky.limit), toward_sky);
    if (first.w == 1u) {
        // The way to a light, scaled by a power of two: its largest component is then in [1, 2), and the light at the scale.
        let rest = second - start.offset;
        let way = vec3<f32>(bitcast<vec3<i32>>(first.xyz) - start.steps) * GIVEN_STEP + rest;
        let length = sqrt(dot3(way, way));
        let doubt = AIM * UNIT * (length + sqrt(dot3(rest, rest)) + sqrt(dot3(second, second))) + start.blur;
        // 1, so unsure, where the error is too large.
        tilt = select(1.0, doubt / length * INFLATE, doubt < MAX_TILT * length);
        let size = abs(way);
        let scale = bitcast<u32>(max(max(size.x, size.y), size.z)) & 0x7f800000u;
        d = way * bitcast<f32>(0x7f000000u - scale);
        limit = vec2<f32>(bitcast<f32>(scale));
        inverse = 1.0 / select(d, select(vec3<f32>(LEAST), vec3<f32>(-LEAST), d < vec3<f32>(0.0)), abs(d) < vec3<f32>(LEAST));
    }
    let cosine = dot3(start.normal, d);
    let behind = cosine < 0.0;
    var found = select(NONE, own, behind && !toward_sky);
    let is_known = tilt < 1.0 && abs(cosine) > (start.turn + tilt + COSINE * UNIT) * sqrt(dot3(d, d)) * INFLATE;
    if (!is_known) {
        found = UNSURE;
    }
    if (behind) {
        d = -d;
        inverse = -inverse;
    }
    let pad = PAD * UNIT + 2.0 * start.blur + 9.0 * tilt;
    let signed_pad = select(vec3<f32>(pad), vec3<f32>(-pad), inverse < vec3<f32>(0.0));
    return Next(
        CertifiedRay(start.steps, limit.x, start.offset, limit.y, d, start.blur), tilt,
        BoxRay(vec4<f32>(start.origin + signed_pad, 0.0), vec4<f32>(start.origin - signed_pad, 0.0), vec4<f32>(inverse, 0.0)),
        found,
    );
}

// An invocation traces all rays of a pixel. The invocations of a subgroup begin their next rays on their own, so that none
// waits for the longest ray of the others.
@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let each = sky.rays + sky.lights;
    let pixel = sky.first + (group.y * sky.groups + group.x) * GROUP + index;
    if (pixel >= sky.end) {
        return;
    }
    let id = frame_id[pixel];
    let at = vec2<u32>(view.first_column + pixel % view.columns, view.first_row + pixel / view.columns);
    if (id == NONE) {
        return;
    }
    let words = pixel * ((each >> 5u) + 1u);
    if (((open[words + (each >> 5u)] >> (each & 31u)) & 1u) == 1u) {
        return;
    }
    var unsure = id == UNSURE || starts[2u * pixel].w <= 0.0;
    if (!unsure) {
        own = places[id];
        local_index = index;
        let start = start_of(pixel, at);
        let spheres_level = level_of_spheres();
        var next = next_ray(start, sky.first_ray);
        var best = begin(next.ray);
        var position = Position(select(NOWHERE, 0u, next.found == NONE), 0u, 0u);
        var number = sky.first_ray;
        var bits = 0u;
        var steps = 0u;
        loop {
            while (position.level < spheres_level && steps < sky.steps) {
                position = descend(position, next.box_ray, best.limit);
                steps++;
            }
            steps++;
            if (steps > sky.steps) {
                unsure = true;
                break;
            }
            if (position.level != NOWHERE) {
                if (position.place != own) {
                    best = keep(best, next.ray, position.place, intersect(next.ray, next.tilt, placed_at(position.place)));
                }
                position = resume(position, best.limit);
            }
            if (position.level == NOWHERE) {
                let found = select(next.found, answer(best), next.found == NONE);
                unsure = found == UNSURE;
                bits |= select(0u, 1u, found == NONE) << (number & 31u);
                number++;
                if (unsure || number == sky.end_ray) {
                    break;
                }
                if ((number & 31u) == 0u) {
                    open[words + (number >> 5u) - 1u] |= bits;
                    bits = 0u;
                }
                next = next_ray(start, number);
                best = begin(next.ray);
                position = Position(select(NOWHERE, 0u, next.found == NONE), 0u, 0u);
            }
        }
        open[words + ((max(number, 1u) - 1u) >> 5u)] |= bits;
    }
    if (unsure) {
        open[words + (each >> 5u)] |= 1u << (each & 31u);
    }
}
