//! The bindings that naga finds in a shader; the shaders are their only declaration.

use crate::intersect::Method;
use crate::kernel::{Kernel, OUTPUTS};
use naga::valid::Capabilities;

/// A buffer or a texture that the shader binds in group 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Binding {
    /// Its name in WGSL.
    pub(crate) name: &'static str,
    /// Its number in WGSL.
    pub(crate) binding: u32,
}

/// Whether an input is a texture, see texture.rs.
pub(super) fn is_texture(name: &str) -> bool {
    ["nodes", "placed"].contains(&name)
}

/// The inputs of kernels, buffers unless [`is_texture`], by their WGSL names; the last two belong to the self-test.
const INPUTS: [&str; 28] = [
    "view",
    "spheres",
    "residuals",
    "colors",
    "rays",
    "nodes",
    "boxes",
    "placed",
    "certified_rays",
    "projection",
    "projected",
    "others",
    "near",
    "lists",
    "placing",
    "part",
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
    "cases",
    "answers",
];

/// Every buffer that a shader binds, by its WGSL name. The binding number is the index in this list.
pub(crate) fn buffers() -> impl Iterator<Item = &'static str> {
    INPUTS.into_iter().chain(OUTPUTS.iter().map(|output| output.name))
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
    let wide = kernel.is_wide() && kernel.method == Method::Native64;
    let wide = if wide { Capabilities::FLOAT64 } else { Capabilities::empty() };
    wide | if kernel.shares() { Capabilities::SUBGROUP } else { Capabilities::empty() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certify::ProjectionRecord;
    use crate::certify::general::GeneralRecord;
    use crate::certify::placing::PlacingRecord;
    use crate::certify::projected::{ProjectedDetailRecord, ProjectedRecord};
    use crate::gpu::compose::{Part, Step, compose, compose_step, files, parts};
    use crate::gpu::input::GROUP;
    use crate::gpu::resident::steps::BlockPass;
    use crate::gpu::validate::validate;
    use crate::intersect::Method;
    use crate::kernel::{Generals, RaySource, Sharing};
    use crate::search::tree::device::{DEVICE_LEVELS, NodeRecord, PlacedSphereRecord, first};
    use crate::search::tree::device_rays::{BoxRayRecord, CertifiedRayRecord};
    use crate::search::tree::lanes::{LANE, NEVER};
    use crate::shade::Shade;
    use crate::tile::{CHUNK, TILE};
    use crate::view::ray::{NONE, RayRecord};
    use crate::view::{SphereRecord, SphereResiduals, ViewRecord};
    use rayon::prelude::*;
    use std::collections::BTreeSet;
    use std::mem::offset_of;
    use std::sync::LazyLock;

    /// Every kernel that a plan can select.
    fn kernels() -> Vec<Kernel> {
        let both = [false, true];
        let shades = [None, Some(Shade::Flat), Some(Shade::Normal), Some(Shade::Headlight)];
        let camera = Sharing::ALL.map(|sharing| (RaySource::Camera, sharing));
        let given = [RaySource::SharedOrigin, RaySource::Spread].map(|rays| (rays, Sharing::None));
        let mut kernels = Vec::new();
        let none = Generals::None;
        let plain =
            both.into_iter().flat_map(|tiles| Method::ALL.iter().map(move |&method| (method, false, tiles, none)));
        let certified = [0, 1, 4, 5].map(|count| (Method::Stable, true, false, Generals::of(count)));
        for (method, certify, tiles, generals) in plain.chain(certified) {
            for (rays, sharing) in camera.into_iter().chain(given) {
                for shade in shades {
                    for (t, normal) in both.into_iter().flat_map(|t| both.map(|normal| (t, normal))) {
                        let colors = both.into_iter().filter(|c| !c || shade.is_some_and(Shade::needs_colors));
                        let all = |colors| Kernel {
                            method,
                            rays,
                            sharing,
                            shade,
                            colors,
                            t,
                            normal,
                            certify,
                            generals,
                            winners: false,
                            tiles,
                            depth_interval: t && certify,
                            tree: false,
                            any: false,
                            samples: false,
                            starts: false,
                        };
                        kernels.extend(colors.map(all).filter(|k| !certify && !tiles || k.rays == RaySource::Camera));
                    }
                }
            }
        }
        let spread = Kernel { certify: true, rays: RaySource::Spread, ..Kernel::bare(Method::Stable) };
        kernels.extend(both.into_iter().flat_map(|tree| both.map(|any| Kernel { tree, any, ..spread })));
        let all = kernels.iter().filter(|k| k.certify && k.rays == RaySource::Camera && !k.t && !k.normal);
        let winners: Vec<_> = all.filter(|k| k.shade.is_none()).map(|k| k.winners()).collect();
        kernels.extend(winners);
        // A resident kernel shares nothing.
        kernels.retain(|k| !k.is_resident() || k.sharing == Sharing::None);
        let starts: Vec<_> =
            kernels.iter().filter(|k| k.is_resident()).map(|k| Kernel { starts: true, ..*k }).collect();
        kernels.extend(starts);
        let samples = |k: &&Kernel| k.rays == RaySource::Camera && !k.t && !k.normal;
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
        let splats = [false, true].into_iter().flat_map(|samples| [Step::Small { samples }, Step::Large { samples }]);
        splats.chain([Step::Place, Step::Guests, Step::Sky])
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
        // Without a list of general spheres, with one, with four in a uniform, and with lists, each with and without starts of
        // rays from the hits; a search by every sharing.
        let (certified, winners) = (4 * 2, 4 * 4);
        let sampled = (Method::ALL.len() * 8 + certified) * looks + winners;
        let all = (Method::ALL.len() * (8 + 2) + certified) * 4 * looks + winners + sampled + 4;
        assert_eq!(modules.len(), all, "the list is complete");
    }

    #[test]
    fn a_kernel_binds_what_it_needs_and_nothing_else() {
        for (kernel, module, info) in modules() {
            let bound: BTreeSet<_> = bindings(module, info).into_iter().map(|b| b.name).collect();
            let given = kernel.rays != RaySource::Camera;
            let (certify, tiles) = (kernel.certify, kernel.tiles);
            let wanted: BTreeSet<_> = [
                (true, "view"),
                (!certify, "spheres"),
                (true, "frame_id"),
                (certify && !given, "projection"),
                (certify && !given, "projected"),
                (kernel.generals == Generals::Lists, "others"),
                (kernel.is_resident(), "part"),
                (kernel.is_resident(), "minima"),
                (kernel.starts, "starts"),
                (kernel.has_depths(), "frame_depth"),
                (matches!(kernel.generals, Generals::Few(_)), "near"),
                (kernel.winners, "frame_low"),
                (kernel.winners, "frame_second"),
                (kernel.winners || tiles || kernel.generals == Generals::Lists, "lists"),
                (kernel.depth_interval, "frame_depth_interval"),
                (kernel.t, "frame_t"),
                (kernel.normal, "frame_normal"),
                (kernel.shade.is_some(), "frame_color"),
                (kernel.colors, "colors"),
                (given && !certify, "rays"),
                (given && certify, "certified_rays"),
                (given && certify, "placed"),
                (kernel.tree, "nodes"),
                (kernel.tree, "boxes"),
                (kernel.reads_residuals(), "residuals"),
                (kernel.t && kernel.is_wide(), "frame_t_low"),
            ]
            .into_iter()
            .filter_map(|(wanted, name)| wanted.then_some(name))
            .collect();
            assert_eq!(bound, wanted, "{kernel:?}");
        }
    }

    #[test]
    fn subgroups_are_requested_exactly_where_they_are_used() {
        let sharing = kernels().into_iter().filter(Kernel::shares);
        for kernel in sharing {
            validate(&compose(&kernel), Capabilities::empty()).expect_err("subgroups without the capability");
        }
    }

    #[test]
    fn f64_is_requested_exactly_where_it_is_used() {
        for (kernel, ..) in modules() {
            // All others are valid without it: `modules` validates them with no more than they request.
            let wide = kernel.method == Method::Native64;
            assert_eq!(capabilities(kernel).contains(Capabilities::FLOAT64), wide, "{kernel:?}");
            if wide {
                validate(&compose(kernel), Capabilities::SUBGROUP).expect_err("f64 without the capability");
            }
        }
    }

    #[test]
    fn structs_have_one_layout_on_both_sides() {
        let any = Kernel { rays: RaySource::Spread, t: true, normal: true, ..Kernel::bare(Method::Stable) };
        let (certified, _) =
            module(&Kernel { rays: RaySource::Camera, certify: true, generals: Generals::Lists, ..any });
        let (given, _) = module(&Kernel { certify: true, tree: true, t: false, normal: false, ..any });
        let (module, _) = module(&any);
        macro_rules! same {
            ($module:ident $wgsl:literal, $host:ty, $($field:ident)*) => {
                let host: Vec<(&str, usize)> = vec![$((stringify!($field), offset_of!($host, $field))),*];
                assert_eq!(members(&$module, $wgsl), (host, size_of::<$host>()), $wgsl);
            };
        }
        let (place, _) = validate(&compose_step(Step::Place), Capabilities::empty()).expect("a step");
        same!(place "Placing", PlacingRecord, eye axes per_slope middle reference low_blurred low_center low_offset
            low_coordinates low_total low_scale per_step slope edge reach per_slope_f32 middle_f32 corner end rotated wider
            farthest per_unit to_frame shift fine parallel columns rows unused_a unused_b);
        same!(place "BlockPass", BlockPass, first count mode pieces groups unused_a unused_b unused_c);
        same!(certified "Projection", ProjectionRecord, slope_x slope_y step_x step_y fixed_x fixed_y shift unit error0 error1
            error2 edge depth tolerance generals cull_margin size);
        same!(certified "Projected", ProjectedRecord, x y rho low);
        same!(certified "ProjectedDetail", ProjectedDetailRecord, subpixel_offset center id);
        same!(certified "General", GeneralRecord, center_radius power scale form id column row start by_column by_row blur);
        assert_eq!(constant(&module, "CHUNK"), CHUNK as f64);
        assert_eq!(constant(&certified, "GENERAL"), f64::from(crate::certify::GENERAL));
        assert_eq!(constant(&certified, "UNSURE"), f64::from(crate::view::ray::UNSURE));
        same!(module "View", ViewRecord, right up back background width height first_row rows half_du half_dv d spheres
            zero half_du_low half_dv_low d_low first_column columns strata jitter sample seed step shift_column
            shift_row);
        same!(module "SphereRecord", SphereRecord, center_radius power scale id);
        same!(module "SphereResiduals", SphereResiduals, center_radius power);
        same!(module "GivenRay", RayRecord, direction origin origin_low);
        same!(given "Node", NodeRecord, origin grid planes);
        same!(given "BoxRay", BoxRayRecord, enter leave inverse);
        same!(given "CertifiedRay", CertifiedRayRecord, steps sure_limit rest limit direction blur);
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
        let kernel = Kernel { certify: true, generals: Generals::Lists, ..Kernel::bare(Method::Stable) };
        let of_given = Kernel { rays: RaySource::Spread, ..kernel };
        for (file, kernel, all) in
            [("certify/constants.wgsl", kernel, ALL), ("certify/given_constants.wgsl", of_given, given::ALL)]
        {
            let (module, _) = module(&kernel);
            for (name, value) in all {
                assert_eq!(constant(&module, name), f64::from(*value), "{name}");
            }
            let text = files([file]).next().expect("the file").text;
            assert_eq!(text.lines().filter(|line| line.starts_with("const ")).count(), all.len(), "{file}");
        }
    }

    /// Every number in the proof is a named constant, except 0, 1 and the 2 of a squared sum.
    #[test]
    fn no_number_of_the_proof_is_without_a_name() {
        let all = kernels();
        let of_proof = |part: &Part| part.name.starts_with("certify/") && !part.name.ends_with("constants.wgsl");
        let mut seen = BTreeSet::new();
        for part in all.iter().flat_map(parts).filter(of_proof).filter(|part| seen.insert(part.name)) {
            let code = part.text.lines().map(|line| line.split("//").next().unwrap_or_default());
            let words = code.flat_map(|line| line.split(|c: char| !c.is_ascii_alphanumeric() && c != '.'));
            for word in words.filter(|word| word.contains('.') && word.starts_with(|c: char| c.is_ascii_digit())) {
                assert!(["0.0", "1.0", "2.0"].contains(&word), "{word} in {}", part.name);
            }
        }
        assert!(seen.len() > 5, "{seen:?}");
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
            assert_eq!(module.entry_points[0].workgroup_size, [GROUP / kernel.rows(), 1, 1], "{kernel:?}");
            if kernel.rays == RaySource::Camera {
                assert_eq!(constant(module, "TILE"), f64::from(TILE), "{kernel:?}");
            }
        }
        assert_eq!(TILE * TILE, GROUP);
    }

    #[test]
    fn an_error_names_the_file_and_the_line() {
        let mut source = compose(&kernels()[0]);
        let at = source.text.find("fn render").expect("every kernel has it");
        let line = source.text[..at].lines().count() + 1;
        assert_eq!(source.place(line), "shaders/main/viewing_rays.wgsl:2");
        source.text.replace_range(at..at + 2, "fm");
        let error = validate(&source, Capabilities::empty()).expect_err("broken on purpose").to_string();
        assert!(error.contains("shaders/main/viewing_rays.wgsl:2:1"), "{error}");
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
