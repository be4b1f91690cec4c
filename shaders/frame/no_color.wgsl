// Nobody asked for colours.
fn write_color(pixel: u32, ray: Ray, hit: Hit) {}
