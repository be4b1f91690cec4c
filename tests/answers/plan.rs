//! The promise of a plan: it states what rendering does, and for a tolerance it chooses the cheapest sufficient method.

use crate::adapter::{cpu, gpu, gpu_or_skip, renderers};
use crate::amount::amount;
use crate::home::home;
use crate::weekend::weekend;
use halfline::camera::{Aperture, Curve, Lens};
use halfline::explain::{Explanation, explain};
use halfline::frame::Aov;
use halfline::intersect::Method;
use halfline::quote::setting::SIZE;
use halfline::report::Report;
use halfline::scene::Scene;
use halfline::settings::{Accuracy, Backend, Settings, Tolerance};
use std::collections::BTreeSet;

/// Eight spheres from 5 to 2000 radii away, without colours: as many as a method is chosen for.
fn scene() -> Scene {
    let mut scene = weekend();
    scene.spheres = Default::default();
    for n in 1..9 {
        let far = 5.0 * f64::from(n * n * n);
        scene.spheres.push([13.0 - far, 0.0, 0.0], 1.0, None);
    }
    scene.image.width = 40;
    scene.image.height = 24;
    scene
}

fn settings(backend: Backend, tolerance: Option<f64>, aovs: &[Aov]) -> Settings {
    let tolerance = tolerance.map(|x| Tolerance::new(x).expect("a tolerance"));
    Settings { backend, tolerance, aovs: aovs.to_vec(), ..Settings::default() }
}

fn planned(scene: &Scene, settings: &Settings) -> Explanation {
    explain(scene, settings).expect("a plan")
}

#[test]
fn a_tolerance_takes_the_cheapest_method_that_keeps_it() {
    let scene = scene();
    for (backend, mut renderer) in renderers() {
        let mut chosen = Vec::new();
        for tolerance in [10.0, 1e-1, 3e-3, 1e-9] {
            let settings = settings(backend, Some(tolerance), &[Aov::Color, Aov::Distance, Aov::Id]);
            let report = renderer.render(&scene, &settings).expect("a frame").report;
            let plan = planned(&scene, &settings);
            assert_eq!((report.method, report.accuracy, &report.reason), (plan.method, plan.accuracy, &plan.reason));
            assert_eq!(report.predicted, plan.predicted);
            match report.predicted {
                Some(predicted) => assert!(predicted.worst() <= tolerance, "{predicted:?}"),
                None => assert_eq!((report.accuracy, report.bound.map(|b| b <= tolerance)), ("certified", Some(true))),
            }
            chosen.push(report.method);
        }
        assert_eq!(chosen, ["textbook", "stable", "stable", "certified"], "{backend:?}");
    }
}

#[test]
fn without_a_tolerance_the_buffers_decide() {
    let scene = scene();
    for (aovs, method, word) in [
        (&[Aov::Color][..], "stable", "no buffer that holds answers"),
        (&[Aov::Color, Aov::Distance], "certified", "distance"),
    ] {
        let plan = planned(&scene, &settings(Backend::Cpu, None, aovs));
        assert_eq!(plan.method, method);
        assert!(plan.reason.contains(word), "{}", plan.reason);
    }
    // A horizon from 3 m above the ground: the method would be off by what can be seen.
    let mut near = scene.clone();
    near.spheres = Default::default();
    near.spheres.push([13.0, -6.4e6, 3.0], 6.4e6 - 1.0, None);
    let plan = planned(&near, &settings(Backend::Cpu, None, &[Aov::Color]));
    assert!(plan.accuracy == "certified" && plan.reason.contains("can be seen"), "{}", plan.reason);
    for aov in [Aov::Certainty, Aov::Bound, Aov::Normal] {
        let plan = planned(&scene, &settings(Backend::Cpu, Some(1.0), &[aov]));
        assert!(plan.accuracy == "certified" && plan.reason.contains(aov.name()), "{plan:?}");
    }
    let stated = Settings { accuracy: Accuracy::Fast, ..settings(Backend::Cpu, Some(1e-12), &[Aov::Id]) };
    assert_eq!(planned(&scene, &stated).method, "stable", "an accuracy that is given, for few spheres");
    let method = Settings { method: Some(Method::Unit), ..settings(Backend::Cpu, Some(1e-12), &[Aov::Id]) };
    assert_eq!(planned(&scene, &method).method, "unit");
    let mut empty = scene.clone();
    empty.spheres = Default::default();
    assert_eq!(planned(&empty, &settings(Backend::Cpu, Some(1e-12), &[Aov::Id])).accuracy, "fast");
}

#[test]
fn the_frame_has_the_planned_buffers() {
    let scene = scene();
    for (backend, mut renderer) in renderers() {
        for tolerance in [None, Some(0.1)] {
            let settings = settings(backend, tolerance, &[Aov::Color, Aov::Position, Aov::Mask]);
            let (plan, frame) = (planned(&scene, &settings), renderer.render(&scene, &settings).expect("a frame"));
            let made: Vec<_> = frame.buffers.iter().map(|b| (b.aov.name(), b.data.len() as u64)).collect();
            let of = |shown: &halfline::explain::Shown| (shown.name, shown.shape.iter().product::<u64>());
            assert_eq!(plan.frame.iter().map(of).collect::<Vec<_>>(), made);
            assert!(plan.frame.iter().all(|shown| shown.asked != (shown.name == "id")), "{:?}", plan.frame);
        }
    }
}

#[test]
fn the_plan_lists_what_is_uploaded_and_what_is_left_out() {
    let Some(renderer) = gpu_or_skip() else { return };
    let mut scene = scene();
    let uncertified = settings(Backend::Gpu, Some(0.1), &[Aov::Color]);
    let n = scene.spheres.len() as u64;
    let names = |plan: &Explanation| plan.uploaded.iter().map(|b| (b.name, b.bytes)).collect::<Vec<_>>();
    let plan = planned(&scene, &uncertified);
    assert_eq!(plan.adapter, renderer.adapter());
    assert_eq!(names(&plan), [("view", 160), ("spheres", 32 * n)]);
    assert!(plan.left_out.iter().any(|left| left.what == "sphere colours"), "{:?}", plan.left_out);
    let pixels = plan.rays;
    let written: Vec<_> = plan.written.iter().map(|b| (b.name, b.bytes)).collect();
    assert_eq!(written, [("frame_id", 4 * pixels), ("frame_color", 12 * pixels)]);
    assert!(plan.dispatches == 1 && plan.kernel.iter().any(|part| part.file == "form/stable.wgsl"));
    for part in &plan.kernel {
        let file = home().join("shaders").join(part.file);
        let text = std::fs::read_to_string(file).expect("a file of the kernel");
        assert_eq!(text.lines().count(), part.lines, "{}", part.file);
    }
    scene.spheres.colors = Some(vec![[0.5; 3]; scene.spheres.len()].into());
    let plan = planned(&scene, &uncertified);
    assert_eq!(names(&plan).last(), Some(&("colors", 12 * n)));
    assert!(!plan.left_out.iter().any(|left| left.what == "sphere colours"), "{:?}", plan.left_out);
    let plan = planned(&weekend(), &settings(Backend::Gpu, None, &[Aov::Distance]));
    let uploaded = names(&plan);
    assert_eq!(
        uploaded.iter().map(|b| b.0).collect::<Vec<_>>(),
        ["view", "projection", "placing", "resident", "generals_uniform"]
    );
    assert_eq!(uploaded[3], ("resident", 32 * plan.spheres));
    assert_eq!(uploaded[4], ("generals_uniform", 4 * 64), "a uniform of four general spheres");
    assert!(uploaded[..3].iter().map(|b| b.1).sum::<u64>() < 2048, "a camera: {uploaded:?}");
    let staged = plan.staged.expect("a certified frame is staged");
    assert_eq!(staged.front + staged.near + staged.unseen, plan.spheres);
    assert!(staged.unseen > 0 && (1..=4).contains(&staged.near), "{staged:?}");
    for step in ["place/place.wgsl", "splat/small.wgsl", "splat/large.wgsl", "main/certified.wgsl"] {
        assert!(plan.kernel.iter().any(|part| part.file == step), "{step}");
    }
}

#[test]
fn the_plan_says_how_many_spheres_fit() {
    let gpu = gpu().map(|_| Backend::Gpu);
    for backend in [Some(Backend::Cpu), gpu].into_iter().flatten() {
        for tolerance in [Some(0.1), Some(1e-12)] {
            let plan = planned(&scene(), &settings(backend, tolerance, &[Aov::Color]));
            let (fit, free) = (plan.room.host.unwrap_or(u64::MAX), plan.room.free.unwrap_or(u64::MAX));
            assert!(plan.room.needed < free && fit > plan.spheres && fit < free / 32, "{:?}", plan.room);
            assert_eq!(plan.room.adapter.is_some(), backend == Backend::Gpu);
            assert!(plan.room.adapter.is_none_or(|fit| fit > plan.spheres), "{:?}", plan.room);
            // A light frame: one dispatch, or by splat one that places the spheres and one for the pixels.
            let dispatches = if plan.search == "splat" { 2 } else { u64::from(backend == Backend::Gpu) };
            assert_eq!(plan.dispatches, dispatches, "{}", plan.search);
        }
        if backend == Backend::Gpu {
            let adapter = &halfline::adapters().expect("adapters")[0];
            let most = adapter.max_binding;
            let (mut colored, fast) = (scene(), settings(backend, Some(0.1), &[Aov::Color]));
            assert_eq!(planned(&colored, &fast).room.adapter, Some((most / 32).min(i32::MAX as u64)));
            colored.spheres.colors = Some(vec![[0.5; 3]; colored.spheres.len()].into());
            let certified = Settings { tolerance: None, accuracy: Accuracy::Certified, ..fast };
            let fit = planned(&colored, &certified).room.adapter.expect("an adapter");
            assert_eq!(fit, (most / 12).min(i32::MAX as u64), "colours are bound, the spheres are in blocks");
        }
    }
    // An image that no memory holds is refused, as by rendering.
    let mut wide = scene();
    (wide.image.width, wide.image.height) = (1 << 20, 1 << 20);
    let error = explain(&wide, &settings(Backend::Cpu, None, &[Aov::Color])).expect_err("too large").to_string();
    assert!(error.contains("bytes") && error.contains(SIZE), "{error}");
}

/// Up to eight spheres a method is chosen where it is good enough; beyond, the certified kernel, which `fast` does not settle.
#[test]
fn a_method_is_chosen_for_few_spheres_alone() {
    let few = scene();
    let mut more = few.clone();
    more.spheres.push([0.0, 40.0, 0.0], 1.0, None);
    let by = |accuracy| Settings { accuracy, ..settings(Backend::Cpu, None, &[Aov::Color]) };
    for (scene, accuracy, expected) in [
        (&few, Accuracy::Auto, ("fast", "stable", "all")),
        (&few, Accuracy::Fast, ("fast", "stable", "all")),
        (&more, Accuracy::Auto, ("certified", "certified", "tiles")),
        (&more, Accuracy::Fast, ("fast", "fast", "tiles")),
        (&more, Accuracy::Exact, ("exact", "exact", "exact")),
    ] {
        let plan = planned(scene, &by(accuracy));
        assert_eq!((plan.accuracy, plan.method, plan.search), expected, "{accuracy:?}: {}", plan.reason);
        assert_eq!(plan.staged.is_some(), plan.search == "tiles");
    }
    let form = Settings { method: Some(Method::Unit), ..by(Accuracy::Auto) };
    assert_eq!(planned(&weekend(), &form).search, "all", "a method tests every sphere");
}

/// The same scene through lenses of each kind, and with some or all spheres translucent.
fn of_each_kind() -> Vec<(Scene, Option<Aperture>)> {
    let through = |lens: Lens| {
        let mut scene = weekend();
        scene.camera.lens = lens;
        (scene, None)
    };
    let curved = |curve| through(Lens::Curved { curve, fx: 20.0, fy: 20.0, cx: 12.0, cy: 8.0 });
    let mut all = vec![(weekend(), None), (scene(), None)];
    all.push(through(Lens::Orthographic { height: 5.0 }));
    all.push(through(Lens::Vfov { degrees: 179.999_999, distance: 1.0 }));
    all.push(through(Lens::Intrinsics { fx: 20.0, fy: 20.0, cx: 3.0, cy: 5.0 }));
    all.push(curved(Curve::Distorted { k: [-0.1, 0.01, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] }));
    all.push(curved(Curve::Fisheye { k: [0.0; 4] }));
    all.push(curved(Curve::Panorama));
    all.push((weekend(), Some(Aperture { diameter: 0.1, focus: Some(10.0) })));
    for opaque in [0, 2] {
        let mut translucent = scene();
        let opacities = (0..translucent.spheres.len()).map(|n| if n < opaque { 1.0 } else { 0.5 });
        translucent.spheres.opacities = Some(opacities.collect::<Vec<f32>>().into());
        all.push((translucent, None));
    }
    all
}

/// The part of a report that is known before the frame is computed.
fn before(report: Report) -> impl PartialEq + std::fmt::Debug {
    let Report { backend, adapter, driver, backend_reason, accuracy, method, search, reason, .. } = report;
    let Report { samples, shade, layers, opacity_shadows, ghost_rim, tone, silhouette, outline, depth_cue, .. } =
        report;
    let place = (backend, adapter, driver, backend_reason, accuracy, method, search, reason, report.camera);
    (
        place,
        samples,
        shade,
        layers,
        (opacity_shadows, ghost_rim),
        tone,
        silhouette,
        outline,
        (depth_cue, report.lights, report.spheres),
    )
}

/// Backend, accuracy, method, samples, lenses, opacities and reasons, in every combination, or in every so many of them: what
/// `plan` and the report before rendering say is what the frame's report says.
#[test]
fn the_plan_is_what_is_rendered() {
    let (mut compared, mut combination) = (0, 0);
    // A number that has no divisor in common with the numbers of choices: every pair of choices occurs.
    let stride = 7 / amount("combinations of settings, in sevenths", [1, 1, 7]);
    for (backend, mut renderer) in renderers() {
        for (mut scene, aperture) in of_each_kind() {
            (scene.image.width, scene.image.height) = (24, 16);
            let crop = halfline::Window { x0: 3, y0: 2, x1: 19, y1: 11 };
            let accuracies = [Accuracy::Auto, Accuracy::Fast, Accuracy::Certified, Accuracy::Exact].map(|a| (a, None));
            let methods = Method::ALL.iter().map(|method| (Accuracy::Auto, Some(*method)));
            for (accuracy, method) in accuracies.into_iter().chain(methods) {
                for (aovs, samples, window, layers) in [
                    (&[Aov::Color][..], 1, None, 2),
                    (&[Aov::Color, Aov::Distance, Aov::Bound], 4, None, 0),
                    (&[Aov::Distance, Aov::Id], 1, None, 0),
                    (&[Aov::Normal, Aov::Color], 2, Some(crop), 1),
                ] {
                    combination += 1;
                    if combination % stride != 0 {
                        continue;
                    }
                    let settings = Settings {
                        backend,
                        accuracy,
                        method,
                        samples,
                        window,
                        layers,
                        aperture,
                        aovs: aovs.to_vec(),
                        ..Settings::default()
                    };
                    let planned = renderer.explain(&scene, &settings).map(|plan| {
                        let of_plan =
                            (plan.backend, plan.adapter, plan.accuracy, plan.method, plan.search, plan.reason);
                        (of_plan, plan.samples, plan.rays, plan.spheres, plan.predicted, plan.warnings)
                    });
                    let expected = renderer.dry_run(&scene, &settings).map(before);
                    let frame = renderer.render(&scene, &settings);
                    let rendered = frame.as_ref().map(|frame| {
                        let mut r = frame.report.clone();
                        // Only rendering can find that nothing is hit, and the pixels without a ray.
                        r.warnings.retain(|warning| !warning.contains(" hits ") && !warning.contains("no viewing ray"));
                        let of_frame = (r.backend, r.adapter, r.accuracy, r.method, r.search, r.reason);
                        (of_frame, r.samples, r.rays, r.spheres, r.predicted, r.warnings)
                    });
                    let rendered = rendered.map_err(ToString::to_string);
                    assert_eq!(
                        planned.map_err(|error| error.to_string()),
                        rendered,
                        "{settings:?} {:?}",
                        scene.camera.lens
                    );
                    let found = frame.map(|frame| before(frame.report)).map_err(|error| error.to_string());
                    assert_eq!(
                        expected.map_err(|error| error.to_string()),
                        found,
                        "{settings:?} {:?}",
                        scene.camera.lens
                    );
                    compared += 1;
                }
            }
        }
    }
    println!("{compared} plans compared with frames");
    assert!(compared > 60, "{compared}");
}

/// The printed shaders are complete: each is valid WGSL, and their banners are the files of the plan.
#[test]
fn the_printed_shaders_are_complete() {
    let colored = [Aov::Color, Aov::Distance, Aov::Id];
    let methods = Method::ALL.iter().filter(|method| !["f64", "double-float"].contains(&method.name()));
    let variants = methods.map(|method| Some(*method)).chain([None]);
    for (method, (backend, mut renderer)) in
        variants.flat_map(|variant| renderers().into_iter().map(move |r| (variant, r)))
    {
        for aovs in [&colored[..], &[Aov::Id], &[Aov::Normal, Aov::Bound]] {
            let (scene, settings) = (weekend(), Settings { method, ..settings(backend, None, aovs) });
            let text = renderer.wgsl(&scene, &settings).expect("shaders");
            // Each begins with its purpose and the first of its parts.
            let begin = "// ======== emitted: binding numbers ========";
            let shaders: Vec<_> = text.split(begin).skip(1).collect();
            assert_eq!(shaders.len(), if method.is_some() { 1 } else { 5 }, "{text}");
            for shader in shaders {
                let module = naga::front::wgsl::parse_str(shader);
                let module = module.unwrap_or_else(|e| panic!("{}", e.emit_to_string(shader)));
                let (flags, all) = (naga::valid::ValidationFlags::all(), naga::valid::Capabilities::all());
                naga::valid::Validator::new(flags, all).validate(&module).expect("valid WGSL");
            }
            let banners: BTreeSet<_> =
                text.lines().filter_map(|line| line.strip_prefix("// ======== shaders/")).collect();
            let plan = renderer.explain(&scene, &settings).expect("a plan");
            let files: Vec<_> = plan.kernel.iter().map(|part| format!("{} ========", part.file)).collect();
            let is_of_plan = files.is_empty() || banners == files.iter().map(String::as_str).collect();
            assert!(banners.len() > 5 && is_of_plan, "{banners:?} {files:?}");
        }
    }
    let exact = Settings { accuracy: Accuracy::Exact, ..settings(Backend::Cpu, None, &colored) };
    let error = cpu().wgsl(&weekend(), &exact).expect_err("no kernel").to_string();
    assert!(error.contains("without a kernel"), "{error}");
}
