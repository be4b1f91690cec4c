//! The bindings that naga finds in a shader; the shaders are their only declaration.

use crate::intersect::Method;
use crate::kernel::{Kernel, OUTPUT_BUFFERS};
use naga::valid::Capabilities;

/// A buffer or a texture that the shader binds in group 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Binding {
    /// Its name in WGSL.
    pub(crate) name: &'static str,
    /// Its number in WGSL.
    pub(crate) binding: u32,
}

/// The inputs of kernels by their WGSL names; the last two belong to the self-test.
const INPUTS: [&str; 33] = [
    "view",
    "spheres",
    "residuals",
    "colors",
    "rays",
    "nodes",
    "placed",
    "projection",
    "projected",
    "generals_storage",
    "generals_uniform",
    "planes",
    "placing",
    "block_pass",
    "resident",
    "summary",
    "pieces",
    "minima",
    "pairs",
    "starts",
    "sky",
    "places",
    "directions",
    "open",
    "picture",
    "sky_hits",
    "sky_sums",
    "sky_means",
    "patches",
    "patched",
    "picture_sums",
    "cases",
    "answers",
];

/// Every buffer that a shader binds, by its WGSL name. The binding number is the index in this list.
pub(crate) fn buffers() -> impl Iterator<Item = &'static str> {
    INPUTS.into_iter().chain(OUTPUT_BUFFERS)
}

/// The bindings that the entry point uses.
pub(crate) fn bindings(module: &naga::Module, info: &naga::valid::ModuleInfo) -> Vec<Binding> {
    let used = info.get_entry_point(0);
    let named = |(handle, global): (naga::Handle<naga::GlobalVariable>, &naga::GlobalVariable)| {
        let binding = global.binding?;
        let name = buffers().find(|b| Some(*b) == global.name.as_deref())?;
        (!used[handle].is_empty()).then_some(Binding { name, binding: binding.binding })
    };
    module.global_variables.iter().filter_map(named).collect()
}

/// The capabilities that `kernel` requires; it is validated with no others.
pub(crate) fn capabilities(kernel: &Kernel) -> Capabilities {
    if kernel.method() == Some(Method::Native64) { Capabilities::FLOAT64 } else { Capabilities::empty() }
}

#[cfg(test)]
mod tests {
    mod compilers;

    use super::*;
    use crate::certify::ProjectionRecord;
    use crate::certify::general::GeneralRecord;
    use crate::certify::placing::PlacingRecord;
    use crate::certify::projected::{ProjectedDetailRecord, ProjectedRecord};
    use crate::gpu::compose::{Part, Source, Step, compose, compose_step, files};
    use crate::gpu::input::GROUP;
    use crate::gpu::resident::steps::BlockPass;
    use crate::gpu::validate::validate;
    use crate::intersect::Method;
    use crate::kernel::{Certificate, Generals, RaySource, Task, Unproved};
    use crate::search::tree::device::{DEVICE_LEVELS, NodeRecord, PlacedSphereRecord, first};
    use crate::search::tree::lanes::{LANE, NEVER};
    use crate::shade::Shade;
    use crate::tile::TILE;
    use crate::view::ray::{NONE, RayRecord};
    use crate::view::{SphereRecord, SphereResiduals, ViewRecord};
    use rayon::prelude::*;
    use std::collections::BTreeSet;
    use std::mem::offset_of;
    use std::sync::LazyLock;

    /// Every kernel that a plan can select.
    fn kernels() -> Vec<Kernel> {
        let both = [false, true];
        let rays = [RaySource::Camera, RaySource::SharedOrigin, RaySource::Spread];
        let methods = Method::ALL.iter().flat_map(|&method| rays.map(|rays| Task::Method { method, rays }));
        let certified = [0, 1, 5].into_iter().map(Generals::of).flat_map(|generals| {
            let unproved = [Unproved::Unsure, Unproved::Nearest];
            unproved.into_iter().flat_map(move |unproved| {
                let task = move |depth_interval, starts, planes| {
                    Task::Certified(Certificate { generals, unproved, depth_interval, starts, planes })
                };
                // The host traces rays from the hits of cut spheres.
                let of_hits = [(false, false), (true, false), (false, true)];
                both.into_iter()
                    .flat_map(move |interval| of_hits.map(|(starts, planes)| task(interval, starts, planes)))
            })
        });
        let mut kernels = Vec::new();
        for task in methods.chain(certified) {
            for shade in [None, Some(Shade::Flat), Some(Shade::Normal), Some(Shade::Headlight)] {
                let colors = both.into_iter().filter(|c| !c || shade.is_some_and(Shade::needs_colors));
                for colors in colors {
                    for (t, normal) in both.into_iter().flat_map(|t| both.map(|normal| (t, normal))) {
                        let kernel = Kernel { shade, colors, t, normal, ..Kernel::bare(task) };
                        kernels.push(kernel);
                        kernels
                            .extend((colors && kernel.has_planes()).then_some(Kernel { face_colors: true, ..kernel }));
                    }
                }
            }
        }
        let samples = |k: &&Kernel| k.has_pixels() && !k.t && !k.normal && !k.has_depth_interval();
        let sampled: Vec<_> = kernels.iter().filter(samples).map(|k| Kernel { samples: true, ..*k }).collect();
        kernels.extend(sampled);
        kernels
    }

    fn module(kernel: &Kernel) -> (naga::Module, naga::valid::ModuleInfo) {
        let checked = validate(&compose(kernel), capabilities(kernel));
        checked.unwrap_or_else(|error| panic!("{kernel:?}: {error}"))
    }

    /// Every kernel with its module, validated with what the device will have; made once for all tests.
    fn modules() -> &'static [(Kernel, naga::Module, naga::valid::ModuleInfo)] {
        static MODULES: LazyLock<Vec<(Kernel, naga::Module, naga::valid::ModuleInfo)>> = LazyLock::new(|| {
            let made = |kernel: Kernel| {
                let (module, info) = module(&kernel);
                (kernel, module, info)
            };
            kernels().into_par_iter().map(made).collect()
        });
        &MODULES
    }

    /// Every step of a resident frame.
    fn steps() -> impl Iterator<Item = Step> {
        let both = [false, true];
        let kinds = both.into_iter().flat_map(move |samples| both.map(|planes| (samples, planes)));
        let splats =
            kinds.flat_map(|(samples, planes)| [Step::Small { samples, planes }, Step::Large { samples, planes }]);
        let pictures = [false, true].map(|colors| Step::Picture { colors });
        let of_pictures = [Step::SkySums, Step::Smooth, Step::Unsure, Step::Scatter];
        splats.chain([Step::Place, Step::Guests, Step::Sky]).chain(of_pictures).chain(pictures)
    }

    #[test]
    fn every_step_of_a_resident_frame_validates_without_capabilities() {
        for step in steps() {
            let checked = validate(&compose_step(step), Capabilities::empty());
            checked.unwrap_or_else(|error| panic!("{step:?}: {error}"));
        }
    }

    #[test]
    fn every_composed_shader_validates_with_what_the_device_will_have() {
        let modules = modules();
        let looks = 1 + 2 + 1 + 2;
        // Without general spheres, with few and with lists, and what is not proved settled or not.
        let certified = 3 * 2;
        // Of two looks the faces of cut spheres may have colours of their own.
        let centers = ((Method::ALL.len() * 3 + certified * 6) * looks + certified * 2 * 2) * 4;
        let sampled = (Method::ALL.len() + certified * 3) * looks + certified * 2;
        assert_eq!(modules.len(), centers + sampled, "the list is complete");
    }

    #[test]
    fn a_kernel_binds_what_it_needs_and_nothing_else() {
        for (kernel, module, info) in modules() {
            let bound: BTreeSet<_> = bindings(module, info).into_iter().map(|b| b.name).collect();
            let (method, certified) = (kernel.method().is_some(), kernel.is_certified());
            let generals = kernel.certificate().map_or(Generals::None, |certificate| certificate.generals);
            let expected: BTreeSet<_> = [
                (true, "view"),
                (method, "spheres"),
                (true, "frame_id"),
                (certified, "projection"),
                (certified, "projected"),
                (certified, "block_pass"),
                (certified, "minima"),
                (kernel.has_planes(), "planes"),
                (generals == Generals::Few, "generals_uniform"),
                (generals == Generals::Lists, "generals_storage"),
                (kernel.leaves_starts(), "starts"),
                (kernel.has_depths() || kernel.t || kernel.normal || kernel.shade.is_some(), "frame_values"),
                (kernel.colors, "colors"),
                (method && !kernel.has_pixels(), "rays"),
                (kernel.reads_residuals(), "residuals"),
            ]
            .into_iter()
            .filter_map(|(is_needed, name)| is_needed.then_some(name))
            .collect();
            assert_eq!(bound, expected, "{kernel:?}");
        }
    }

    #[test]
    fn f64_is_requested_exactly_where_it_is_used() {
        for (kernel, ..) in modules() {
            // All others are valid without it: `modules` validates them with no more than they request.
            let wide = kernel.method() == Some(Method::Native64);
            assert_eq!(capabilities(kernel).contains(Capabilities::FLOAT64), wide, "{kernel:?}");
            if wide {
                validate(&compose(kernel), Capabilities::empty()).expect_err("f64 without the capability");
            }
        }
    }

    #[test]
    fn structs_have_one_layout_on_both_sides() {
        let spread = Task::Method { method: Method::Stable, rays: RaySource::Spread };
        let (certified, _) = module(&Kernel { t: true, normal: true, ..Kernel::certified().with_generals(5) });
        let (given, _) = validate(&compose_step(Step::Sky), Capabilities::empty()).expect("a step");
        let (module, _) = module(&Kernel { t: true, normal: true, ..Kernel::bare(spread) });
        macro_rules! same {
            ($module:ident $wgsl:literal, $host:ty, $($field:ident)*) => {
                let host: Vec<(&str, usize)> = vec![$((stringify!($field), offset_of!($host, $field))),*];
                assert_eq!(members(&$module, $wgsl), (host, size_of::<$host>()), $wgsl);
            };
        }
        let (place, _) = validate(&compose_step(Step::Place), Capabilities::empty()).expect("a step");
        same!(place "Placing", PlacingRecord, eye axes per_slope middle reference low_blurred low_center low_offset
            low_coordinates low_total low_scale per_step slope edge reach per_slope_f32 middle_f32 corner end rotated wider
            farthest per_unit to_frame shift fine parallel columns rows narrow unused_a);
        same!(place "BlockPass", BlockPass, first count mode pieces groups unused_a unused_b unused_c);
        same!(certified "Projection", ProjectionRecord, slope step fixed shift unit errors edge depth tolerance generals
            cull_margin size);
        same!(certified "Projected", ProjectedRecord, x y rho low);
        same!(certified "ProjectedDetail", ProjectedDetailRecord, subpixel_offset center id);
        same!(certified "General", GeneralRecord, center_radius power scale form id pixel by start blur rank);
        assert_eq!(constant(&certified, "GENERAL"), f64::from(crate::certify::GENERAL));
        assert_eq!(constant(&certified, "UNSURE"), f64::from(crate::view::ray::UNSURE));
        same!(module "View", ViewRecord, right up back background width height first_row rows half_du half_dv d spheres
            zero half_du_low half_dv_low d_low first_column columns strata jitter sample seed step shift_column
            shift_row);
        same!(module "SphereRecord", SphereRecord, center_radius power scale);
        same!(module "SphereResiduals", SphereResiduals, center_radius power);
        same!(module "GivenRay", RayRecord, direction origin origin_low);
        same!(given "Node", NodeRecord, origin grid planes);
        assert_eq!(
            members(&given, "PlacedSphere"),
            (vec![("steps", 0), ("radius", 12), ("rest", 16)], 32),
            "PlacedSphere"
        );
        assert_eq!(size_of::<PlacedSphereRecord>(), 32);
        assert_eq!((2u32 << constant(&given, "PLACED_ROW_BITS") as u32), crate::gpu::texture::ROW);
        assert_eq!(constant(&given, "UNSURE"), f64::from(crate::view::ray::UNSURE));
        for (name, ours) in [("LEVELS", DEVICE_LEVELS), ("LANE", LANE), ("NEVER", NEVER)] {
            assert_eq!(constant(&given, name), f64::from(ours), "{name}");
        }
        assert_eq!((4u32 << constant(&given, "ROW_BITS") as u32), crate::gpu::texture::ROW);
        for level in 0..=DEVICE_LEVELS {
            let firsts = constant(&given, "FIRSTS") as u32;
            assert_eq!((firsts & ((1 << (3 * level)) - 1)) as usize, first(level as usize), "level {level}");
        }
        assert_eq!(constant(&module, "NONE"), f64::from(NONE));
        assert_eq!(constant(&module, "MISS"), f64::from(f32::MAX));
        assert_eq!(constant(&module, "GROUP"), f64::from(GROUP));
    }

    /// The constants of the proof are equal on both sides, and their file contains no others.
    #[test]
    fn the_constants_of_the_proof_are_those_of_the_twin() {
        use crate::certify::constants::{ALL, given};
        let (certified, _) = module(&Kernel::certified().with_generals(5));
        let (of_rays, _) = validate(&compose_step(Step::Sky), Capabilities::empty()).expect("a step");
        for (file, module, all) in
            [("certify/constants.wgsl", certified, ALL), ("certify/given_constants.wgsl", of_rays, given::ALL)]
        {
            for (name, value) in all {
                assert_eq!(constant(&module, name), f64::from(*value), "{name}");
            }
            let text = files([file]).next().expect("the file").text;
            assert_eq!(text.lines().filter(|line| line.starts_with("const ")).count(), all.len(), "{file}");
        }
    }

    /// Every number in the proof is a named constant, except 0, 1, the 2 of a squared sum and the half of a middle.
    #[test]
    fn no_number_of_the_proof_is_without_a_name() {
        let sources: Vec<Source> = kernels().iter().map(compose).chain(steps().map(compose_step)).collect();
        let of_proof = |part: &&Part| part.name.starts_with("certify/") && !part.name.ends_with("constants.wgsl");
        let mut names = BTreeSet::new();
        for part in
            sources.iter().flat_map(|source| &source.parts).filter(of_proof).filter(|part| names.insert(part.name))
        {
            let code = part.text.lines().map(|line| line.split("//").next().unwrap_or_default());
            let words = code.flat_map(|line| line.split(|c: char| !c.is_ascii_alphanumeric() && c != '.'));
            for word in words.filter(|word| word.contains('.') && word.starts_with(|c: char| c.is_ascii_digit())) {
                assert!(["0.0", "0.5", "1.0", "2.0"].contains(&word), "{word} in {}", part.name);
            }
        }
        assert!(names.len() > 5, "{names:?}");
    }

    /// Every file is part of a kernel or of the self-test, and every name refers to a file. The lecture on one page is a program of its own.
    #[test]
    fn every_file_is_used() {
        let root = crate::testing::home().join("shaders");
        let mut unused = BTreeSet::new();
        for folder in std::fs::read_dir(&root).expect("shaders").map(|entry| entry.expect("an entry").path()) {
            let is_file = folder.is_file();
            let inside = || std::fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("an entry").path());
            let files = if is_file { vec![folder.clone()] } else { inside().collect() };
            let name = |file: &std::path::PathBuf| file.strip_prefix(&root).expect("inside").display().to_string();
            unused.extend(files.iter().map(|file| name(file).replace('\\', "/")));
        }
        let trials = crate::gpu::selftest::trials(true);
        let selftest = trials.iter().flat_map(|trial| trial.parts.iter().map(|part| part.name));
        let sources = kernels().iter().map(compose).chain(steps().map(compose_step)).collect::<Vec<_>>();
        for name in sources.iter().flat_map(|source| source.files()).map(|(name, _)| name).chain(selftest) {
            unused.remove(name);
        }
        assert_eq!(unused, BTreeSet::from(["lecture.wgsl".to_owned()]));
    }

    #[test]
    fn workgroups_are_tiles() {
        for (kernel, module, _) in modules() {
            assert_eq!(module.entry_points.len(), 1, "{kernel:?}");
            assert_eq!(module.entry_points[0].workgroup_size, [GROUP, 1, 1], "{kernel:?}");
            if kernel.has_pixels() {
                assert_eq!(constant(module, "TILE"), f64::from(TILE), "{kernel:?}");
            }
        }
        assert_eq!(TILE * TILE, GROUP);
    }

    #[test]
    fn an_error_names_the_file_and_the_line() {
        let mut source = compose(&kernels()[0]);
        let at = source.text.find("fn main").expect("every kernel has it");
        let line = source.text[..at].lines().count() + 1;
        assert_eq!(source.place(line), "shaders/main/viewing_rays.wgsl:3");
        source.text.replace_range(at..at + 2, "fm");
        let error = validate(&source, Capabilities::empty()).expect_err("broken on purpose").to_string();
        assert!(error.contains("shaders/main/viewing_rays.wgsl:3:1"), "{error}");
    }

    /// The name and offset of each member, and the size, of a WGSL struct.
    fn members<'a>(module: &'a naga::Module, name: &str) -> (Vec<(&'a str, usize)>, usize) {
        let found = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name));
        match &found.expect("the struct is declared").1.inner {
            naga::TypeInner::Struct { members, span } => {
                let member = |m: &'a naga::StructMember| (m.name.as_deref().unwrap_or("?"), m.offset as usize);
                (members.iter().map(member).collect(), *span as usize)
            }
            other => panic!("{name} is no struct but {other:?}"),
        }
    }

    /// The value of a WGSL constant.
    fn constant(module: &naga::Module, name: &str) -> f64 {
        let found = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name));
        match module.global_expressions[found.expect("the constant is declared").1.init] {
            naga::Expression::Literal(naga::Literal::U32(x)) => f64::from(x),
            naga::Expression::Literal(naga::Literal::F32(x)) => f64::from(x),
            ref other => panic!("{name} is {other:?}"),
        }
    }
}
