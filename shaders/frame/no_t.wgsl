// Nobody asked for t.
fn write_t(pixel: u32, hit: Hit) {}
