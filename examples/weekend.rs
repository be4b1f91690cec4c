//! Writes scenes/weekend.toml: a ground of radius 1000, a field of small spheres and three big ones, similar to the
//! cover of *Ray Tracing in One Weekend* (Shirley, Black, Hollasch). The seed is fixed, so the file is always the same:
//!
//! ```sh
//! cargo run --example weekend > scenes/weekend.toml
//! ```

/// xorshift64* (Vigna 2016): small, seeded, the same everywhere.
struct Random(u64);

impl Random {
    /// Uniform in [0, 1), with 53 bits.
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn sphere([x, y, z]: [f64; 3], radius: f64, [r, g, b]: [f64; 3]) {
    println!("\n[[sphere]]\ncenter = [{x:?}, {y:?}, {z:?}]\nradius = {radius:?}\ncolor = [{r:?}, {g:?}, {b:?}]");
}

fn main() {
    println!("# A ground, a field of small spheres, three big ones. Made by `cargo run --example weekend`.");
    println!("[camera]\neye = [13.0, 2.0, 3.0]\nat = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nvfov = 20.0");
    println!("\n[image]\nsize = [1200, 675]\nbackground = [0.48, 0.67, 1.0]");
    sphere([0.0, -1000.0, 0.0], 1000.0, [0.5, 0.5, 0.5]);
    let mut random = Random(2026);
    let thousandth = |x: f64| (x * 1e3).round() / 1e3;
    for a in -11..11 {
        for b in -11..11 {
            let (x, z) = (f64::from(a) + 0.9 * random.next(), f64::from(b) + 0.9 * random.next());
            let color = [0, 1, 2].map(|_| thousandth(random.next() * random.next() + 0.05));
            // The big spheres need space.
            if [-4.0, 0.0, 4.0].iter().all(|big| (x - big).hypot(z) > 1.1) {
                sphere([thousandth(x), 0.2, thousandth(z)], 0.2, color);
            }
        }
    }
    sphere([0.0, 1.0, 0.0], 1.0, [0.75, 0.8, 0.85]);
    sphere([-4.0, 1.0, 0.0], 1.0, [0.4, 0.2, 0.1]);
    sphere([4.0, 1.0, 0.0], 1.0, [0.7, 0.55, 0.4]);
}
