//! What naga reads out of a shader: the one declaration of every binding.

use crate::error::{Error, Result};
use crate::gpu::compose::Source;
use crate::intersect::Method;
use crate::kernel::Kernel;
use naga::valid::{Capabilities, ValidationFlags, Validator};

/// A buffer that the shader binds in group 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Binding {
    /// Its name in WGSL.
    pub(crate) name: &'static str,
    /// Its number in WGSL.
    pub(crate) binding: u32,
}

/// Every buffer that any shader may bind, by its name in WGSL.
pub(crate) const BUFFERS: [&str; 19] = [
    "view",
    "spheres",
    "colors",
    "frame_id",
    "frame_t",
    "frame_normal",
    "frame_color",
    "rays",
    "lows",
    "lens",
    "fronts",
    "others",
    "lists",
    "frame_width",
    "frame_t_low",
    "candidates",
    "candidate_lows",
    "nodes",
    "order",
];

/// Parses and validates a composed shader with the capabilities the device will have.
pub(crate) fn validate(source: &Source, capabilities: Capabilities) -> Result<(naga::Module, naga::valid::ModuleInfo)> {
    let broken = |message: String| Error::Adapter {
        problem: format!("a shader of this build is broken: {message}"),
        mend: "report it".into(),
    };
    let module = naga::front::wgsl::parse_str(&source.text)
        .map_err(|e| broken(source.explain(e.location(&source.text), e.message())))?;
    let info = Validator::new(ValidationFlags::all(), capabilities).validate(&module).map_err(|e| {
        let location = e.location(&source.text);
        broken(source.explain(location, &format!("{:?}", e.into_inner())))
    })?;
    Ok((module, info))
}

/// The bindings the entry point uses.
pub(crate) fn bindings(module: &naga::Module, info: &naga::valid::ModuleInfo) -> Vec<Binding> {
    let used = info.get_entry_point(0);
    let named = |(handle, global): (naga::Handle<naga::GlobalVariable>, &naga::GlobalVariable)| {
        let binding = global.binding?;
        let name = BUFFERS.into_iter().find(|b| Some(*b) == global.name.as_deref())?;
        (!used[handle].is_empty()).then_some(Binding { name, binding: binding.binding })
    };
    module.global_variables.iter().filter_map(named).collect()
}

/// What the device will have when it runs `kernel`: validated with nothing more.
pub(crate) fn capabilities(kernel: &Kernel) -> Capabilities {
    let wide = kernel.is_wide() && kernel.method == Method::Native64;
    let wide = if wide { Capabilities::FLOAT64 } else { Capabilities::empty() };
    wide | if kernel.shares() { Capabilities::SUBGROUP } else { Capabilities::empty() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certify::LensRecord;
    use crate::certify::front::{FrontMoreRecord, FrontRecord};
    use crate::certify::near::NearRecord;
    use crate::gpu::compose::{compose, constants};
    use crate::gpu::dispatch::GROUP;
    use crate::intersect::Method;
    use crate::kernel::{Rays, Sharing};
    use crate::ray::NONE;
    use crate::ray::RayRecord;
    use crate::shade::Shade;
    use crate::tile::{CHUNK, TILE};
    use crate::tile_candidates::Candidate;
    use crate::tree::{FIRST, IS_LEAF, LEAST, NOWHERE, NodeRecord, STACK};
    use crate::view::{SphereLow, SphereRecord, ViewRecord};
    use std::collections::BTreeSet;
    use std::mem::offset_of;

    /// Every kernel that any plan can ask for.
    fn kernels() -> Vec<Kernel> {
        let both = [false, true];
        let shades = [None, Some(Shade::Flat), Some(Shade::Normal), Some(Shade::Headlight)];
        let camera = Sharing::ALL.map(|sharing| (Rays::Camera, sharing, false));
        let given = [Rays::SharedOrigin, Rays::Spread].map(|rays| both.map(|tree| (rays, Sharing::None, tree)));
        let mut kernels = Vec::new();
        let plain =
            both.into_iter().flat_map(|tiles| Method::ALL.iter().map(move |&method| (method, false, tiles, false)));
        let certified = both.map(|nears| (Method::Stable, true, false, nears));
        for (method, certify, tiles, nears) in plain.chain(certified) {
            for (rays, sharing, tree) in camera.into_iter().chain(given.into_iter().flatten()) {
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
                            nears,
                            tiles,
                            width: t && certify,
                            tree,
                            samples: false,
                        };
                        kernels.extend(colors.map(all).filter(|k| !certify && !tiles || k.rays == Rays::Camera));
                    }
                }
            }
        }
        let samples = |k: &&Kernel| k.rays == Rays::Camera && !k.t && !k.normal;
        let sampled: Vec<_> = kernels.iter().filter(samples).map(|k| Kernel { samples: true, ..*k }).collect();
        kernels.extend(sampled);
        kernels
    }

    fn module(kernel: &Kernel) -> (naga::Module, naga::valid::ModuleInfo) {
        let checked = validate(&compose(kernel), capabilities(kernel));
        checked.unwrap_or_else(|error| panic!("{kernel:?}: {error}"))
    }

    #[test]
    fn every_composed_shader_validates_with_what_the_device_will_have() {
        let kernels = kernels();
        let frames = 4 * (1 + 2 + 1 + 2);
        let sampled = (Method::ALL.len() * 8 + 8) * (1 + 2 + 1 + 2);
        assert_eq!(kernels.len(), (Method::ALL.len() * (8 + 4) + 8) * frames + sampled, "the list is whole");
        for kernel in &kernels {
            module(kernel);
        }
    }

    #[test]
    fn a_kernel_binds_what_it_needs_and_nothing_else() {
        for kernel in kernels() {
            let (module, info) = module(&kernel);
            let bound: BTreeSet<_> = bindings(&module, &info).into_iter().map(|b| b.name).collect();
            let given = kernel.rays != Rays::Camera;
            let (certify, tiles) = (kernel.certify, kernel.tiles);
            let wanted: BTreeSet<_> = [
                (true, "view"),
                (!certify && !tiles, "spheres"),
                (tiles, "candidates"),
                (tiles && kernel.is_wide(), "candidate_lows"),
                (true, "frame_id"),
                (certify, "lens"),
                (certify, "fronts"),
                (certify, "others"),
                (certify || tiles, "lists"),
                (kernel.width, "frame_width"),
                (kernel.t, "frame_t"),
                (kernel.normal, "frame_normal"),
                (kernel.shade.is_some(), "frame_color"),
                (kernel.colors, "colors"),
                (given, "rays"),
                (kernel.tree, "nodes"),
                (kernel.tree, "order"),
                (kernel.rays == Rays::Spread || kernel.is_wide() && !tiles, "lows"),
                (kernel.t && kernel.is_wide(), "frame_t_low"),
            ]
            .into_iter()
            .filter_map(|(wanted, name)| wanted.then_some(name))
            .collect();
            assert_eq!(bound, wanted, "{kernel:?}");
            let declared: BTreeSet<_> = module.overrides.iter().filter_map(|(_, o)| o.name.clone()).collect();
            let given: BTreeSet<_> = constants(&kernel).into_iter().map(|(name, _)| name.to_owned()).collect();
            assert_eq!(declared, given, "override constants of {kernel:?}");
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
        for kernel in kernels() {
            let without = validate(&compose(&kernel), Capabilities::SUBGROUP);
            assert_eq!(without.is_err(), kernel.method == Method::Native64, "{kernel:?}");
        }
    }

    #[test]
    fn structs_have_one_layout_on_both_sides() {
        let any = Kernel { rays: Rays::Spread, t: true, normal: true, tree: true, ..Kernel::bare(Method::Stable) };
        let (certified, _) = module(&Kernel { rays: Rays::Camera, certify: true, nears: true, tree: false, ..any });
        let (tiles, _) = module(&Kernel { rays: Rays::Camera, tiles: true, tree: false, ..any });
        let (module, _) = module(&any);
        macro_rules! same {
            ($module:ident $wgsl:literal, $host:ty, $($field:ident)*) => {
                let host: Vec<(&str, usize)> = vec![$((stringify!($field), offset_of!($host, $field))),*];
                assert_eq!(members(&$module, $wgsl), (host, size_of::<$host>()), $wgsl);
            };
        }
        same!(certified "Lens", LensRecord, slope_x slope_y step_x step_y fixed_x fixed_y shift unit error0 error1 error2 edge depth tolerance nears slack size);
        same!(certified "Front", FrontRecord, x y rho low);
        same!(certified "FrontMore", FrontMoreRecord, rest center id);
        same!(certified "Near", NearRecord, ball power scale form id column row start by_column by_row blur);
        same!(tiles "Candidate", Candidate, ball power scale id);
        assert_eq!(constant(&certified, "CHUNK"), CHUNK as f64);
        assert_eq!(constant(&tiles, "CHUNK"), CHUNK as f64);
        assert_eq!(constant(&certified, "NEAR"), f64::from(crate::certify::NEAR));
        assert_eq!(constant(&certified, "UNSURE"), f64::from(crate::ray::UNSURE));
        same!(module "View", ViewRecord, right up back background width height first_row rows half_du half_dv d spheres
            zero half_du_low half_dv_low d_low first_column columns strata jitter sample seed);
        same!(module "Sphere", SphereRecord, ball power scale);
        same!(module "SphereLow", SphereLow, ball power);
        same!(module "GivenRay", RayRecord, direction origin origin_low);
        same!(module "Node", NodeRecord, low_a high_a low_b high_b);
        for (name, ours) in [("STACK", STACK), ("IS_LEAF", IS_LEAF), ("FIRST", FIRST), ("NOWHERE", NOWHERE)] {
            assert_eq!(constant(&module, name), f64::from(ours), "{name}");
        }
        assert_eq!(constant(&module, "LEAST"), f64::from(LEAST));
        assert_eq!(constant(&module, "NONE"), f64::from(NONE));
        assert_eq!(constant(&module, "MISS"), f64::from(f32::MAX));
        assert_eq!(constant(&module, "GROUP"), f64::from(GROUP));
    }

    #[test]
    fn workgroups_are_tiles() {
        for kernel in kernels() {
            let (module, _) = module(&kernel);
            assert_eq!(module.entry_points.len(), 1, "{kernel:?}");
            assert_eq!(module.entry_points[0].workgroup_size, [GROUP, 1, 1], "{kernel:?}");
            if kernel.rays == Rays::Camera {
                assert_eq!(constant(&module, "TILE"), f64::from(TILE), "{kernel:?}");
            }
        }
        assert_eq!(TILE * TILE, GROUP);
    }

    #[test]
    fn an_error_names_the_file_and_the_line() {
        let mut source = compose(&kernels()[0]);
        let at = source.text.find("fn nearest").expect("every kernel has it");
        let line = source.text[..at].lines().count() + 1;
        assert_eq!(source.place(line), "shaders/nearest/plain.wgsl:2");
        source.text.replace_range(at..at + 2, "fm");
        let error = validate(&source, Capabilities::empty()).expect_err("broken on purpose").to_string();
        assert!(error.contains("shaders/nearest/plain.wgsl:2:1"), "{error}");
    }

    /// Name and offset of each member, and the size, of a struct in WGSL.
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
