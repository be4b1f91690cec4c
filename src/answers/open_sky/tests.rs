use super::*;
use crate::scene::camera::Camera;
use crate::scene::{Gradient, ImagePlane, Lighting, Scene, Sky, SkyColors, Spheres};
use crate::testing::Rng;
use std::f32::consts::TAU;

const MOST: Smoothing = Smoothing::of(1);

/// The window from column `x0` and row `y0` on.
fn window([x0, y0]: [u32; 2], [width, height]: [u32; 2]) -> Window {
    Window { x0, y0, x1: x0 + width, y1: y0 + height }
}

/// A window whose pixels show these spheres and have these hits.
fn sky(window: Window, pixel: impl Fn(u32, u32) -> (u32, SkyAtHit), smoothing: Smoothing) -> OpenSky {
    let places = (window.y0..window.y1).flat_map(|row| (window.x0..window.x1).map(move |column| [row, column]));
    let (mut ids, mut all) = (Vec::new(), [Vec::new(), Vec::new()]);
    for [row, column] in places {
        let (id, hit) = pixel(row, column);
        let mut numbers = [vec![0; 3], vec![0; SkySums::count(false)]];
        let [normal, sum] = &mut numbers;
        hit.write(normal, sum);
        ids.push(id);
        all.iter_mut().zip(numbers).for_each(|(all, numbers)| all.extend(numbers));
    }
    // Memory of an earlier frame, with numbers that would show.
    let pool = Pool::default();
    [6, 6].iter().for_each(|each| pool.put_back(vec![i16::MAX; each * ids.len()]));
    OpenSky::new(window, ids, all, smoothing, &pool).expect("room")
}

/// A hit with this normal, one ray along it, and this part of the ray open.
fn hit(normal: DVec3, open: f64) -> SkyAtHit {
    SkyAtHit { normal, sums: SkySums { all: normal, open: normal * open, rays: 1, ..SkySums::default() } }
}

fn share(sky: &OpenSky, row: u32, column: u32, id: u32) -> f64 {
    sky.around(row, column, id).light(DVec3::Z, None).x
}

/// Rays in random directions above random normals, on spheres at random.
fn random_pixel(seed: u64, row: u32, column: u32, open: impl Fn(&mut Rng) -> bool) -> (u32, SkyAtHit) {
    let mut rng = Rng(seed + u64::from(row) * 1000 + u64::from(column) + 1);
    rng.bits();
    let mut sums = SkySums::default();
    for _ in 0..4 {
        let direction = DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(0.1, 1.0)).normalize();
        sums.add(direction, None);
        if open(&mut rng) {
            sums.add_open(direction, None);
        }
    }
    let tilt = DVec3::new(rng.between(-0.3, 0.3), rng.between(-0.3, 0.3), 1.0).normalize();
    ((row / 5 + column / 7) % 3, SkyAtHit { normal: tilt, sums })
}

#[test]
fn an_open_window_is_exactly_open_and_a_hidden_one_exactly_hidden() {
    for (is_open, expected) in [(true, 1.0), (false, 0.0)] {
        let sky = sky(window([3, 9], [40, 30]), |row, column| random_pixel(1, row, column, |_| is_open), MOST);
        for row in 9..39 {
            for column in 3..43 {
                for id in 0..4 {
                    let light = sky.around(row, column, id).light(DVec3::new(0.1, -0.2, 0.9).normalize(), None);
                    assert_eq!(light, DVec3::splat(expected), "{row} {column} {id}");
                }
            }
        }
    }
}

#[test]
fn a_crop_with_its_margin_has_the_numbers_of_the_frame() {
    let pixel = |row: u32, column: u32| random_pixel(2, row, column, |rng| rng.below(2) == 0);
    let frame = sky(window([0, 0], [64, 48]), pixel, MOST);
    let margin = MOST.margin();
    let part = window([20, 17], [9, 8]);
    let crop = sky(part.grown(margin, 64, 48), pixel, MOST);
    for row in part.y0..part.y1 {
        for column in part.x0..part.x1 {
            let id = pixel(row, column).0;
            assert_eq!(frame.around(row, column, id), crop.around(row, column, id), "{row} {column}");
        }
    }
    let narrow = sky(part.grown(margin - 1, 64, 48), pixel, MOST);
    let differs = |row: u32, column: u32| {
        let id = pixel(row, column).0;
        frame.around(row, column, id) != narrow.around(row, column, id)
    };
    assert!((part.y0..part.y1).any(|row| (part.x0..part.x1).any(|column| differs(row, column))), "all of it is needed");
}

#[test]
fn a_window_may_be_narrower_than_the_steps() {
    for size in [[1, 1], [3, 2], [1, 30], [30, 1], [4, 5]] {
        let sky = sky(window([5, 6], size), |row, column| (9, random_pixel(4, row, column, |_| true).1), MOST);
        assert_eq!(share(&sky, 6, 5, 9), 1.0, "{size:?}");
        assert_eq!(share(&sky, 6 + size[1], 5, 9), 1.0, "a sample below {size:?}");
        assert_eq!(sky.around(100, 100, 9), SkySums::default(), "far away no pixel has rays");
    }
}

/// A pattern that repeats after 8 pixels, as interleaved directions do, is gone; in the middle of a window, where every pixel has all its
/// neighbours.
#[test]
fn a_pattern_of_the_interleaved_directions_vanishes() {
    let mut rng = Rng(3);
    let pattern: Vec<f64> = (0..64).map(|_| 0.5 + rng.between(-0.05, 0.05)).collect();
    let mean = pattern.iter().sum::<f64>() / 64.0;
    let pixel = |row: u32, column: u32| (0, hit(DVec3::Z, pattern[(row % 8 * 8 + column % 8) as usize]));
    let found = |smoothing: Smoothing| {
        let sky = sky(window([0, 0], [48, 48]), pixel, smoothing);
        let off = |n: u32| (share(&sky, 16 + n / 16, 16 + n % 16, 0) - mean).abs();
        (0..256).map(off).fold(0.0, f64::max)
    };
    let (all, two) = (found(MOST), found(Smoothing(&[1, 2])));
    println!("a pattern of 0.05: {all:e} after all steps, {two:e} after two");
    // Pixels with unlike shares count less in the widest step: (0.05/0.15)^2 of a tenth of the pattern at the most.
    assert!(all < 1e-3 && two > 10.0 * all, "{all} {two}");
}

#[test]
fn spheres_and_distant_normals_do_not_mix() {
    // The left half shows an open sphere, the right half a hidden one.
    let halves = |_: u32, column: u32| if column < 16 { (1, hit(DVec3::Z, 1.0)) } else { (2, hit(DVec3::Z, 0.0)) };
    let mixed = sky(window([0, 0], [32, 16]), halves, MOST);
    assert!((0..16).all(|row| (0..16).all(|column| share(&mixed, row, column, 1) == 1.0)));
    assert!((0..16).all(|row| (16..32).all(|column| share(&mixed, row, column, 2) == 0.0)));
    // A sample that shows another sphere than the centre of its pixel takes the sums of its neighbours, and one that no centre
    // near it shows takes the sums of all.
    assert_eq!(share(&mixed, 8, 16, 1), 1.0);
    assert_eq!(share(&mixed, 8, 15, 2), 0.0);
    assert!((0.3..0.7).contains(&share(&mixed, 8, 15, 7)));
    // One sphere with an edge of 45 degrees.
    let slope = DVec3::new(0.5f64.sqrt(), 0.0, 0.5f64.sqrt());
    let edge = |_: u32, column: u32| if column < 16 { (1, hit(DVec3::Z, 1.0)) } else { (1, hit(slope, 0.0)) };
    let edge = sky(window([0, 0], [32, 16]), edge, MOST);
    assert!((0..16).all(|row| share(&edge, row, 15, 1) == 1.0 && share(&edge, row, 16, 1) == 0.0));
}

/// Rays of a point tell the share for the normals of its neighbours: without them a half-open sky would have the same share
/// for all of them.
#[test]
fn sums_follow_the_normal() {
    let mut sums = SkySums::default();
    for n in 0..4096 {
        let (height, angle) = ((n as f32 + 0.5) / 4096.0, n as f32 * TAU * 0.381_966);
        let along = (1.0 - height * height).sqrt();
        let direction = DVec3::new((along * angle.cos()).into(), (along * angle.sin()).into(), height.into());
        sums.add(direction, None);
        if direction.x > 0.0 {
            sums.add_open(direction, None);
        }
    }
    for degrees in [-20.0f64, -10.0, 0.0, 10.0, 20.0] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let found = sums.light(DVec3::new(sine, 0.0, cosine), None).x;
        // The wedge between the plane x = 0 and the horizon of the normal, weighted by the cosine: (1 + sin)/2. The sums keep
        // the half space of the first normal: (1 + tan)/2.
        let expected = f64::midpoint(1.0, degrees.to_radians().tan());
        assert!((found - expected).abs() < 2e-3, "{degrees}: {found} {expected}");
        assert!((found - f64::midpoint(1.0, sine)).abs() < 0.013, "{degrees}: {found}");
    }
}

/// Vectors of every kind give the light of single pixels, to the last bit: of skies with colours and without, normals in any direction, and
/// sums of nothing.
#[test]
fn lanes_have_the_light_of_single_pixels() {
    let mut scene = Scene {
        camera: Camera::CANONICAL,
        image: ImagePlane::default(),
        spheres: Spheres::default(),
        lighting: Lighting::default(),
    };
    let colors = SkyColors { zenith: [0.1, 0.3, 1.0], horizon: [1.0, 0.6, 0.5], is_shown: true };
    scene.lighting.sky = Some(Sky { colors: Some(colors), ..Sky::default() });
    let colored = Gradient::of(&scene).map(SkyLight::new);
    let mut rng = Rng(11);
    for round in 0..2000 {
        let mut vector = || DVec3::from_array([(); 3].map(|()| rng.between(-1.0, 1.0)));
        let none = round % 7 == 0;
        let pixels: [(SkySums, DVec3); LANES] = std::array::from_fn(|_| {
            let [all, open] = [vector(), vector()].map(|sum| if none { DVec3::ZERO } else { sum });
            (SkySums { all, open, zenith: [vector(), vector()], rays: 1 }, vector().normalize())
        });
        let mut sums = [[[0.0; LANES]; 3]; 4];
        pixels.iter().enumerate().for_each(|(l, (own, _))| own.write_lane(&mut sums, l));
        let normal = [0, 1, 2].map(|k| pixels.map(|(_, normal)| normal[k]));
        for colors in [None, colored.as_ref()] {
            let loops = light_of_lanes(&sums, &normal, colors);
            let widest = vectorized!(light_of_lanes(&sums, &normal, colors));
            #[cfg(target_arch = "x86_64")]
            if let Some(avx2) = pulp::x86::V3::try_new() {
                let avx2 = avx2.vectorize(
                    #[inline(always)]
                    || light_of_lanes(&sums, &normal, colors),
                );
                assert_eq!(avx2, loops);
            }
            assert_eq!(widest, loops);
            for (l, (own, normal)) in pixels.iter().enumerate() {
                let single = own.light(*normal, colors);
                assert_eq!(single.to_array(), [0, 1, 2].map(|k| f64::from(loops[k][l])), "{round} {l}");
            }
        }
    }
}
