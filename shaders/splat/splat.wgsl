// Adds a projected sphere to a pixel. Two passes leave in every pixel the two smallest lower bounds of depth and the
// slot of the smallest. They take minima, so the order of the spheres does not matter. A third pass finds the spheres
// among which the host decides an unsure pixel.

// For every pixel of the band the least depth, then the slots, then the second least depths, and where planes cut spheres the ranks of
// faces, all inverted, so that 0 is none.
@group(0) @binding(BIND_MINIMA) var<storage, read_write> minima: array<atomic<u32>>;
@group(0) @binding(BIND_FRAME_ID) var<storage, read_write> frame_id: array<u32>;

fn splat(c: Frame, f: Projected, slot: u32, at: vec2<u32>) {
    let pixel = (at.y - c.first.y) * c.columns + (at.x - c.first.x);
    // Nearly all pixels are proved.
    if (c.mode == PAIRS_OF_UNSURE && frame_id[pixel] != UNSURE) {
        return;
    }
    let low = solid_low(c, slopes_of(c, sample_position(at)), f, slot, pixel);
    if (low >= MISS) {
        return;
    }
    let key = inverted(low);
    if (c.mode == LEAST) {
        if (key > atomicLoad(&minima[pixel])) {
            atomicMax(&minima[pixel], key);
        }
    } else if (c.mode == SLOTS) {
        let second = 2u * c.pixels + pixel;
        if (key == atomicLoad(&minima[pixel])) {
            // An exact tie makes the pixel unsure, whichever comes first.
            if (atomicMax(&minima[c.pixels + pixel], ~slot) != 0u) {
                atomicMax(&minima[second], key);
            }
        } else if (key > atomicLoad(&minima[second])) {
            atomicMax(&minima[second], key);
        }
    } else if (key >= atomicLoad(&minima[2u * c.pixels + pixel])) {
        // main/certified.wgsl has left the depth that the nearest hit does not exceed.
        list_for_host(pixel, slot);
    }
}

// The rectangle as far as it lies in the band.
fn in_band(r: vec4<i32>) -> vec4<i32> {
    let first = vec2<i32>(i32(view.first_column), i32(view.first_row));
    let last = first + vec2<i32>(i32(view.columns), i32(view.rows)) - vec2<i32>(1);
    return vec4<i32>(max(r.xy, first), min(r.zw, last));
}
