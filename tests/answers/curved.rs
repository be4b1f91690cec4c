//! The promise of curved lenses: their frames have the buffers, the light, the lines and the layers of any other, proved as others are,
//! alike in crops and on every adapter.
//!
//! Gold standards: a lens without distortion has the rays of a pinhole, whose frames other code makes; of a fisheye and a panorama the
//! formulas of their rays and the quadratic, written here in f64; shadows by exact arithmetic over all spheres.

use crate::adapter::{cpu, renderers};
use crate::bits::{Bits, differing};
use crate::off_center::{SIZE, scene};
use glam::DVec3;
use halfline::camera::{Aperture, Curve, Lens};
use halfline::exact::{Judge, Toward};
use halfline::frame::{Aov, Data, Frame};
use halfline::intersect::Method;
use halfline::scene::{Light, LightSource, Material, Materials, Scene, Sky, SkyColors};
use halfline::settings::{Accuracy, AddedLight, Backend, Look, Settings};
use halfline::shade::Shade;
use halfline::window::Window;
use std::f64::consts::PI;

const FOCAL: f64 = 90.0;

fn middle() -> [f64; 2] {
    SIZE.map(|side| f64::from(side) / 2.0)
}

/// The lens of a pinhole, as a plane and as a model of OpenCV without distortion.
fn pinhole() -> [Lens; 2] {
    let ([cx, cy], curve) = (middle(), Curve::Distorted { k: [0.0; 6], p: [0.0; 2] });
    [Lens::Intrinsics { fx: FOCAL, fy: FOCAL, cx, cy }, Lens::Curved { curve, fx: FOCAL, fy: FOCAL, cx, cy }]
}

fn fisheye() -> Lens {
    let [cx, cy] = middle();
    Lens::Curved { curve: Curve::Fisheye { k: [0.0; 4] }, fx: 16.0, fy: 16.0, cx, cy }
}

/// Lenses with rays behind the eye, with pixels that have none, and with distortion.
fn lenses() -> [Lens; 3] {
    let [cx, cy] = middle();
    let curve = Curve::Distorted { k: [-0.2, 0.03, 0.0, 0.0, 0.0, 0.0], p: [2e-3, -1e-3] };
    [fisheye(), Lens::panorama(SIZE[0], SIZE[1]), Lens::Curved { curve, fx: 70.0, fy: 68.0, cx, cy }]
}

/// Spheres on all sides of an eye among them.
fn around(lens: Lens) -> Scene {
    let mut scene = scene(lens, SIZE);
    scene.camera.eye = DVec3::new(0.5, 0.25, 0.125);
    scene
}

fn lights() -> Vec<Light> {
    let white = |source, intensity| Light { source, color: [1.0, 0.9, 0.8], intensity };
    vec![
        white(LightSource::Direction(DVec3::new(0.3, 0.8, 0.5).normalize()), 0.6),
        white(LightSource::Point(DVec3::new(4.0, 6.0, 9.0)), 0.4),
    ]
}

/// A name, what is done to a scene, and the settings.
type Kind = (&'static str, fn(&mut Scene), Settings);

/// Pictures and buffers that need more than first hits.
fn kinds() -> Vec<Kind> {
    fn lamps(scene: &mut Scene) {
        scene.lighting.lights = lights();
        scene.lighting.shadows = true;
    }
    fn sky(scene: &mut Scene) {
        let colors = SkyColors { zenith: [0.3, 0.5, 1.0], horizon: [1.0, 0.9, 0.8], is_shown: true };
        scene.lighting.sky = Some(Sky { share: 0.5, colors: Some(colors), ..Sky::default() });
        lamps(scene);
    }
    fn soft(scene: &mut Scene) {
        let added = AddedLight { look: Look::Soft, ..AddedLight::default() };
        added.apply(scene, &[Aov::Color]).expect("a look");
    }
    fn mirrors(scene: &mut Scene) {
        let kinds = vec![Material::default(), Material::Metal { fuzz: 0.0 }, Material::Glass { index: 1.5 }];
        let of: Vec<u32> = (0..scene.spheres.len() as u32).map(|id| [1, 2, 0, 0, 0][id as usize % 5]).collect();
        scene.spheres.materials = Some(Materials { kinds, of: of.into() });
        sky(scene);
    }
    fn through(scene: &mut Scene) {
        (0..scene.spheres.len()).filter(|id| id % 3 != 0).for_each(|id| scene.spheres.set_opacity_from(id, 0.4));
    }
    fn layers_and_sky(scene: &mut Scene) {
        through(scene);
        sky(scene);
    }
    let of = |aovs: &[Aov]| Settings { aovs: aovs.to_vec(), ..Settings::default() };
    let answers = [Aov::Id, Aov::Distance, Aov::Position, Aov::Normal, Aov::Certainty, Aov::Mask, Aov::Color];
    let color = || of(&[Aov::Color, Aov::Alpha]);
    vec![
        ("answers", |_| {}, of(&answers)),
        ("shadow and occlusion", lamps, of(&[Aov::Shadow, Aov::Occlusion])),
        ("lights", lamps, color()),
        ("a sky", sky, color()),
        ("a sky and samples", sky, Settings { samples: 4, ..color() }),
        ("soft", soft, Settings { samples: 4, silhouette: true, ..color() }),
        ("lines", |_| {}, Settings { silhouette: true, samples: 4, ..color() }),
        ("normals as colours", |_| {}, Settings { shade: Shade::Normal, samples: 4, ..color() }),
        ("mirrors and glass", mirrors, color()),
        ("one layer", through, color()),
        ("three layers", through, Settings { layers: 3, ..color() }),
        ("lit layers", layers_and_sky, Settings { layers: 2, samples: 4, ..color() }),
        ("coverage", |_| {}, Settings { coverage: true, samples: 4, ..color() }),
    ]
}

/// The numbers of a buffer.
fn numbers(frame: &Frame, aov: Aov) -> Vec<f64> {
    match &frame.get(aov).unwrap_or_else(|| panic!("{aov:?}")).data {
        Data::F64(values) => values.clone(),
        Data::F32(values) => values.iter().map(|x| f64::from(*x)).collect(),
        Data::I32(values) => values.iter().map(|x| f64::from(*x)).collect(),
        Data::U8(values) => values.iter().map(|x| f64::from(*x)).collect(),
        _ => panic!("a new type of data"),
    }
}

/// A lens without distortion has the rays of a pinhole, but for roundings of f64, which decide nothing here. Numbers in f32 differ by their
/// roundings.
#[test]
fn a_lens_without_distortion_makes_the_frames_of_a_pinhole() {
    for (name, prepare, settings) in kinds() {
        let [plane, curved] = pinhole().map(|lens| {
            let mut scene = scene(lens, SIZE);
            prepare(&mut scene);
            cpu().render(&scene, &settings).unwrap_or_else(|error| panic!("{name}: {error}"))
        });
        assert_eq!(curved.report.search, "tree", "{name}");
        assert!(curved.report.hits > 2000, "{name}: {}", curved.report.hits);
        for buffer in plane.buffers.iter().filter(|buffer| buffer.aov != Aov::Certainty) {
            let (a, b) = (numbers(&plane, buffer.aov), numbers(&curved, buffer.aov));
            assert_eq!(a.len(), b.len(), "{name} {:?}", buffer.aov);
            // Normals of either are within 1e-3, and colours change with them by as much at most; distances are within 1e-5.
            let differ = |(a, b): &(&f64, &f64)| {
                !((*a - *b).abs() <= 3e-3 * a.abs().max(1.0) || a == b || a.is_nan() && b.is_nan())
            };
            let count = a.iter().zip(&b).filter(differ).count();
            let apart = |(a, b): (&f64, &f64)| if a == b { 0.0 } else { (a - b).abs() };
            let mean = a.iter().zip(&b).map(apart).filter(|x| !x.is_nan()).sum::<f64>() / a.len() as f64;
            // Lines go by gaps in the distance in place of the depth, and are a little darker or paler.
            let [share, most] = if settings.silhouette { [0.15, 5e-3] } else { [0.0, 1e-6] };
            let (all, aov) = (a.len(), buffer.aov);
            assert!(count as f64 <= share * all as f64 && mean <= most, "{name} {aov:?}: {count} of {all}, {mean}");
        }
        match (&plane.coverage, &curved.coverage) {
            (Some(a), Some(b)) => {
                let count = a.rows.iter().zip(&b.rows).filter(|(a, b)| a != b).count();
                assert!(count <= 2, "{name}: the samples of {count} rows");
            }
            (a, b) => assert!(a.is_none() && b.is_none(), "{name}"),
        }
    }
}

/// Crops have the pixels of the whole frame, and adapters the pixels of the CPU path.
#[test]
fn crops_and_adapters_agree_on_curved_lenses() {
    let crop = Window { x0: 13, y0: 9, x1: 61, y1: 44 };
    for lens in lenses() {
        for (name, prepare, settings) in kinds() {
            let mut scene = around(lens);
            prepare(&mut scene);
            let whole = cpu().render(&scene, &settings).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert!(whole.report.hits > 500, "{lens:?} {name}: {}", whole.report.hits);
            let part = Settings { window: Some(crop), ..settings.clone() };
            let part = cpu().render(&scene, &part).unwrap_or_else(|error| panic!("{name}: {error}"));
            for buffer in &part.buffers {
                let same = whole.bits_in(crop, buffer.aov) == part.bits(buffer.aov);
                assert!(same, "{lens:?} {name}: the crop of {:?}", buffer.aov);
            }
        }
    }
    for (backend, mut renderer) in renderers() {
        for (name, prepare, settings) in kinds() {
            let mut scene = around(fisheye());
            prepare(&mut scene);
            let settings = Settings { backend, ..settings };
            let [here, host] = [renderer.render(&scene, &settings), cpu().render(&scene, &settings)]
                .map(|frame| frame.unwrap_or_else(|error| panic!("{backend:?} {name}: {error}")));
            let other = differing(&here, &host);
            assert!(other.iter().all(|aov| *aov == Aov::Certainty), "{backend:?} {name}: {other:?}");
        }
    }
}

#[test]
fn a_frame_that_an_adapter_leaves_to_the_cpu_path_has_a_warning() {
    for (backend, mut renderer) in renderers() {
        let settings = Settings { backend, accuracy: Accuracy::Certified, ..Settings::default() };
        let report = renderer.render(&around(fisheye()), &settings).expect("a frame").report;
        let warns = report.warnings.iter().any(|warning| warning.contains("curved lenses"));
        assert_eq!((report.backend, warns), ("cpu", backend == Backend::Gpu), "{:?}", report.warnings);
    }
}

/// The direction of a pixel's ray: right, up and back; `None` beyond straight back.
fn direction(lens: Lens, [i, j]: [u32; 2]) -> Option<DVec3> {
    let [x, y] = [f64::from(j) + 0.5, f64::from(i) + 0.5];
    Some(match lens {
        Lens::Curved { curve: Curve::Fisheye { .. }, fx, cx, cy, .. } => {
            let (x, y) = ((x - cx) / fx, (y - cy) / fx);
            let angle = Some(x.hypot(y)).filter(|angle| *angle <= PI)?;
            DVec3::new(x / angle * angle.sin(), -y / angle * angle.sin(), -angle.cos())
        }
        _ => {
            let longitude = 2.0 * PI * (x / f64::from(SIZE[0]) - 0.5);
            let latitude = PI * (0.5 - y / f64::from(SIZE[1]));
            DVec3::new(latitude.cos() * longitude.sin(), latitude.sin(), -latitude.cos() * longitude.cos())
        }
    })
}

/// The first hit of a ray among all spheres, by the quadratic in f64, and the least of |1 - l/r|, where l is the distance of a centre from
/// the line.
fn brute_force(scene: &Scene, along: DVec3) -> (Option<(usize, f64)>, f64) {
    let (mut best, mut edge): (Option<(usize, f64)>, f64) = (None, f64::INFINITY);
    for (n, (center, radius)) in scene.spheres.centers.iter().zip(&*scene.spheres.radii).enumerate() {
        let p = DVec3::from_array(*center) - scene.camera.eye;
        let b = p.dot(along);
        let off = p.cross(along).length();
        edge = edge.min((1.0 - off / radius).abs());
        if off >= *radius {
            continue;
        }
        let root = (radius * radius - off * off).sqrt();
        let t = if p.length() > *radius { b - root } else { b + root };
        if t > 0.0 && best.is_none_or(|(_, first)| t < first) {
            best = Some((n, t));
        }
    }
    (best, edge)
}

#[test]
fn fisheyes_and_panoramas_show_what_their_formulas_say() {
    for lens in [fisheye(), Lens::panorama(SIZE[0], SIZE[1])] {
        let scene = around(lens);
        let aovs = vec![Aov::Id, Aov::Distance, Aov::Depth, Aov::Position, Aov::Bound];
        let frame = cpu().render(&scene, &Settings { aovs, ..Settings::default() }).expect("a frame");
        let basis = scene.camera.basis().expect("a basis");
        let [distance, depth, position] = [Aov::Distance, Aov::Depth, Aov::Position].map(|aov| numbers(&frame, aov));
        let mut compared = 0;
        for (pixel, id) in frame.ids().iter().enumerate() {
            let at = [pixel as u32 / SIZE[0], pixel as u32 % SIZE[0]];
            let Some(local) = direction(lens, at) else {
                assert_eq!(*id, -1, "{lens:?} {at:?}");
                continue;
            };
            let along = local.x * basis.u + local.y * basis.v + local.z * basis.w;
            let (hit, edge) = brute_force(&scene, along);
            // Directions differ by roundings, 1e-14 at most, which a length of 20 and a radius of 0.1 make 1e-12.
            if edge < 1e-9 {
                continue;
            }
            assert_eq!(*id, hit.map_or(-1, |(n, _)| n as i32), "{lens:?} {at:?}");
            compared += 1;
            let Some((_, t)) = hit else { continue };
            let near = |found: f64, expected: f64| (found - expected).abs() <= 2e-5 * t;
            assert!(near(distance[pixel], t) && near(depth[pixel], -local.z * t), "{lens:?} {at:?}");
            let place = scene.camera.eye + t * along;
            assert!((0..3).all(|k| near(position[3 * pixel + k], place[k])), "{lens:?} {at:?}");
        }
        assert!(compared > 5000, "{lens:?}: {compared} pixels");
    }
}

/// Shadows agree with exact arithmetic over all spheres, and the picture is what the lights that are seen give by Lambert's law.
#[test]
fn shadows_behind_a_curved_lens_are_exact() {
    for lens in lenses() {
        let mut scene = around(lens);
        scene.lighting.lights = lights();
        scene.lighting.shadows = true;
        let aovs = vec![Aov::Id, Aov::Shadow, Aov::Normal, Aov::Position, Aov::Color];
        let frame = cpu().render(&scene, &Settings { aovs, ..Settings::default() }).expect("a frame");
        let judge = Judge::new(&scene).expect("a judge");
        let [shadow, normal, position, color] =
            [Aov::Shadow, Aov::Normal, Aov::Position, Aov::Color].map(|aov| numbers(&frame, aov));
        let toward: Vec<Toward> = lights()
            .iter()
            .map(|light| match light.source {
                LightSource::Direction(direction) => Toward::Direction(direction.to_array()),
                LightSource::Point(place) => Toward::Point(place.to_array()),
                _ => panic!("two lights without a size"),
            })
            .collect();
        let (mut open, mut dark) = (0, 0);
        // Exact arithmetic over all spheres takes its time.
        for (pixel, id) in frame.ids().iter().enumerate().step_by(11) {
            let (i, j) = (pixel as u32 / SIZE[0], pixel as u32 % SIZE[0]);
            let hidden = judge.hidden(i, j, &toward);
            assert_eq!(hidden.is_some(), *id >= 0, "{lens:?} {i} {j}");
            let Some(hidden) = hidden else { continue };
            let of = |values: &[f64]| DVec3::from_slice(&values[3 * pixel..]);
            let own = DVec3::from_array(scene.spheres.colors.as_ref().expect("colours")[*id as usize].map(f64::from));
            let mut expected = DVec3::ZERO;
            for (n, (light, hidden)) in lights().iter().zip(hidden).enumerate() {
                assert_eq!(shadow[2 * pixel + n], f64::from(u8::from(hidden)), "{lens:?} {i} {j}: light {n}");
                let way = match light.source {
                    LightSource::Point(place) => (place - of(&position)).normalize(),
                    LightSource::Direction(direction) => direction,
                    _ => panic!("two lights without a size"),
                };
                if !hidden {
                    let color = DVec3::from_array(light.color.map(f64::from)) * f64::from(light.intensity);
                    expected += own * color * of(&normal).dot(way).max(0.0);
                    open += 1;
                } else {
                    dark += 1;
                }
            }
            // Normals of the buffer are within 1e-3, and so is each cosine.
            assert!((of(&color) - expected).abs().max_element() < 3e-3, "{lens:?} {i} {j}: {} {expected}", of(&color));
        }
        assert!(open > 30 && dark > 30, "{lens:?}: {open} {dark}");
    }
}

/// A method finds first hits without a proof, and the layers behind them are there too.
#[test]
fn layers_are_shown_by_a_method_too() {
    let (_, prepare, settings) = kinds().into_iter().find(|(name, ..)| *name == "three layers").expect("layers");
    let mut scene = around(fisheye());
    prepare(&mut scene);
    let by_method = Settings { method: Some(Method::Stable), ..settings.clone() };
    let [certified, by_method] = [settings, by_method].map(|settings| {
        let frame = cpu().render(&scene, &settings).expect("a frame");
        numbers(&frame, Aov::Alpha)
    });
    // At outlines f32 may see another sphere.
    let other = certified.iter().zip(&by_method).filter(|(a, b)| (*a - *b).abs() > 1e-6).count();
    assert!(other * 200 < certified.len(), "{other} of {}", certified.len());
    let several = certified.iter().filter(|alpha| **alpha > 0.7).count();
    assert!(several > 100, "{several} pixels show several layers");
}

#[test]
fn a_curved_lens_with_a_size_is_refused() {
    let aperture = Some(Aperture { diameter: 0.1, focus: None });
    let settings = Settings { aperture, samples: 16, aovs: vec![Aov::Color], ..Settings::default() };
    let error = cpu().render(&around(fisheye()), &settings).expect_err("it has one point").to_string();
    assert!(error.contains("lens with a size") && error.contains("fisheye"), "{error}");
}
