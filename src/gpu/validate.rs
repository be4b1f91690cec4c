//! Parses and validates composed shaders.

use super::compose::Source;
use crate::error::{Error, Result};
use naga::valid::{Capabilities, ValidationFlags, Validator};

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
