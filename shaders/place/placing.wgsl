// The numbers from which spheres are placed in the image: the camera in f64, and the constants of the host's bounds.

struct Placing {
    eye: array<vec4<u32>, 3>,       // numbers of f64 as in float64.wgsl
    axes: array<vec4<u32>, 9>,      // right, up and forward over the frame's unit
    per_slope: array<vec4<u32>, 2>, // pixels per unit of slope
    middle: array<vec4<u32>, 2>,    // (W - 1) / 2 and (H - 1) / 2
    reference: vec4<u32>,           // the reference depth
    // The host's LowTerms: place/low.wgsl.
    low_blurred: vec3<f32>,
    low_center: f32,
    low_offset: vec3<f32>,
    low_coordinates: f32,
    low_total: vec2<f32>,
    low_scale: vec2<f32>,
    per_step: vec2<f32>,            // pixels per unit of rho
    slope: vec2<f32>,               // a pixel's width and height as slopes; 0 for parallel rays
    edge: vec2<f32>,                // the largest slopes of the image
    reach: vec2<f32>,               // offset beyond which a miss is certain: constant, by rho
    per_slope_f32: vec2<f32>,
    middle_f32: vec2<f32>,
    corner: vec2<f32>,              // the image's first column and row in the frame, and one past the last
    end: vec2<f32>,
    rotated: f32,                   // error of a coordinate per |c - e|_1 in the frame's unit
    wider: f32,                     // added to rho for a rectangle, in the unit of rho
    farthest: f32,                  // pixels beyond which there is no fixed point
    per_unit: i32,                  // exponent of the unit of rho, negated
    to_frame: i32,                  // exponent of the frame's unit, negated
    shift: u32,                     // a pixel is 2^shift units of fixed point
    fine: u32,                      // pixels of the frame along a side of the image's
    parallel: u32,
    columns: u32,                   // of the image
    rows: u32,
    narrow: u32,                    // 1 where a sphere may be aside
    unused_a: u32,
}

// Not in a uniform: lavapipe compiles a shader anew for the values of uniforms that decide its branches alone.
@group(0) @binding(BIND_PLACING) var<storage, read> placing: Placing;

// A block of spheres in one dispatch.
struct BlockPass {
    first: u32,  // slot of its first sphere; its slots are the ids, but for those that the host placed
    count: u32,
    mode: u32,   // of shaders/splat
    pieces: u32, // of large spheres
    groups: u32, // workgroups in a row of the dispatch
    unused_a: u32,
    unused_b: u32,
    unused_c: u32,
}

@group(0) @binding(BIND_BLOCK_PASS) var<uniform> block_pass: BlockPass;

// The results of placing a frame, over all of its blocks. SUMMARY_DEPTHS: least and largest depth of the spheres whose
// rectangle certainly contains a pixel, as bits of f32. SUMMARY_PERHAPS: the same of the spheres for which f32 cannot
// tell that. Then the numbers of spheres for the host, of pieces of large spheres and of pairs of unsure pixels.
// SUMMARY_MORE: above 0 where the pieces are too many to be counted. SUMMARY_MISSED: the least slot of the spheres aside. Then the
// slots of the spheres for the host.
@group(0) @binding(BIND_SUMMARY) var<storage, read_write> summary: array<atomic<u32>>;

// The number of an invocation in the block.
fn place_in_block(group: vec3<u32>, index: u32) -> u32 {
    return (group.y * block_pass.groups + group.x) * GROUP + index;
}

// Whether a sphere is cut into pieces, which the sign of rho tells. Rectangles are computed in f32, whose last bits may
// differ from kernel to kernel, so one kernel alone decides.
fn is_cut(record: vec4<i32>) -> bool {
    return record.z < 0;
}

fn uncut(record: vec4<i32>) -> vec4<i32> {
    return vec4<i32>(record.xy, record.z & 0x7fffffff, record.w);
}
