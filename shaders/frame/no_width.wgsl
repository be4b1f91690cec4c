// Nobody asked for the bound.
fn write_width(pixel: u32, width: f32) {}
