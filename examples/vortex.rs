//! Writes the particle box of the gallery as a LAMMPS dump: grains of two sizes on a perturbed lattice that move in a
//! Taylor-Green vortex (Taylor and Green, Proc. R. Soc. A 158, 499 (1937)), with some noise.
//!
//! `cargo run --release --example vortex | bzip2 > scenes/vortex.dump.bz2`

use std::io::{self, BufWriter, Write};

/// Grains along a side, and the side in grain spacings.
const SIDE: usize = 18;

fn main() -> io::Result<()> {
    let mut out = BufWriter::new(io::stdout().lock());
    let n = SIDE.pow(3);
    let length = SIDE as f64;
    writeln!(out, "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{n}\nITEM: BOX BOUNDS pp pp pp")?;
    (0..3).try_for_each(|_| writeln!(out, "0 {length}"))?;
    writeln!(out, "ITEM: ATOMS id type x y z vx vy vz radius")?;
    // Knuth's multiplicative generator; its upper bits are random enough here.
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    for id in 0..n {
        let cell = [id % SIDE, id / SIDE % SIDE, id / (SIDE * SIDE)];
        let [x, y, z] = cell.map(|k| (k as f64 + 0.5 + 0.5 * random()).rem_euclid(length));
        let [a, b, c] = [x, y, z].map(|q| std::f64::consts::TAU * q / length);
        let noise = [random(), random(), random()].map(|r| 0.1 * r);
        let velocity = [a.sin() * b.cos() * c.cos(), -a.cos() * b.sin() * c.cos(), 0.0];
        let [u, v, w] = [0, 1, 2].map(|k| velocity[k] + noise[k]);
        let (kind, radius) = if random() < 0.2 { (2, 0.55) } else { (1, 0.4) };
        writeln!(out, "{} {kind} {x:.4} {y:.4} {z:.4} {u:.4} {v:.4} {w:.4} {radius}", id + 1)?;
    }
    out.flush()
}
