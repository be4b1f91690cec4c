// Nobody asked for normals.
fn write_normal(pixel: u32, ray: Ray, hit: Hit) {}
