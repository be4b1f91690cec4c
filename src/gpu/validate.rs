//! Parses and validates composed shaders, and compiles them.

use super::alone::alone;
use super::compose::Source;
use halfline_ground::error::{Error, Result};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use std::borrow::Cow;

/// Parses and validates a composed shader with the capabilities of the device.
pub(crate) fn validate(source: &Source, capabilities: Capabilities) -> Result<(naga::Module, naga::valid::ModuleInfo)> {
    let broken = |message: String| Error::Adapter {
        problem: format!("a built-in shader does not compile: {message}"),
        mend: "report this as a bug".into(),
    };
    let module = naga::front::wgsl::parse_str(&source.text)
        .map_err(|e| broken(source.explain(e.location(&source.text), e.message())))?;
    let info = Validator::new(ValidationFlags::all(), capabilities).validate(&module).map_err(|e| {
        let location = e.location(&source.text);
        broken(source.explain(location, &format!("{:?}", e.into_inner())))
    })?;
    Ok((module, info))
}

/// The shader as wgpu takes it: parsed, since parsing takes five times as long as validating and translating together; a browser
/// parses the text.
fn shader(source: &Source, module: naga::Module) -> wgpu::ShaderSource<'_> {
    #[cfg(target_arch = "wasm32")]
    return (wgpu::ShaderSource::Wgsl(Cow::Borrowed(&source.text)), module).0;
    #[cfg(not(target_arch = "wasm32"))]
    (wgpu::ShaderSource::Naga(Cow::Owned(module)), source).0
}

/// Compiles a validated shader.
pub(super) fn compile(
    device: &wgpu::Device,
    label: &str,
    source: &Source,
    module: naga::Module,
) -> wgpu::ComputePipeline {
    let descriptor = wgpu::ShaderModuleDescriptor { label: Some(label), source: shader(source, module) };
    let _alone = alone();
    let shader = device.create_shader_module(descriptor);
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(label),
        layout: None,
        module: &shader,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &[],
            zero_initialize_workgroup_memory: false,
        },
        cache: None,
    })
}
