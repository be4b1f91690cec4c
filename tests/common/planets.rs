//! The Sun, its planets, the Moon and Pluto as a table of spheres, at about their real distances.

use std::f64::consts::TAU;

/// Name, distance from the Sun in astronomical units, longitude at the year 2000 in degrees and radius in km: rounded from
/// E. M. Standish, *Approximate positions of the planets*, and from the radii of the IAU.
const BODIES: [(&str, f64, f64, f64); 11] = [
    ("sun", 0.0, 0.0, 695_700.0),
    ("mercury", 0.387, 252.3, 2440.0),
    ("venus", 0.723, 182.0, 6052.0),
    ("earth", 1.0, 100.5, 6371.0),
    ("moon", 1.0026, 100.5, 1737.0),
    ("mars", 1.524, 355.4, 3390.0),
    ("jupiter", 5.203, 34.4, 69_911.0),
    ("saturn", 9.537, 49.9, 58_232.0),
    ("uranus", 19.19, 313.2, 25_362.0),
    ("neptune", 30.07, 304.9, 24_622.0),
    ("pluto", 39.48, 238.9, 1188.0),
];

/// The table as CSV, in km; orbits are circles in the plane of the Earth's, which is inclined to the equator by 23.44 degrees.
pub(crate) fn csv() -> String {
    let (s, c) = 23.44f64.to_radians().sin_cos();
    let row = |(name, distance, degrees, radius): (&str, f64, f64, f64)| {
        let (y, x) = (degrees / 360.0 * TAU).sin_cos();
        let [x, y] = [x, y].map(|x| x * distance * 149_597_870.7);
        format!("{name},{x:.6},{:.6},{:.6},{radius:.4}\n", y * c, y * s)
    };
    BODIES.into_iter().map(row).fold("name,x_km,y_km,z_km,radius_km\n".to_owned(), |all, row| all + &row)
}
