// No ray leaves from the hits of this frame.
fn keep_start(pixel: u32, s: Slopes) {
}
