//! Which adapters keep the bits of the CPU path.

/// Adapters whose every f32 operation was measured to round as IEEE 754 does.
const STRICT: [&str; 2] = ["llvmpipe", "SwiftShader"];

/// Whether answers of the adapter of this name and of the CPU path are compared bit for bit. Other adapters may round as WGSL
/// allows, and so does any under the layer of tests/hostile: docs/hardware.md says what is equal there.
pub(crate) fn keeps_bits(adapter: &str) -> bool {
    let is_hostile = std::env::var("VK_INSTANCE_LAYERS").is_ok_and(|layers| layers.contains("hostile"));
    !is_hostile && STRICT.iter().any(|name| adapter.contains(name))
}
