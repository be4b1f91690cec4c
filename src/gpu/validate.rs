//! Parses and validates composed shaders, and compiles them.

use super::compose::Source;
use crate::error::{Error, Result};
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

/// Compiles a validated shader. The parsed module is passed on: parsing takes five times as long as validating and
/// translating together.
pub(super) fn compile(device: &wgpu::Device, label: &str, module: naga::Module) -> wgpu::ComputePipeline {
    let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
    });
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
