//! The promise of parts: the frame of what is left of any parts of a scene, combined in any order and with repetitions, has the
//! bits of the frame of all spheres.

use crate::adapter::{cpu, renderers};
use crate::amount::amount;
use crate::bits::differing;
use crate::cloud::cloud;
use crate::oblique::vfov;
use crate::rng::Rng;
use crate::stream::{scene, scenes, settings};
use halfline::camera::{Camera, Lens};
use halfline::error::Error;
use halfline::frame::{Aov, Data, Frame};
use halfline::render::Renderer;
use halfline::render::stream::{Part, Stream};
use halfline::scene::{ImagePlane, Scene, Spheres};
use halfline::settings::{Accuracy, Settings, Tolerance};
use halfline::window::Window;
use std::ops::Range;

/// The part of the spheres in a range, in blocks, whose ids are their places and `shift` more.
fn part(scene: &Scene, settings: &Settings, range: Range<usize>, shift: u64) -> Part {
    let mut stream = Stream::of_part(scene, settings, range.start as u64 + shift).expect("a stream");
    for first in range.clone().step_by(600) {
        let mut block = Spheres::default();
        for n in first..(first + 600).min(range.end) {
            let color = scene.spheres.colors.as_ref().map(|colors| colors[n]);
            block.push(scene.spheres.centers[n], scene.spheres.radii[n], color);
        }
        stream.add(&block).expect("a block");
    }
    let mut part = stream.part().expect("a part");
    part.name = format!("{range:?}");
    part
}

/// Ranges that have all spheres: `count` that follow each other, and some that repeat or overlap them.
fn ranges(rng: &mut Rng, spheres: usize, count: usize) -> Vec<Range<usize>> {
    let mut cuts: Vec<usize> = (1..count).map(|_| (rng.unit() * spheres as f64) as usize).collect();
    cuts.sort_unstable();
    let starts = [0].into_iter().chain(cuts.iter().copied());
    let mut ranges: Vec<_> = starts.zip(cuts.iter().copied().chain([spheres])).map(|(a, b)| a..b).collect();
    for _ in 0..count.min(4) {
        let again = ranges[(rng.unit() * count as f64) as usize].clone();
        ranges.push(again.start.saturating_sub(17)..again.end);
        ranges.push(again);
    }
    ranges
}

/// Combines parts by pairs that chance chooses, until one is left.
fn by_chance(rng: &mut Rng, mut parts: Vec<Part>) -> Part {
    while parts.len() > 1 {
        let mut taken = || parts.swap_remove((rng.unit() * parts.len() as f64) as usize);
        let (a, b) = (taken(), taken());
        parts.push(a.combine(&b).expect("parts of one frame"));
    }
    parts.remove(0)
}

fn rendered(part: Part, renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> (Frame, String) {
    let visible = part.visible(scene, settings).expect("the frame of the part");
    let mut frame = renderer.render(&visible.scene, settings).expect("a frame");
    visible.ids.restore(&mut frame);
    (frame, visible.scene.fingerprint())
}

fn check(what: &str, renderer: &mut Renderer, scene: &Scene, settings: &Settings, counts: &[usize]) {
    let whole = renderer.render(scene, settings).expect("a frame");
    for &count in counts {
        let mut rng = Rng::new(count as u64);
        let ranges = ranges(&mut rng, scene.spheres.len(), count);
        let parts: Vec<_> = ranges.iter().map(|range| part(scene, settings, range.clone(), 0)).collect();
        for turn in 0..2 {
            let all = match turn {
                0 => by_chance(&mut rng, parts.clone()),
                _ => {
                    let (last, before) = parts.split_last().expect("a part");
                    last.clone().combine_all(before.iter().rev().cloned().map(Ok)).expect("parts of one frame")
                }
            };
            assert_eq!((all.count(), all.gaps()), (scene.spheres.len() as u64, None), "{what}");
            let kept = all.ids().len();
            let (frame, fingerprint) = rendered(all, renderer, scene, settings);
            let differing = differing(&whole, &frame);
            assert!(differing.is_empty(), "{what}, {count} parts, turn {turn}: {differing:?} differ");
            let counts = |frame: &Frame| (frame.report.spheres, frame.report.hits, frame.report.settled);
            assert_eq!(counts(&whole), counts(&frame), "{what}");
            assert_eq!(fingerprint, scene.fingerprint(), "{what}");
            if turn == 0 {
                println!("{what}: {kept} of {} spheres are left of {count} parts", scene.spheres.len());
            }
        }
    }
}

/// The scenes of the tests of streams, and one with a principal point beside the image.
fn cases() -> Vec<(&'static str, Scene)> {
    let lens = Lens::Intrinsics { fx: 90.0, fy: 95.0, cx: -11.25, cy: 30.0 };
    let off_center = scene([3.0, 2.0, 4.0], lens, cloud(21, 3000, [0.0; 3], 2.0, 0.06));
    scenes().into_iter().chain([("a principal point beside the image", off_center)]).collect()
}

#[test]
fn any_parts_in_any_order_give_the_frame_of_all() {
    for (what, scene) in cases() {
        check(what, &mut cpu(), &scene, &settings(), &[1, 2, 7, 64]);
    }
}

/// Jobs that run at once lower the same limits; what they lose would be kept.
#[test]
fn what_is_kept_does_not_depend_on_chance() {
    let all = scene([3.0, 2.0, 4.0], vfov(40.0), cloud(5, 40_000, [0.0; 3], 1.0, 0.015));
    let kept = || {
        let mut stream = Stream::of_part(&all, &settings(), 0).expect("a stream");
        stream.add(&all.spheres).and_then(|()| stream.part()).expect("a part").ids().to_vec()
    };
    let first = kept();
    assert!(4 * first.len() < all.spheres.len(), "{} are kept", first.len());
    // With stores that may overwrite a lesser one, one set in some hundreds is another.
    for turn in 0..amount("times that a set is kept", [100, 300, 1000]) {
        assert!(kept() == first, "turn {turn}");
    }
}

#[test]
fn on_every_device_too() {
    for (_, mut renderer) in renderers() {
        for (what, scene) in cases() {
            check(what, &mut renderer, &scene, &settings(), &[5]);
        }
    }
}

#[test]
fn with_windows_samples_lines_and_tolerances_too() {
    let window = Some(Window { x0: 13, y0: 21, x1: 66, y1: 44 });
    let tolerance = |x| Some(Tolerance::new(x).expect("a tolerance"));
    for (what, scene) in cases() {
        for settings in [
            Settings { window, ..settings() },
            Settings { samples: 4, seed: 5, depth_cue: true, ..settings() },
            Settings { samples: 16, silhouette: true, window, ..settings() },
            Settings { tolerance: tolerance(0.3), ..settings() },
            Settings { tolerance: tolerance(1e-7), silhouette: true, ..settings() },
        ] {
            check(what, &mut cpu(), &scene, &settings, &[3]);
        }
        if scene.spheres.len() < 100 {
            check(what, &mut cpu(), &scene, &Settings { accuracy: Accuracy::Exact, ..settings() }, &[3]);
        }
    }
}

#[test]
fn ids_may_be_wide_and_have_gaps() {
    let (_, scene) = scenes().swap_remove(0);
    let first = (1 << 31) + 12_345;
    let count = scene.spheres.len();
    let parts = [0..count / 2, count / 2 + 9..count].map(|range| part(&scene, &settings(), range, first));
    let [a, b] = &parts;
    let all = b.clone().combine(a).expect("parts of one frame");
    assert_eq!(
        all.all_ids(),
        [[first, first + count as u64 / 2], [first + count as u64 / 2 + 9, first + count as u64]]
    );
    let gaps = all.gaps().expect("gaps");
    assert_eq!(gaps, format!("no part has the {} spheres with ids 0 to {}, and 1 more gaps", first + 9, first - 1));
    let (frame, fingerprint) = rendered(all, &mut cpu(), &scene, &settings());
    let mut with_gap = scene.clone();
    for n in count / 2..count / 2 + 9 {
        with_gap.spheres.centers.to_mut()[n] = [0.0, 0.0, 1e3];
    }
    let whole = cpu().render(&with_gap, &settings()).expect("a frame");
    assert_eq!(fingerprint.len(), 32);
    let Some(Data::I64(ids)) = frame.get(Aov::Id).map(|buffer| &buffer.data) else { panic!("wide ids") };
    let expected: Vec<i64> =
        whole.ids().iter().map(|id| if *id < 0 { -1 } else { i64::from(*id) + first as i64 }).collect();
    assert_eq!(*ids, expected);
}

#[test]
fn a_part_is_its_arrays_and_damage_is_found() {
    let (_, scene) = scenes().swap_remove(0);
    let whole = part(&scene, &settings(), 100..900, 0);
    let made = |about: &str, ids: Vec<u64>, radii: Vec<f64>| {
        let spheres = Spheres { radii: radii.into(), ..whole.spheres().clone() };
        Part::new("p.npz".into(), about.as_bytes(), ids, spheres)
    };
    let (about, ids, radii) = (whole.about(), whole.ids().to_vec(), whole.spheres().radii.to_vec());
    let again = made(&about, ids.clone(), radii.clone()).expect("the same part");
    assert_eq!((again.about(), again.view()), (about.clone(), whole.view()));
    assert_eq!(again.spheres(), whole.spheres());
    let is_damaged = |about: &str, ids: &[u64], radii: &[f64]| {
        let error = made(about, ids.to_vec(), radii.to_vec()).expect_err("a damaged part");
        assert!(matches!(error, Error::Scene { .. }) && error.to_string().contains("p.npz"), "{error}");
    };
    let mut other = radii.clone();
    other[3] *= 1.001;
    is_damaged(&about, &ids, &other);
    is_damaged(&about, &ids[1..], &radii);
    let mut other = ids.clone();
    other[3] += 1;
    is_damaged(&about, &other, &radii);
    is_damaged(&about[1..], &ids, &radii);
    is_damaged(&about.replace("of a part, 1", "of a part, 2"), &ids, &radii);
    is_damaged(&about.replace("\"x1\":77", "\"x1\":78"), &ids, &radii);
}

#[test]
fn parts_of_other_frames_and_spheres_are_refused() {
    let (_, scene) = scenes().swap_remove(0);
    let whole = part(&scene, &settings(), 0..300, 0);
    let refused = |other: &Part, what: &str| {
        let error = whole.clone().combine(other).expect_err(what).to_string();
        assert!(error.contains(what) && error.contains("0..300") && error.contains(&other.name), "{error}");
    };
    let turned = Scene { camera: Camera { lens: vfov(41.0), ..scene.camera }, ..scene.clone() };
    let larger = Scene { image: ImagePlane { width: 78, ..scene.image }, ..scene.clone() };
    let window = Some(Window { x0: 0, y0: 0, x1: 9, y1: 9 });
    refused(&part(&turned, &settings(), 300..400, 0), "camera");
    refused(&part(&larger, &settings(), 300..400, 0), "size");
    refused(&part(&scene, &Settings { window, ..settings() }, 300..400, 0), "window");
    refused(&part(&scene, &Settings { samples: 4, ..settings() }, 300..400, 0), "number of samples");
    let loose = Some(Tolerance::new(1e-3).expect("a tolerance"));
    refused(&part(&scene, &Settings { tolerance: loose, ..settings() }, 300..400, 0), "tolerance");
    let seeded = |seed| part(&scene, &Settings { samples: 4, seed, ..settings() }, 300..400, 0);
    let error = seeded(1).combine(&seeded(2)).expect_err("other samples").to_string();
    assert!(error.contains("seed is 1, and 2"), "{error}");
    let older = whole.about().replace(env!("CARGO_PKG_VERSION"), "0.0.9");
    let (ids, spheres) = (whole.ids().to_vec(), whole.spheres().clone());
    let older = Part::new("old".into(), older.as_bytes(), ids, spheres).expect("a part");
    refused(&older, "version of halfline");
    // Spheres that both keep, and one that both have forgotten.
    let hidden = (0..300).find(|id| whole.ids().binary_search(id).is_err()).expect("a hidden sphere") as usize;
    for n in [whole.ids()[150] as usize, hidden] {
        let mut other = scene.clone();
        other.spheres.radii.to_mut()[n] *= 0.99;
        refused(&part(&other, &settings(), 0..300, 0), "different spheres");
    }
    let mut bare = scene.clone();
    bare.spheres.colors = None;
    refused(&part(&bare, &settings(), 300..400, 0), "colours");
}

#[test]
fn a_part_is_for_one_frame() {
    let (_, scene) = scenes().swap_remove(0);
    let sampled = || part(&scene, &Settings { samples: 4, seed: 3, ..settings() }, 0..300, 0);
    let refused = |scene: &Scene, settings: Settings, what: &str| {
        let error = sampled().visible(scene, &settings).expect_err(what).to_string();
        assert!(error.contains(what), "{error}");
    };
    let turned = Scene { camera: Camera { lens: vfov(41.0), ..scene.camera }, ..scene.clone() };
    let of = |samples, seed| Settings { samples, seed, ..settings() };
    refused(&turned, of(4, 3), "camera");
    refused(&scene, of(4, 4), "seed");
    refused(&scene, of(9, 3), "samples");
    refused(&scene, Settings { tolerance: Some(Tolerance::new(1e-3).expect("a tolerance")), ..of(4, 3) }, "tolerance");
    refused(&scene, Settings { aovs: vec![Aov::Occlusion], ..of(4, 3) }, "all spheres in memory");
    for settings in [of(4, 3), of(1, 0), Settings { tolerance: Some(Tolerance::new(1e-7).expect("one")), ..of(4, 3) }] {
        sampled().visible(&scene, &settings).expect("a frame of the part");
    }
}

/// Negative control: without one of the parts the frame is another.
#[test]
fn a_lost_part_is_found() {
    let (_, scene) = scenes().swap_remove(0);
    let whole = cpu().render(&scene, &settings()).expect("a frame");
    let without = part(&scene, &settings(), 0..scene.spheres.len() - 500, 0);
    let (frame, _) = rendered(without, &mut cpu(), &scene, &settings());
    assert!(!differing(&whole, &frame).is_empty());
}
