//! Writes scenes/weekend.toml: a ground of radius 1000, a field of small spheres and three big ones, similar to the
//! cover of *Ray Tracing in One Weekend* (Shirley, Black, Hollasch); and scenes/cover.toml, that cover itself, with its
//! materials but without the blur of its lens. The seeds are fixed, so the files are always the same:
//!
//! ```sh
//! cargo run --example weekend > scenes/weekend.toml
//! cargo run --example weekend -- cover > scenes/cover.toml
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

fn thousandth(x: f64) -> f64 {
    (x * 1e3).round() / 1e3
}

fn main() {
    match std::env::args().nth(1).as_deref() {
        None => weekend(),
        Some("cover") => cover(),
        Some(other) => {
            eprintln!("weekend: found {other}, expected nothing or cover");
            std::process::exit(2);
        }
    }
}

/// The camera of the book's last scene.
const CAMERA: &str = "[camera]\neye = [13.0, 2.0, 3.0]\nat = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\nvfov = 20.0";

fn weekend() {
    println!("# A ground, a field of small spheres, three big ones. Made by `cargo run --example weekend`.");
    println!("{CAMERA}");
    println!("\n[image]\nsize = [1200, 675]\nsamples = 4");
    println!("\n[sky]\nzenith = [0.12, 0.34, 0.82]\nhorizon = [0.66, 0.78, 0.92]");
    println!("\n[[light]]\ndirection = [0.5, 0.8, 0.75]\ncolor = [1.0, 0.86, 0.68]\nintensity = 1.3");
    sphere([0.0, -1000.0, 0.0], 1000.0, [0.5, 0.5, 0.5]);
    let mut random = Random(2026);
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

/// The book's last scene: chances, ranges and the three big spheres are the book's, the random numbers are not. The sky is the
/// mean of the book's gradient, and lights what is diffuse with 4 rays for each sample.
fn cover() {
    println!("# The cover of Ray Tracing in One Weekend. Made by `cargo run --example weekend -- cover`.");
    println!("# halfline render scenes/cover.toml --samples 16 -o cover.png");
    println!("{CAMERA}");
    println!("\n[image]\nsize = [1200, 675]\nbackground = [0.75, 0.85, 1.0]\n\n[occlusion]\nrays = 4");
    sphere([0.0, -1000.0, 0.0], 1000.0, [0.5, 0.5, 0.5]);
    let mut random = Random(1995);
    for a in -11..11 {
        for b in -11..11 {
            let kind = random.next();
            let (x, z) = (f64::from(a) + 0.9 * random.next(), f64::from(b) + 0.9 * random.next());
            let [product, bright] =
                [[0, 1, 2].map(|_| random.next() * random.next()), [0, 1, 2].map(|_| 0.5 + 0.5 * random.next())];
            let fuzz = thousandth(0.5 * random.next());
            // The book keeps the small spheres away from the metal one alone.
            if [-4.0, 0.0, 4.0].iter().any(|big| (x - big).hypot(z) <= 0.9) {
                continue;
            }
            let center = [thousandth(x), 0.2, thousandth(z)];
            match kind {
                kind if kind < 0.8 => sphere(center, 0.2, product.map(thousandth)),
                kind if kind < 0.95 => {
                    sphere(center, 0.2, bright.map(thousandth));
                    println!("material = \"metal\"\nfuzz = {fuzz:?}");
                }
                _ => {
                    sphere(center, 0.2, [1.0; 3]);
                    println!("material = \"glass\"");
                }
            }
        }
    }
    sphere([0.0, 1.0, 0.0], 1.0, [1.0; 3]);
    println!("material = \"glass\"");
    sphere([-4.0, 1.0, 0.0], 1.0, [0.4, 0.2, 0.1]);
    sphere([4.0, 1.0, 0.0], 1.0, [0.7, 0.6, 0.5]);
    println!("material = \"metal\"");
}
