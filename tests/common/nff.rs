//! Generates scenes of the Standard Procedural Databases in NFF: E. Haines, *A proposal for standard graphics
//! environments*, IEEE Computer Graphics and Applications 7 (11), 1987; the sea shell after C. A. Pickover, *A short recipe
//! for seashell synthesis*, in the same journal, 9 (6), 1989.

use glam::{DQuat, DVec3};
use std::f64::consts::PI;

/// Every scene here, by the name of the file of the databases that it equals.
pub(crate) fn all() -> [(&'static str, String); 4] {
    [("balls_s2.nff", balls(2)), ("balls_s4.nff", balls(4)), ("shells.nff", shells()), ("jacks.nff", jacks())]
}

/// A camera, the lights and the first fill.
fn head(background: &str, [from, at, up]: [&str; 3], numbers: [&str; 3], lights: &[&str], fill: &str) -> String {
    let [angle, hither, side] = numbers;
    let lights: String = lights.iter().map(|light| format!("l {light}\n")).collect();
    format!(
        "b {background}\nv\nfrom {from}\nat {at}\nup {up}\nangle {angle}\nhither {hither}\nresolution {side} {side}\n\
         {lights}f {fill}\n"
    )
}

fn sphere(center: DVec3, radius: f64) -> String {
    format!("s {} {} {} {radius}\n", center.x, center.y, center.z)
}

/// A sphereflake on a square: each sphere has nine children of a third of its radius, down to `depth`.
pub(crate) fn balls(depth: u32) -> String {
    let camera = ["2.1 1.3 1.7", "0 0 0", "0 0 1"];
    let lights = ["4 3 2", "1 -4 4", "-3 1 5"];
    let mut text = head("0.078 0.361 0.753", camera, ["45", "0.01", "512"], &lights, "1 0.75 0.33 0.8 0 100000 0 1");
    text += "p 4\n12 12 -0.5\n-12 12 -0.5\n-12 -12 -0.5\n12 -12 -0.5\nf 1 0.9 0.7 0.5 0.5 3.0827 0 1\n";
    // Three directions to the midpoints of a cube's edges, tilted so that their triangle is horizontal, and two copies
    // rotated about z.
    let tilt = DQuat::from_axis_angle(DVec3::new(1.0, -1.0, 0.0).normalize(), (2.0 / 6f64.sqrt()).asin());
    let trio = [DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, 0.0, -1.0), DVec3::new(0.0, 1.0, -1.0)];
    let nine = (0..3).flat_map(|turn| {
        let about = DQuat::from_rotation_z(f64::from(turn) * 2.0 * PI / 3.0);
        trio.map(|direction| about * (tilt * direction.normalize()))
    });
    flake(depth, DVec3::ZERO, DVec3::Z, 0.5, &nine.collect::<Vec<_>>(), &mut text);
    text
}

fn flake(depth: u32, center: DVec3, direction: DVec3, radius: f64, nine: &[DVec3], text: &mut String) {
    *text += &sphere(center, radius);
    if depth == 0 {
        return;
    }
    // The rotation from the z axis to the direction of this sphere.
    let axis = DVec3::Z.cross(direction);
    let turn = match axis.length() > 1e-9 {
        true => DQuat::from_axis_angle(axis.normalize(), direction.z.clamp(-1.0, 1.0).acos()),
        false if direction.z > 0.0 => DQuat::IDENTITY,
        false => DQuat::from_rotation_y(PI),
    };
    for outward in nine.iter().map(|child| turn * *child) {
        flake(depth - 1, center + outward * (radius * 4.0 / 3.0), outward, radius / 3.0, nine, text);
    }
}

/// A sea shell: spheres that touch the axis of a logarithmic spiral of nine turns, most of them inside others.
pub(crate) fn shells() -> String {
    let camera = ["-6 -60 35", "0 8 -15", "0 0 1"];
    let mut text =
        head("0.078 0.361 0.753", camera, ["45", "0.5", "512"], &["-100 -100 100"], "1 0.8 0.4 0.8 0.2 45.2776 0 1");
    for step in -3840..=1920 {
        let angle = 18.0 * PI * f64::from(step) / 5760.0;
        let radius = (0.15 * angle).exp();
        text += &sphere(radius * DVec3::new(angle.sin(), angle.cos(), -2.0), radius);
    }
    text
}

/// One jack: three crossed rods (cones in NFF) with a ball on each end.
pub(crate) fn jacks() -> String {
    let camera = ["0 0 -8", "0 0 0", "0 1 0"];
    let mut text =
        head("0.2 0.05 0.2", camera, ["25", "0.001", "256"], &["-10 3 -20"], "0.737 0.561 0.561 0.7 0.7 11.1434 0 1");
    // Turned by 20 degrees about one axis and by 30 about another.
    let ([s, c], [t, d]) = ([20f64, 30.0].map(f64::to_radians).map(f64::sin_cos).map(|(s, c)| [s, c])).into();
    let ends =
        [DVec3::new(c, s * t, s * d), DVec3::new(0.0, d, -t), DVec3::new(-s, c * t, c * d)].map(|end| 0.75 * end);
    for end in ends {
        text += &format!("c {} {} {} 0.075 {} {} {} 0.075\n", -end.x, -end.y, -end.z, end.x, end.y, end.z);
    }
    ends.iter().chain(&ends.map(|end| -end)).for_each(|end| text += &sphere(*end, 0.15));
    text
}
