//! The echoes of a scanner's beams: the hits of a beam's rays on one sphere are one echo.

use super::{Hits, Rays};
use crate::scene::Spheres;
use crate::scene::lidar::{Beam, Lidar};
use crate::shade::color_of;
use crate::view::pcg4d;
use glam::{DVec3, Vec3};
use halfline_ground::parallel;
use std::f64::consts::TAU;
use std::ops::Range;

/// The echoes of some beams, in the order of the beams.
#[derive(Debug, Clone, PartialEq)]
pub struct Echoes {
    /// The number of beams, those without an echo included.
    pub beams: u64,
    /// The echoes; within a beam by their distances without noise.
    pub all: Vec<Echo>,
}

/// The measurement of one sphere by one beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Echo {
    /// The ring of the beam, from 0.
    pub ring: u32,
    /// The column of the beam in its ring, from 0.
    pub column: u32,
    /// The number of the echo among the echoes of its beam, from 1.
    pub return_number: u8,
    /// The number of echoes of the beam, at most [`Beam::returns`].
    pub number_of_returns: u8,
    /// Index of the sphere.
    pub id: i32,
    /// The mean of the distances of the beam's hits on the sphere, and noise; not below 0.
    pub distance: f64,
    /// The point at this distance on the beam's axis.
    pub position: [f64; 3],
    /// The sum over the hits of the cosine between ray and normal, times the luminance of the sphere's colour, over the
    /// number of the beam's rays: 0 to 1.
    pub intensity: f32,
    /// The largest [`Hits::certainty`] of the hits; 255 with noise.
    pub certainty: u8,
}

/// The hits of a beam's rays on one sphere.
struct Group {
    id: i32,
    count: u32,
    /// The mean so far.
    distance: f64,
    cosines: f64,
    certainty: u8,
}

/// The shares of linear red, green and blue in the luminance (ITU-R BT.709).
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Beams whose echoes one job finds.
const BEAMS_PER_JOB: usize = 1 << 8;

impl Echoes {
    /// The echoes of whole beams of `lidar`, the first with the number `first`, of the hits of their rays on
    /// `spheres`. `None` for hits without normals, and for beams whose echoes are not measured.
    #[must_use]
    pub fn new(lidar: &Lidar, first: u64, rays: &Rays<'_>, hits: &Hits, spheres: &Spheres) -> Option<Self> {
        let (beam, normals) = (lidar.echoes()?, hits.normal.as_ref()?);
        let size = beam.rays() as usize;
        let count = rays.len() / size;
        let echoes = |n: usize| {
            let mut groups = groups(n * size..(n + 1) * size, rays, hits, normals);
            groups.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.id.cmp(&b.id)));
            groups.truncate(usize::from(beam.returns));
            let (number, total) = (first + n as u64, groups.len() as u8);
            let [ring, column] = [number / u64::from(lidar.azimuths()), number % u64::from(lidar.azimuths())];
            groups.into_iter().zip(1..).map(move |(group, return_number)| {
                let distance = (group.distance + noise(beam, number, return_number)).clamp(0.0, f64::MAX);
                let light = group.cosines * reflectance(spheres, group.id) / size as f64;
                Echo {
                    ring: ring as u32,
                    column: column as u32,
                    return_number,
                    number_of_returns: total,
                    id: group.id,
                    distance,
                    position: rays.at(n * size, distance),
                    intensity: light as f32,
                    certainty: if beam.noise > 0.0 { u8::MAX } else { group.certainty },
                }
            })
        };
        let all =
            parallel::collect(count, BEAMS_PER_JOB, &|beams, all| beams.for_each(|beam| all.extend(echoes(beam))));
        Some(Self { beams: count as u64, all })
    }
}

/// The hits of the rays with these numbers, by their spheres.
fn groups(numbers: Range<usize>, rays: &Rays<'_>, hits: &Hits, normals: &[[f32; 3]]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for n in numbers.filter(|n| hits.id[*n] >= 0) {
        let id = hits.id[n];
        let place = groups.iter().position(|group| group.id == id).unwrap_or_else(|| {
            groups.push(Group { id, count: 0, distance: 0.0, cosines: 0.0, certainty: 0 });
            groups.len() - 1
        });
        let group = &mut groups[place];
        group.count += 1;
        group.distance += (hits.distance[n] - group.distance) / f64::from(group.count);
        let normal = DVec3::from_array(normals[n].map(f64::from));
        group.cosines += (-normal.dot(DVec3::from_array(rays.directions[n]))).clamp(0.0, 1.0);
        group.certainty = group.certainty.max(hits.certainty[n]);
    }
    groups
}

/// The luminance of a sphere's colour, 0 to 1.
fn reflectance(spheres: &Spheres, id: i32) -> f64 {
    let color = color_of(spheres.colors.as_deref(), id as u32);
    f64::from(Vec3::from_array(color).dot(LUMINANCE).clamp(0.0, 1.0))
}

/// The noise of an echo: a normal number of Box and Muller's method, whose uniform ones are a hash of the seed, the beam and
/// the echo.
fn noise(beam: &Beam, number: u64, echo: u8) -> f64 {
    if beam.noise == 0.0 {
        return 0.0;
    }
    let hash = pcg4d([number as u32, (number >> 32) as u32, echo.into(), beam.seed]);
    // Between 0 and 1, and neither.
    let [radius, turn, ..] = hash.map(|bits| (f64::from(bits) + 0.5) / 2f64.powi(32));
    beam.noise * (-2.0 * radius.ln()).sqrt() * (TAU * turn).cos()
}
