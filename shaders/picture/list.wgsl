// The list of pixels for the host, each with its sphere: the pairs of shaders/splat.
fn list_for_host(pixel: u32, id: u32) {
    // The host asks only whether there are more than PAIRS, so the count stops soon after, and cannot wrap.
    if (atomicLoad(&summary[SUMMARY_PAIRS]) <= PAIRS) {
        let place = atomicAdd(&summary[SUMMARY_PAIRS], 1u);
        if (place < PAIRS) {
            pairs[place] = vec2<u32>(pixel, id);
        }
    }
}
