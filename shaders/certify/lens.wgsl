// The certified kernel's view of the scene: docs/certificate.md derives every bound that is used here.
// The direction is (x, y, -1): slopes instead of u, v, d, so that t is the planar depth.

struct Lens {
    slope_x: f32,    // vw / (2 W d); 0 for parallel rays
    slope_y: f32,    // vh / (2 H d); 0
    step_x: f32,     // a pixel's width and height in the unit of rho
    step_y: f32,
    fixed_x: f32,    // the same of a unit of the fixed-point projected centres
    fixed_y: f32,
    shift: u32,      // a pixel is 2^shift of these
    unit: f32,       // slope of the unit of rho: a power of two; 0 for parallel rays
    error0: f32,     // bound of a candidate's discriminant: error0 + rho (error1 + rho error2)
    error1: f32,
    error2: f32,
    edge: f32,       // error of a winner's projected centre, unit of rho
    depth: f32,      // the frame's reference depth: depths of front spheres are kept relative to it
    tolerance: f32,  // promised relative error of t
    nears: u32,      // spheres that are not wholly in front of the eye plane, or too near it
    slack: f32,      // how far behind a winner, relative to its depth, a list may be left
    size: f32,       // length of the unit of rho at the reference depth; at any for parallel rays
}

// A sphere wholly in front, as every ray sees it: 16 bytes, since loading is what a test costs.
struct Front {
    x: i32,          // projected centre, fixed point: the difference to a pixel is exact, however far the sphere
    y: i32,
    rho: f32,        // projected radius
    low: f32,        // centre's depth minus the reference, minus the bound of all errors of a hit's depth
}

// What only a winner is asked.
struct FrontMore {
    rest: vec2<f32>, // projected centre minus the nearest pixel, columns and rows (rows negated)
    center: f32,     // centre's depth minus the reference
    id: u32,
}

// Few buffers, since adapters bind as few as ten; of vectors, since software adapters load a vector at once, a struct
// number by number.
@group(0) @binding(9) var<uniform> lens: Lens;
@group(0) @binding(10) var<storage, read> fronts: array<vec4<i32>>;
// The near spheres, four vectors each, and then, in the order of fronts, what only a winner is asked, one each.
@group(0) @binding(11) var<storage, read> others: array<vec4<i32>>;
// Of every tile of 8 x 8 pixels its first entry in fronts and the one past its last, multiples of CHUNK; then for every
// CHUNK entries the sill: nobody in it, or behind it in its list, has a lower bound of depth below this.
@group(0) @binding(12) var<storage, read> lists: array<u32>;

const CHUNK: u32 = 8u;

fn front(n: u32) -> Front {
    let v = fronts[n];
    return Front(v.x, v.y, bitcast<f32>(v.z), bitcast<f32>(v.w));
}

fn front_more(n: u32) -> FrontMore {
    let v = others[4u * lens.nears + n];
    return FrontMore(vec2<f32>(bitcast<f32>(v.x), bitcast<f32>(v.y)), bitcast<f32>(v.z), bitcast<u32>(v.w));
}

// What one ray needs: slopes, |d|^2 and its reciprocal, the pixel, and the pixel in fixed point.
struct Slopes {
    x: f32,
    y: f32,
    a: f32,
    inverse: f32,
    row: i32,
    column: i32,
    fixed_row: i32,
    fixed_column: i32,
    // What every candidate is asked with: read once, since software adapters read a uniform lane by lane in a loop.
    fixed: vec2<f32>,
    error: vec3<f32>,
    depth: f32,
    unit: f32,
    size: f32,
    slack: f32,
    sills: u32, // where they begin in lists
}

// A winner's answer. The depth is the centre's depth (0 for a near sphere) plus offset; it lies between low and high.
struct Answer {
    sure: bool,      // hit, root, depth and normal are within their promise; order is not judged here
    hits: bool,      // the hit alone is certain
    id: u32,
    offset: f32,
    low: f32,
    high: f32,
    width: f32,      // how far the depth given out may be from the true one
    normal: vec3<f32>,
}

const UNIT: f32 = 1.1920928955078125e-7;      // 2^-23: WGSL rounds either way
const HOST: f32 = 3.552713678800501e-15;      // 2^-48: what the host's f64 rotation leaves in a near sphere
const DEPTH: f32 = 1.1368683772161603e-13;    // 2^-43: and in a front sphere's depth, of itself
const INFLATE: f32 = 1.0009765625;            // 1 + 2^-10: the bounds are computed in f32 themselves
const VANISH: f32 = 7.888609052210118e-31;    // 2^-100: what flushed subnormals leave, times |d|^2
const QUOTIENT: f32 = 1.7881393432617188e-6;  // 15 UNIT: root, sums and quotient of c/q
const FAR: f32 = 8.0;                         // no point of a sphere is as deep in its record's unit
const NORMAL: f32 = 0.97e-3;                  // radians promised, less the roundings of the unit vector

fn slopes(i: u32, j: u32) -> Slopes {
    let x = f32(2 * i32(j) + 1 - i32(view.width)) * lens.slope_x;
    let y = f32(i32(view.height) - 1 - 2 * i32(i)) * lens.slope_y;
    let a = 1.0 + x * x + y * y;
    let row = i32(i);
    let column = i32(j);
    let fixed = vec2<f32>(lens.fixed_x, lens.fixed_y);
    let error = vec3<f32>(lens.error0, lens.error1, lens.error2);
    let shift = lens.shift;
    return Slopes(
        x, y, a, 1.0 / a, row, column, row << shift, column << shift, fixed, error, lens.depth, lens.unit, lens.size,
        lens.slack, 2u * tile_columns() * tile_rows(),
    );
}
