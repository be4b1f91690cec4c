//! The closest hits of eight rays among all spheres: the twin of search/all.wgsl, each bit for bit as alone.

use crate::intersect::Intersect;
use crate::number::vector::{LANES, Laned, Vector};
use crate::number::{Arithmetic, Mask, TruthValue};
use crate::view::Sphere;
use crate::view::ray::{NONE, Ray};

/// The closest hits of eight rays.
#[derive(Clone, Copy)]
pub(crate) struct EightHits<N: Laned> {
    /// t in the frame's unit; [`Arithmetic::MISS`] on a miss.
    pub(crate) t: N::Vector,
    /// The spheres' indices in the scene's order; [`NONE`] on a miss.
    pub(crate) id: Vector<u32>,
}

/// Eight rays, by components.
#[inline(always)]
pub(crate) fn together<N: Laned>(rays: &[Ray<N>; LANES]) -> Ray<N::Vector> {
    Ray { d: [0, 1, 2].map(|k| N::gather(rays.map(|ray| ray.d[k]))) }
}

/// A sphere for each of eight rays, by components.
#[inline(always)]
pub(crate) fn spheres_together<N: Laned>(own: &[Sphere<N>; LANES]) -> Sphere<N::Vector> {
    let center_radius = [0, 1, 2, 3].map(|k| N::gather(own.map(|s| s.center_radius[k])));
    Sphere { center_radius, power: N::gather(own.map(|s| s.power)), scale: N::gather(own.map(|s| s.scale)) }
}

/// `yes` where the mask is set, else `no`.
#[inline(always)]
fn pick(mask: Vector<u32>, yes: u32, no: Vector<u32>) -> Vector<u32> {
    (Vector([yes; LANES]) & mask) | (no & !mask)
}

impl<N: Laned> EightHits<N> {
    /// No hit.
    pub(crate) const NONE: Self = Self { t: <N::Vector as Arithmetic>::MISS, id: Vector([NONE; LANES]) };

    /// The closest hits of the rays among `spheres`, each for all rays, in the order of their ids.
    #[inline(always)]
    pub(crate) fn among_all<V: Intersect>(
        ray: &Ray<N::Vector>,
        spheres: impl Iterator<Item = Sphere<N::Vector>>,
    ) -> Self {
        let mut hits = Self::NONE;
        for (id, s) in (0..).zip(spheres) {
            let t = V::intersect(ray, &s);
            let met = t.less(N::Vector::MISS);
            if met.any() {
                let t = t.scaled(s.scale);
                // Strict, so the lower id wins a tie.
                let closer = met & t.less(hits.t);
                hits.t = closer.pick(t, hits.t);
                hits.id = pick(N::narrow(closer), id, hits.id);
            }
        }
        hits
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intersect::{Method, Visit};
    use crate::number::Number;
    use crate::search::nearest::nearest_of;
    use crate::testing::Rng;
    use crate::view::{SphereRecord, SphereResiduals};

    /// Rays within this of the axis.
    const WIDTH: f64 = 0.1;

    /// A number and the rest that f32 leaves of it.
    fn parts(x: f64) -> [f32; 2] {
        [x as f32, (x - f64::from(x as f32)) as f32]
    }

    /// A sphere that many rays meet: in front, behind, around the eye, touching it, tiny, far and huge; the power of some is
    /// zero or subnormal.
    fn wild(rng: &mut Rng) -> (SphereRecord, SphereResiduals) {
        let radius = rng.decade(-3.0, 3.0);
        let away = match rng.below(4) {
            0 => radius * rng.unit(),
            1 => radius * (1.0 + rng.decade(-7.0, 0.0)),
            2 => radius * rng.decade(0.0, 2.0),
            _ => radius * rng.decade(0.0, 6.0),
        };
        let mut across = || rng.between(-WIDTH, WIDTH) * away;
        let center = [across(), across(), rng.between(-1.0, 0.2).signum() * away];
        let power = center.iter().map(|x| x * x).sum::<f64>() - radius * radius;
        let power = match rng.below(8) {
            0 => 0.0,
            1 => power.signum() * f64::from(f32::from_bits(1 + rng.below(1 << 22))),
            _ => power,
        };
        let numbers = [center[0], center[1], center[2], radius].map(parts);
        let (center_radius, rest) = (numbers.map(|n| n[0]), numbers.map(|n| n[1]));
        let scale = 2f32.powi(rng.below(21) as i32 - 10);
        let record = SphereRecord { center_radius, power: parts(power)[0], scale, unused: [0; 2] };
        (record, SphereResiduals { center_radius: rest, power: parts(power)[1], unused: [0.0; 3] })
    }

    /// Some spheres, the last of them again the first, and eight rays.
    fn world<R: Number>(rng: &mut Rng, count: usize) -> (Vec<Sphere<R>>, [Ray<R>; LANES]) {
        let mut spheres: Vec<_> = (0..count)
            .map(|_| {
                let (record, rest) = wild(rng);
                Sphere::with_residuals(&record, &rest)
            })
            .collect();
        spheres.extend_from_within(..count.min(4));
        let number = |x: f64| {
            let [high, low] = parts(x);
            R::from_hi_lo(high, low)
        };
        let rays = std::array::from_fn(|_| Ray {
            d: [rng.between(-WIDTH, WIDTH), rng.between(-WIDTH, WIDTH), -1.0].map(number),
        });
        (spheres, rays)
    }

    fn bits<R: Number>(t: R) -> [u32; 2] {
        let (high, low) = t.to_hi_lo();
        [high.to_bits(), low.to_bits()]
    }

    /// Compares the hits of eight rays together with the hits of each ray alone. Returns the number of hits, and of hits
    /// from inside.
    struct Compare(Rng);

    impl Visit for Compare {
        type Output = [usize; 2];

        fn visit<V: Intersect, N: Laned>(self) -> [usize; 2] {
            let mut rng = self.0;
            let mut counts = [0; 2];
            for n in 0..3000 {
                let (spheres, rays) = world::<N>(&mut rng, 1 + n % 9);
                let eight = together(&rays);
                let all = EightHits::<N>::among_all::<V>(&eight, spheres.iter().map(|s| s.map(N::splat)));
                for (l, ray) in rays.iter().enumerate() {
                    let what = format!("world {n}, ray {l}");
                    let one = nearest_of::<V, _>(ray, spheres.len(), |id| spheres[id]);
                    assert_eq!(all.id.0[l], one.id, "{what}");
                    assert_eq!(bits(N::lane(&all.t, l)), bits(one.t), "{what}");
                    if one.id != NONE {
                        counts[0] += 1;
                        counts[1] += usize::from(spheres[one.id as usize].power < N::ZERO);
                    }
                }
            }
            counts
        }
    }

    #[test]
    fn eight_rays_are_answered_as_one_by_one() {
        for method in Method::ALL {
            let [hits, inside] = method.dispatch(Compare(Rng(0x5eed_0042)));
            assert!(hits > 5000 && inside > 500, "{}: {hits} hits, {inside} from inside", method.name());
        }
    }
}
