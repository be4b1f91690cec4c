// Every frame has the id: it is the answer itself, and hits are counted from it.
@group(0) @binding(3) var<storage, read_write> frame_id: array<u32>;

fn write_id(pixel: u32, hit: Hit) {
    frame_id[pixel] = hit.id;
}
