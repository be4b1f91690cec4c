// The projection for the certified kernel; docs/certificate.md derives every bound that is used here.
// The direction is (x, y, -1), slopes instead of u, v, d, so that t is the planar depth.

struct Projection {
    slope: vec2<f32>, // vw / (2 W d), vh / (2 H d); 0 for parallel rays
    step: vec2<f32>, // a pixel's width and height in the unit of rho
    fixed: vec2<f32>, // width and height of a unit of the fixed-point projected centres
    shift: u32,      // a pixel is 2^shift of these units
    unit: f32,       // the unit of rho as a slope: a power of two; 0 for parallel rays
    errors: vec3<f32>, // error bound of a candidate's discriminant, by powers of rho
    edge: f32,       // error of a winner's projected centre, in the unit of rho
    depth: f32,      // the frame's reference depth: depths of projected spheres are relative to it
    tolerance: f32,  // promised relative error of t
    generals: u32,   // number of general spheres: not completely in front of the eye plane, or too near it
    cull_margin: f32, // relative depth behind the winner at which the rest of a list is skipped
    size: f32,       // length of the unit of rho at the reference depth; at any depth for parallel rays
}

// A projected sphere as every ray tests it: 16 bytes, because loads dominate the cost of a test.
struct Projected {
    x: i32,          // projected centre, fixed point: the difference to a pixel is exact at any distance
    y: i32,
    rho: f32,        // projected radius
    low: f32,        // centre's depth minus the reference depth, minus the bound of all errors of a hit's depth
}

// Data that is read only to certify a winner.
struct ProjectedDetail {
    subpixel_offset: vec2<f32>, // projected centre minus the nearest pixel, columns and rows (rows negated)
    center: f32,     // centre's depth minus the reference depth
    id: u32,
}

// Few buffers, because some adapters bind only ten. Vectors, because software adapters load a vector at once but a
// struct member by member.
@group(0) @binding(BIND_PROJECTION) var<uniform> projection: Projection;
@group(0) @binding(BIND_PROJECTED) var<storage, read> projected: array<vec4<i32>>;

fn projected_of(v: vec4<i32>) -> Projected {
    return Projected(v.x, v.y, bitcast<f32>(v.z), bitcast<f32>(v.w));
}

// The data of one ray: slopes, |d|^2 and its reciprocal, the pixel, and the pixel in fixed point.
struct Slopes {
    x: f32,
    y: f32,
    a: f32,
    inverse: f32,
    row: i32,
    column: i32,
    fixed_row: i32,
    fixed_column: i32,
    // Constants of every test: loaded once, because software adapters read a uniform lane by lane inside a loop.
    fixed: vec2<f32>,
    error: vec3<f32>,
    unit: f32,
    size: f32,
}

// A winner's answer. The depth is the centre's depth (0 for a general sphere) plus offset, between low and high.
struct Answer {
    sure: bool,      // hit, root, depth and normal are within their tolerances; the order of hits is not included
    hits: bool,      // the hit is certain, whether or not the rest is
    id: u32,
    offset: f32,
    low: f32,
    high: f32,
    depth_interval: f32, // bound of the error of the written depth
    normal: vec3<f32>,
    turn: f32,       // bound of the normal's error, in world space too; 0 where the eye is not outside of the sphere
}
