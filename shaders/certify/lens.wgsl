// The certified kernel's view of the scene: docs/certificate.md derives every bound that is used here.
// The direction is (x, y, -1): slopes instead of u, v, d, so that t is the planar depth.

struct Lens {
    slope_x: f32,    // vw / (2 W d)
    slope_y: f32,    // vh / (2 H d)
    step_x: f32,     // a pixel's width and height in the unit of the front spheres' rho
    step_y: f32,
    depth: f32,      // the frame's reference depth: depths of front spheres are kept relative to it
    tolerance: f32,  // promised relative error of t
    fronts: u32,     // spheres wholly in front of the eye plane, and not near
    nears: u32,      // the others
}

// A sphere wholly in front: its projected centre as an integer pixel and a rest, so that the offset from any pixel has
// one rounding, however far the sphere.
struct Front {
    rest: vec2<f32>, // projected centre minus the pixel, columns and rows (rows negated)
    column: i32,
    row: i32,
    rho2: f32,       // projected radius squared
    error: f32,      // bound of the discriminant's error, for all rays
    size: f32,       // length at the centre's depth of what rho is measured in, frame's unit
    low: f32,        // centre's depth minus the reference, minus the bound of its error
}

// What only a winner is asked.
struct FrontMore {
    high: f32,       // centre's depth minus the reference, plus the bound of its error
    least: f32,      // the normal is within its promise for discriminants above this
    id: u32,
    unused: u32,
}

// Any other sphere: around the eye, beside it, close and large.
struct Near {
    ball: vec4<f32>, // centre minus eye and radius, 2^-k
    power: f32,      // of the eye, 2^-2k; its sign is exact
    scale: f32,      // depth of this record times scale is depth in the frame's unit
    form: u32,       // 0: a r^2 - |p x d|^2, 1: b^2 - a c
    id: u32,
}

@group(0) @binding(9) var<uniform> lens: Lens;
@group(0) @binding(10) var<storage, read> fronts: array<Front>;
@group(0) @binding(11) var<storage, read> front_mores: array<FrontMore>;
@group(0) @binding(12) var<storage, read> nears: array<Near>;

// What one ray needs: slopes, |d|^2 and its reciprocal, the pixel.
struct Slopes {
    x: f32,
    y: f32,
    a: f32,
    inverse: f32,
    row: i32,
    column: i32,
}

// A winner's answer. The depth is the centre's depth (0 for a near sphere) plus offset; it lies between low and high.
struct Answer {
    sure: bool,      // hit, root, depth and normal are within their promise; order is not judged here
    hits: bool,      // the hit alone is certain
    id: u32,
    offset: f32,
    low: f32,
    high: f32,
    normal: vec3<f32>,
}

const UNIT: f32 = 1.1920928955078125e-7; // 2^-23: WGSL rounds either way

fn slopes(i: u32, j: u32) -> Slopes {
    let x = f32(2 * i32(j) + 1 - i32(view.width)) * lens.slope_x;
    let y = f32(i32(view.height) - 1 - 2 * i32(i)) * lens.slope_y;
    let a = 1.0 + x * x + y * y;
    return Slopes(x, y, a, 1.0 / a, i32(i), i32(j));
}
