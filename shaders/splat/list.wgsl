// The list for the host: a pixel of the band and a slot, or NONE.
@group(0) @binding(BIND_PAIRS) var<storage, read_write> pairs: array<vec2<u32>>;

fn list_for_host(pixel: u32, slot: u32) {
    // The host asks only whether there are more than PAIRS, so the count stops soon after, and cannot wrap.
    if (atomicLoad(&summary[SUMMARY_PAIRS]) <= PAIRS) {
        let place = atomicAdd(&summary[SUMMARY_PAIRS], 1u);
        if (place < PAIRS) {
            pairs[place] = vec2<u32>(pixel, slot);
        }
    }
}
