//! The shaders for other compilers than Naga: all without f64. tests/compilers/run gives them to Chromium.

use super::*;
use crate::gpu::compose::Source;
use crate::gpu::selftest::trials;
use std::collections::BTreeMap;

/// The storage buffers that every implementation of WebGPU binds in a stage.
const STORAGE_BUFFERS: usize = 8;

/// A shader as tests/compilers/run reads it.
#[derive(serde::Serialize)]
struct Shader {
    name: String,
    text: String,
    /// Whether a frame with light of its own spheres and of the sky runs it, or a picture of it.
    plain: bool,
}

/// Every shader without f64: the lecture on one page, the steps of a resident frame, kernels, the self-test.
fn shaders() -> Vec<Shader> {
    let colored = Kernel { shade: Some(Shade::Headlight), colors: true, ..Kernel::certified() };
    let of_frame = colored.certified_by(|of| Certificate { starts: true, ..of });
    let shader = |name, source: Source, plain| Shader { name, text: source.text, plain };
    let steps = steps().map(|step| {
        let plain = match step {
            Step::Small { samples, planes } | Step::Large { samples, planes } => !samples && !planes,
            _ => true,
        };
        shader(format!("{step:?}"), compose_step(step), plain)
    });
    let kernels = kernels().into_iter().filter(|kernel| capabilities(kernel).is_empty());
    let kernels = kernels.map(|kernel| shader(format!("{kernel:?}"), compose(&kernel), kernel == of_frame));
    let trials = trials(false).into_iter();
    let trials = trials.map(|trial| shader(format!("self-test of {}", trial.name), Source::new(trial.parts), false));
    let lecture = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/lecture.wgsl"));
    let lecture = Shader { name: "lecture".into(), text: lecture.into(), plain: false };
    [lecture].into_iter().chain(steps).chain(kernels).chain(trials).collect()
}

/// The number of storage buffers that a shader binds.
fn storage_buffers(module: &naga::Module, info: &naga::valid::ModuleInfo) -> usize {
    let used = info.get_entry_point(0);
    let is_bound = |(handle, global): (naga::Handle<naga::GlobalVariable>, &naga::GlobalVariable)| {
        matches!(global.space, naga::AddressSpace::Storage { .. }) && !used[handle].is_empty()
    };
    module.global_variables.iter().filter(|global| is_bound(*global)).count()
}

#[test]
fn every_implementation_of_webgpu_binds_the_buffers_of_every_shader() {
    let mut most = BTreeMap::<String, usize>::new();
    let mut count = |group: String, module: &naga::Module, info: &naga::valid::ModuleInfo| {
        let bound = storage_buffers(module, info);
        assert!(bound <= STORAGE_BUFFERS, "{group} binds {bound} storage buffers");
        let known = most.entry(group).or_default();
        *known = bound.max(*known);
    };
    for (kernel, module, info) in modules() {
        let group = match kernel.task {
            Task::Method { rays, .. } => format!("methods, {rays:?}"),
            Task::Certified(certificate) => format!("certified, general spheres: {:?}", certificate.generals),
            Task::Given => continue,
        };
        count(group, module, info);
    }
    let trials = trials(true).into_iter().map(|trial| ("self-test".to_owned(), Source::new(trial.parts)));
    for (name, source) in steps().map(|step| (format!("{step:?}"), compose_step(step))).chain(trials) {
        let (module, info) = validate(&source, Capabilities::FLOAT64).expect("a shader");
        count(name, &module, &info);
    }
    println!("the most storage buffers: {most:#?}");
}

/// Writes the shaders to the file that HALFLINE_SHADERS names.
#[test]
fn shaders_for_other_compilers_are_all_of_them() {
    let shaders = shaders();
    let names: BTreeSet<_> = shaders.iter().map(|shader| &*shader.name).collect();
    let kernels = modules().iter().filter(|(kernel, ..)| kernel.method() != Some(Method::Native64)).count();
    assert_eq!(names.len(), 1 + steps().count() + kernels + trials(false).len());
    assert_eq!(names.len(), shaders.len(), "names of their own");
    assert_eq!(shaders.iter().filter(|shader| shader.plain).count(), 12, "the shaders of a frame, and of a picture");
    if let Some(file) = std::env::var_os("HALFLINE_SHADERS") {
        std::fs::write(file, serde_json::to_vec(&shaders).expect("JSON")).expect("a file");
    }
}
