//! What naga reads out of a shader: the one declaration of every binding.

use crate::error::{Error, Result};
use crate::gpu::compose::Source;
use crate::plan::{Kernel, Sharing};
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
pub(crate) const BUFFERS: [&str; 9] =
    ["view", "spheres", "colors", "frame_id", "frame_t", "frame_normal", "frame_color", "rays", "lows"];

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
    if kernel.sharing == Sharing::None { Capabilities::empty() } else { Capabilities::SUBGROUP }
}
