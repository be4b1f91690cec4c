//! A spinning scanner: a pattern of beams from one point.
//!
//! Ring i of n has the elevation `high + (low - high) i/(n - 1)`, so ring 0 is the highest. Azimuth j of m is
//! `first + step j`, in degrees clockwise seen from above, 0 forward. With right u, up v and back w of a camera's basis
//! the beam's direction is
//!
//! ```text
//! cos(elevation) (sin(azimuth) u - cos(azimuth) w) + sin(elevation) v
//! ```
//!
//! Beams are in the order of their rings, and in a ring of their azimuths: beam i m + j. A result of all beams is an
//! image of n rows and m columns, the highest ring at the top and the right-hand side on the right.
//!
//! A beam is one ray, its axis, or with a divergence several rays in a cone round it, the axis first.

mod beam;

pub use beam::Beam;

use super::camera::Basis;
use beam::MAX_RETURNS;
use glam::DVec3;
use halfline_ground::error::{Error, Result};
use halfline_ground::parallel;
use halfline_ground::quote::quote;
use std::ops::Range;
use std::str::FromStr;

/// The beams of one turn. Angles are in degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lidar {
    rings: u32,
    /// The lowest and the highest elevation.
    vfov: [f64; 2],
    /// The first azimuth.
    first: f64,
    step: f64,
    azimuths: u32,
    range: f64,
    echoes: Option<Beam>,
}

/// The keys of a description.
const KEYS: &str = "rings, vfov, step, azimuth, range, divergence, returns, noise, seed";

/// An example of a description, for messages.
const EXAMPLE: &str = "use a pattern such as lidar:rings=64,vfov=-25..15,step=0.2";

/// Beams whose rays one job makes.
const BEAMS_PER_JOB: usize = 1 << 8;

impl Lidar {
    /// The number of rings.
    #[must_use]
    pub fn rings(&self) -> u32 {
        self.rings
    }

    /// The number of beams in a ring.
    #[must_use]
    pub fn azimuths(&self) -> u32 {
        self.azimuths
    }

    /// The number of beams.
    #[must_use]
    pub fn beams(&self) -> u64 {
        u64::from(self.rings) * u64::from(self.azimuths)
    }

    /// The properties of beams whose echoes are measured; `None` for beams that are rays with exact hits.
    #[must_use]
    pub fn echoes(&self) -> Option<&Beam> {
        self.echoes.as_ref()
    }

    /// The number of rays of a beam.
    #[must_use]
    pub fn rays_per_beam(&self) -> u32 {
        self.echoes.map_or(1, |beam| beam.rays())
    }

    /// The number of all rays.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.beams() * u64::from(self.rays_per_beam())
    }

    /// The length of the beams; +inf without a limit.
    #[must_use]
    pub fn range(&self) -> f64 {
        self.range
    }

    /// The directions of the rays of some beams, of length 1 to within rounding; the first of a beam is its axis. They are
    /// computed in f64; for the rays that are made of them they are exact.
    #[must_use]
    pub fn directions(&self, beams: Range<u64>, basis: &Basis) -> Vec<[f64; 3]> {
        let cone = self.echoes.map(|beam| beam.cone()).unwrap_or_default();
        parallel::collect((beams.end - beams.start) as usize, BEAMS_PER_JOB, &|range, rays| {
            let beams = range.map(|n| beams.start + n as u64);
            beams.for_each(|beam| rays.extend(beam::rays(self.frame(beam, basis), &cone)));
        })
    }

    /// The axis of a beam, and across it the directions of growing azimuth and of growing elevation.
    fn frame(&self, beam: u64, basis: &Basis) -> [DVec3; 3] {
        let (ring, column) = (beam / u64::from(self.azimuths), beam % u64::from(self.azimuths));
        let azimuth = self.first + self.step * column as f64;
        let [(up, out), (right, ahead)] = [self.elevation(ring as u32), azimuth].map(|x| x.to_radians().sin_cos());
        let level = right * basis.u - ahead * basis.w;
        [out * level + up * basis.v, ahead * basis.u + right * basis.w, out * basis.v - up * level]
    }

    fn elevation(&self, ring: u32) -> f64 {
        let [low, high] = self.vfov;
        if self.rings == 1 { low } else { high + (low - high) * f64::from(ring) / f64::from(self.rings - 1) }
    }
}

impl FromStr for Lidar {
    type Err = Error;

    /// `lidar:rings=N,vfov=LOW..HIGH,step=DEG[,azimuth=FROM..TO][,range=R]`. A single ring has one elevation, `vfov=E`,
    /// by default 0. The default azimuths are -180..180; of a full turn the last is not repeated. Beams whose echoes are
    /// measured have `,divergence=DEG[,returns=N]` or `,noise=SIGMA[,seed=N]`, or both.
    fn from_str(text: &str) -> Result<Self> {
        let Some(list) = text.strip_prefix("lidar:") else {
            return Err(Error::settings(format!("there is no pattern {}", quote(text)), EXAMPLE));
        };
        let (mut rings, mut vfov, mut step) = (None, None, None);
        let (mut turn, mut range) = ([-180.0, 180.0], f64::INFINITY);
        let (mut beam, mut keys) = (Beam::default(), Vec::new());
        for entry in list.split(',') {
            let (key, value) = entry.split_once('=').unwrap_or((entry, ""));
            let (key, value) = (key.trim(), value.trim());
            if keys.contains(&key) {
                return Err(wrong(key, "is given twice", "give it once"));
            }
            keys.push(key);
            match key {
                "rings" => rings = Some(value.parse().ok().filter(|n| (1..=MAX_RINGS).contains(n)).ok_or_else(count)?),
                "vfov" => vfov = Some(interval(value).filter(is_elevation).ok_or_else(elevations)?),
                "step" => step = Some(positive(value).filter(|step| *step <= 360.0).ok_or_else(angle)?),
                "azimuth" => turn = interval(value).filter(is_turn).ok_or_else(part_of_a_turn)?,
                "range" => range = positive(value).ok_or_else(|| length("range"))?,
                "divergence" => beam.divergence = positive(value).filter(|a| *a <= MAX_CONE).ok_or_else(cone)?,
                "returns" => beam.returns = value.parse().ok().filter(is_returns).ok_or_else(returns)?,
                "noise" => beam.noise = positive(value).ok_or_else(|| length("noise"))?,
                "seed" => beam.seed = value.parse().map_err(|_| seed())?,
                _ => return Err(Error::settings(format!("the pattern has no {}", quote(key)), format!("use {KEYS}"))),
            }
        }
        let rings: u32 = rings.ok_or_else(|| wrong("rings", "is missing", EXAMPLE))?;
        let vfov = match vfov {
            None if rings == 1 => [0.0; 2],
            None => return Err(wrong("vfov", "is missing", EXAMPLE)),
            Some([low, high]) if (low == high) != (rings == 1) => {
                return Err(wrong("vfov", "does not fit the rings", "use LOW..HIGH, or for one ring its elevation"));
            }
            Some(vfov) => vfov,
        };
        let step = step.ok_or_else(|| wrong("step", "is missing", EXAMPLE))?;
        for (key, other) in [("returns", "divergence"), ("seed", "noise")] {
            if keys.contains(&key) && !keys.contains(&other) {
                return Err(wrong(key, &format!("is without {other}"), &format!("add {other}, or remove {key}")));
            }
        }
        let echoes = (beam != Beam::default()).then_some(beam);
        Ok(Self { rings, vfov, first: turn[0], step, azimuths: azimuths(turn, step)?, range, echoes })
    }
}

/// The number of azimuths from one to the other, both included; the last of a full turn is not counted.
fn azimuths([first, last]: [f64; 2], step: f64) -> Result<u32> {
    let steps = (last - first) / step;
    // 360/0.2 is 1800 for the user, whatever f64 makes of it.
    let whole = (steps - steps.round()).abs() <= 1e-9 * steps;
    let steps = if whole { steps.round() } else { steps.floor() };
    let repeats = whole && last - first == 360.0;
    let count = if repeats { steps } else { steps + 1.0 };
    if count <= f64::from(u32::MAX) {
        return Ok(count as u32);
    }
    Err(wrong("step", &format!("gives {count:e} azimuths"), &format!("use a step that gives at most {}", u32::MAX)))
}

/// The most rings.
const MAX_RINGS: u32 = 1 << 20;

/// The largest divergence in degrees.
const MAX_CONE: f64 = 90.0;

/// `A..B`, or one number for both.
fn interval(text: &str) -> Option<[f64; 2]> {
    let (low, high) = text.split_once("..").unwrap_or((text, text));
    Some([low.trim().parse().ok()?, high.trim().parse().ok()?])
}

fn positive(text: &str) -> Option<f64> {
    text.parse().ok().filter(|x: &f64| *x > 0.0 && x.is_finite())
}

fn is_elevation([low, high]: &[f64; 2]) -> bool {
    -90.0 <= *low && low <= high && *high <= 90.0
}

fn is_turn([first, last]: &[f64; 2]) -> bool {
    first.abs() <= 360.0 && first <= last && last - first <= 360.0
}

fn is_returns(count: &u8) -> bool {
    (1..=MAX_RETURNS).contains(count)
}

fn wrong(key: &str, what: &str, mend: &str) -> Error {
    Error::settings(format!("{key} of the pattern {what}"), mend)
}

fn count() -> Error {
    wrong("rings", "is not a number of rings", &format!("use a whole number between 1 and {MAX_RINGS}"))
}

fn elevations() -> Error {
    wrong("vfov", "is not a pair of elevations", "use LOW..HIGH in degrees between -90 and 90, such as -25..15")
}

fn angle() -> Error {
    wrong("step", "is not an angle", "use degrees between 0 and 360, such as 0.2")
}

fn part_of_a_turn() -> Error {
    wrong("azimuth", "is not a part of a turn", "use FROM..TO in degrees, at most 360 apart, such as -60..60")
}

fn length(key: &str) -> Error {
    wrong(key, "is not a length", "use a positive number in the scene's unit")
}

fn cone() -> Error {
    wrong("divergence", "is not the angle of a cone", &format!("use degrees between 0 and {MAX_CONE}, such as 0.17"))
}

fn returns() -> Error {
    wrong("returns", "is not a number of returns", &format!("use a whole number between 1 and {MAX_RETURNS}"))
}

fn seed() -> Error {
    wrong("seed", "is not a whole number", &format!("use a whole number between 0 and {}", u32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::Camera;
    use glam::DVec3;

    fn lidar(text: &str) -> Lidar {
        text.parse().unwrap_or_else(|error| panic!("{text}: {error}"))
    }

    #[test]
    fn azimuths_are_counted_as_a_person_counts() {
        for (text, rings, azimuths) in [
            ("lidar:rings=64,vfov=-25..15,step=0.2", 64, 1800),
            ("lidar:rings=2,vfov=-1..1,step=0.1,range=50", 2, 3600),
            ("lidar:rings=2,vfov=-1..1,step=0.7", 2, 515),
            ("lidar:rings=2,vfov=-1..1,step=360", 2, 1),
            ("lidar:rings=1,step=0.25,azimuth=-135..135", 1, 1081),
            ("lidar: rings = 1, vfov = 3, step=7,azimuth=0..20", 1, 3),
            ("lidar:rings=1,step=1,azimuth=10", 1, 1),
        ] {
            let lidar = lidar(text);
            assert_eq!((lidar.rings(), lidar.azimuths()), (rings, azimuths), "{text}");
            assert_eq!(lidar.beams(), u64::from(rings) * u64::from(azimuths));
        }
        assert_eq!(
            (lidar("lidar:rings=1,step=1,range=50").range(), lidar("lidar:rings=1,step=1").range()),
            (50.0, f64::INFINITY)
        );
    }

    /// The canonical camera: right is x, up is y, forward is -z.
    #[test]
    fn the_image_has_up_at_the_top_and_right_on_the_right() {
        let basis = Camera::CANONICAL.basis().expect("a basis");
        let lidar = lidar("lidar:rings=3,vfov=-30..60,step=90");
        let beams = lidar.directions(0..12, &basis);
        let at = |ring: usize, column: usize| DVec3::from_array(beams[4 * ring + column]);
        let expected = |elevation: f64, azimuth: f64| {
            let [(up, out), (right, ahead)] = [elevation, azimuth].map(|x| x.to_radians().sin_cos());
            DVec3::new(out * right, up, -out * ahead)
        };
        for (ring, elevation) in [60.0, 15.0, -30.0].into_iter().enumerate() {
            for (column, azimuth) in [-180.0, -90.0, 0.0, 90.0].into_iter().enumerate() {
                let error = (at(ring, column) - expected(elevation, azimuth)).length();
                assert!(error < 1e-15, "ring {ring}, column {column}: {error}");
            }
        }
        assert!(at(1, 3).x > 0.9 && at(1, 2).z < -0.9 && at(0, 0).y > 0.8);
        // Whatever the block.
        assert_eq!(lidar.directions(5..9, &basis), beams[5..9]);
    }

    /// Of a wide cone the rays have length 1 and the angles of equal shares: inside of the first ring are 1 + 6/2 of 19
    /// shares of its solid angle 2 pi (1 - cos 30 degrees), inside of the second 1 + 6 + 12/2.
    #[test]
    fn the_rays_of_a_beam_have_equal_shares_of_its_cone() {
        let basis = Camera::CANONICAL.basis().expect("a basis");
        let [plain, wide] = ["", ",divergence=60,returns=3"]
            .map(|keys| lidar(&format!("lidar:rings=3,vfov=-90..60,step=50{keys}")).directions(0..24, &basis));
        assert_eq!((plain.len(), wide.len()), (24, 24 * 19));
        for (axis, rays) in plain.iter().zip(wide.as_chunks::<19>().0) {
            assert_eq!(*axis, rays[0]);
            let [axis, rays] =
                [&[*axis][..], rays].map(|all| all.iter().copied().map(DVec3::from_array).collect::<Vec<_>>());
            let shares = |ray: &DVec3| 19.0 * (1.0 - axis[0].dot(*ray)) / (1.0 - 30f64.to_radians().cos());
            for (n, ray) in rays.iter().enumerate() {
                let expected = [0.0, 4.0, 13.0][usize::from(n > 0) + usize::from(n > 6)];
                // Some roundings of cosines and their sums.
                assert!((ray.length() - 1.0).abs() < 1e-15, "ray {n}: {ray}");
                assert!((shares(ray) - expected).abs() < 1e-12, "ray {n}: {}", shares(ray));
            }
            for ring in [1..7, 7..19] {
                let sum: DVec3 = rays[ring.clone()].iter().sum();
                // Evenly round the axis.
                assert!(sum.normalize().distance(axis[0]) < 1e-14, "{ring:?}: {sum}");
            }
        }
    }

    #[test]
    fn an_invalid_pattern_is_refused_with_its_key() {
        for (text, expected) in [
            ("radar:rings=1", "no pattern `radar:rings=1`"),
            ("lidar:", "no ``"),
            ("lidar:rings=0,vfov=0..1,step=1", "rings"),
            ("lidar:rings=2.5,vfov=0..1,step=1", "rings"),
            ("lidar:vfov=0..1,step=1", "rings of the pattern is missing"),
            ("lidar:rings=2,step=1", "vfov of the pattern is missing"),
            ("lidar:rings=2,vfov=1,step=1", "vfov"),
            ("lidar:rings=1,vfov=0..1,step=1", "vfov"),
            ("lidar:rings=2,vfov=1..0,step=1", "vfov"),
            ("lidar:rings=2,vfov=0..91,step=1", "vfov"),
            ("lidar:rings=2,vfov=nan..1,step=1", "vfov"),
            ("lidar:rings=2,vfov=0..1", "step of the pattern is missing"),
            ("lidar:rings=2,vfov=0..1,step=0", "step"),
            ("lidar:rings=2,vfov=0..1,step=1e-9", "azimuths"),
            ("lidar:rings=2,vfov=0..1,step=1,azimuth=0..361", "azimuth"),
            ("lidar:rings=2,vfov=0..1,step=1,azimuth=inf..inf", "azimuth"),
            ("lidar:rings=2,vfov=0..1,step=1,range=-1", "range"),
            ("lidar:rings=1,step=1,divergence=0", "divergence of the pattern is not the angle"),
            ("lidar:rings=1,step=1,divergence=91", "divergence"),
            ("lidar:rings=1,step=1,divergence=nan", "divergence"),
            ("lidar:rings=1,step=1,divergence=1,returns=0", "returns of the pattern is not a number"),
            ("lidar:rings=1,step=1,divergence=1,returns=16", "returns"),
            ("lidar:rings=1,step=1,returns=2", "returns of the pattern is without divergence"),
            ("lidar:rings=1,step=1,noise=-1", "noise of the pattern is not a length"),
            ("lidar:rings=1,step=1,noise=inf", "noise"),
            ("lidar:rings=1,step=1,noise=1,seed=-1", "seed of the pattern is not a whole number"),
            ("lidar:rings=1,step=1,divergence=1,seed=1", "seed of the pattern is without noise"),
            ("lidar:rings=2,rings=2,vfov=0..1,step=1", "twice"),
            ("lidar:rings=2,fov=0..1,step=1", "no `fov`"),
        ] {
            let error = text.parse::<Lidar>().expect_err(text).to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
