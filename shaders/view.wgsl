// What every stage knows: the view, in the canonical camera. No world coordinate comes here.

// The canonical camera of the lecture, its viewport and distance scaled by one power of two.
struct View {
    right: vec4<f32>,      // basis u, v, w in world space, for normals; w unused
    up: vec4<f32>,
    back: vec4<f32>,
    background: vec4<f32>, // linear RGB; w unused
    width: u32,            // W of the full frame, pixels; of the finer one whose pixels are samples
    height: u32,           // H likewise
    first_row: u32,        // of the band of the window that this dispatch renders, in the full frame
    rows: u32,             // in the band
    half_du: f32,          // vw / (2 W)
    half_dv: f32,          // vh / (2 H)
    d: f32,                // distance of the viewport
    spheres: u32,          // how many every ray tests
    zero: u32,             // 0, which no compiler knows
    half_du_low: f32,      // what rounding took from half_du, half_dv, d
    half_dv_low: f32,
    d_low: f32,
    first_column: u32,     // of the window
    columns: u32,          // in the window
    strata: u32,           // along a side of a pixel, one sample each
    jitter: u32,           // pixels of the finer frame along a side of a stratum, a power of two
    sample: u32,           // which one
    seed: u32,             // of where in their strata samples lie
}

const GROUP: u32 = 64u; // invocations in a workgroup: a tile of 8 x 8 pixels, or so many given rays
const CHUNK: u32 = 8u;  // records that are tested together; a list of candidates has whole chunks

@group(0) @binding(BIND_VIEW) var<uniform> view: View;
