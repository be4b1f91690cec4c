// What rounding to f32 took from each Sphere, for rays from many points and for arithmetic better than f32.
struct SphereLow {
    ball: vec4<f32>,
    power: f32,
}

@group(0) @binding(8) var<storage, read> lows: array<SphereLow>;
