// The uniform of pictures, and the sums over rays toward the sky: the host's SkySums, each a mean over the rays of a pixel.

struct Picture {
    sky_corner: vec2<u32>,  // first column and row, in the full frame, of the window of the sums, and its columns and rows
    sky_size: vec2<u32>,
    up: vec3<f32>,          // of the sky's colours
    share: f32,             // of the sky's light that surfaces reflect
    horizon: vec3<f32>,
    gradient: u32,          // 0: a white sky, 1: one with colours, 2: one that misses show too
    change: vec3<f32>,      // of the colour from the horizon to the zenith
    lights: u32,
    ink: vec3<f32>,         // the colour of lines
    strength: f32,          // of lines; 0 without any
    pixel_slope: f32,       // the size of a pixel in the frame's unit: this times the depth, and a constant
    pixel_size: f32,
    stretch: f32,           // the distances of neighbours over the distances for the narrowest line
    between: u32,           // 1: lines also where spheres meet without a gap
    neighbours: vec2<i32>,  // the distances of the first and the second neighbour
    cue_near: f32,          // the depth where the background begins to show, and 1 over the way to where it shows most
    cue_slope: f32,
    cue_share: f32,         // the most that it shows; 0 without a depth cue
    radius: f32,            // the tree's unit in the frame's
    step: u32,              // of a pass of shaders/picture/smooth.wgsl
    planes: u32,            // words of a pixel's sums: 3, or 6 of a sky with colours
    parallel: u32,
    unused: u32,
    shares: array<vec4<f32>, 9>,      // the zenith's share of an open sky's light, by the normal's product with `up`
    sources: array<vec4<f32>, 16>,    // two vectors a light: toward it, and its colour
}

@group(0) @binding(BIND_PICTURE) var<uniform> picture: Picture;

// For every pixel of the window the sphere, then the normal in two words.
@group(0) @binding(BIND_SKY_HITS) var<storage, read_write> sky_hits: array<u32>;
@group(0) @binding(BIND_SKY_SUMS) var<storage, read_write> sky_sums: array<u32>;

// Over all rays, over those that nothing hides, and the same times the zenith's share of the colour there.
struct Sums {
    all: vec3<f32>,
    open: vec3<f32>,
    zenith: vec3<f32>,
    open_zenith: vec3<f32>,
}

const NO_SUMS: Sums = Sums(vec3<f32>(), vec3<f32>(), vec3<f32>(), vec3<f32>());

fn plus(a: Sums, b: Sums, weight: f32) -> Sums {
    return Sums(
        a.all + weight * b.all, a.open + weight * b.open, a.zenith + weight * b.zenith,
        a.open_zenith + weight * b.open_zenith,
    );
}

// Pixels of the window of the sums.
fn sky_pixels() -> u32 {
    return picture.sky_size.x * picture.sky_size.y;
}

fn unpacked(a: u32, b: u32, c: u32) -> array<vec3<f32>, 2> {
    let x = unpack2x16snorm(a);
    let y = unpack2x16snorm(b);
    let z = unpack2x16snorm(c);
    return array<vec3<f32>, 2>(vec3<f32>(x, y.x), vec3<f32>(y.y, z));
}

fn packed(a: vec3<f32>, b: vec3<f32>) -> vec3<u32> {
    return vec3<u32>(pack2x16snorm(a.xy), pack2x16snorm(vec2<f32>(a.z, b.x)), pack2x16snorm(b.yz));
}

fn sums_at(place: u32) -> Sums {
    let n = sky_pixels();
    let first = unpacked(sky_sums[place], sky_sums[place + n], sky_sums[place + 2u * n]);
    var sums = Sums(first[0], first[1], vec3<f32>(), vec3<f32>());
    if (picture.planes > 3u) {
        let second = unpacked(sky_sums[place + 3u * n], sky_sums[place + 4u * n], sky_sums[place + 5u * n]);
        sums.zenith = second[0];
        sums.open_zenith = second[1];
    }
    return sums;
}

fn normal_at(place: u32) -> vec3<f32> {
    let n = sky_pixels();
    return vec3<f32>(unpack2x16snorm(sky_hits[place + n]), unpack2x16snorm(sky_hits[place + 2u * n]).x);
}

// The zenith's share of the sky's colour in a direction of length 1.
fn zenith(direction: vec3<f32>) -> f32 {
    let below = 1.0 - clamp(dot3(direction, picture.up), 0.0, 1.0);
    let square = below * below;
    let fourth = square * square;
    return 1.0 - fourth * fourth;
}

fn open_share(all: f32, open: f32) -> f32 {
    return select(1.0, clamp(open / all, 0.0, 1.0), all > 0.0);
}
