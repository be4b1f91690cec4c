// The view, shared by all stages, in the canonical camera. Kernels use no world coordinates.

// The canonical camera of the lecture, its viewport and distance scaled by one power of two.
struct View {
    right: vec4<f32>,      // basis u, v, w in world space, for normals; w unused
    up: vec4<f32>,
    back: vec4<f32>,
    background: vec4<f32>, // linear RGB; w unused
    width: u32,            // W of the frame of pixels; with samples or an off-centre lens, of the finer frame
    height: u32,           // H likewise
    first_row: u32,        // of the band of the window that this dispatch renders, in the full frame
    rows: u32,             // in the band
    half_du: f32,          // vw / (2 W)
    half_dv: f32,          // vh / (2 H)
    d: f32,                // distance of the viewport
    spheres: u32,          // number that every ray tests
    zero: u32,             // 0, unknown at compile time
    half_du_low: f32,      // rounding errors of half_du, half_dv, d
    half_dv_low: f32,
    d_low: f32,
    first_column: u32,     // of the window
    columns: u32,          // in the window
    strata: u32,           // along a side of a pixel, one sample each
    jitter: u32,           // pixels of the finer frame along a side of a stratum, a power of two
    sample: u32,           // its number
    seed: u32,             // of the samples' positions in their strata
    step: u32,             // pixels of the finer frame from a place of a ray to the next
    shift_column: u32,     // of the image's first place in the finer frame
    shift_row: u32,
}

const GROUP: u32 = 64u; // invocations in a workgroup: a tile of 8 x 8 pixels, or 64 given rays

@group(0) @binding(BIND_VIEW) var<uniform> view: View;
