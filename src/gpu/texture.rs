//! Inputs that kernels read as textures of four u32 a texel: llvmpipe gives eight invocations a texel each at once, but reads
//! numbers of a buffer one by one (docs/performance-log.md).

use super::Gpu;
use crate::error::{Error, Result};
use crate::gpu::device::Open;
use crate::quote::setting::BACKEND;

/// Texels in a row; search/tree.wgsl counts them.
pub(crate) const ROW: u32 = 1 << 12;

/// Bytes of a texel.
const TEXEL: usize = 16;

impl Gpu {
    /// Fills the texture `name` row by row; with nothing, an earlier call's is kept. A larger one of an earlier call is reused.
    pub(super) fn fill_texture(&mut self, name: &'static str, bytes: &[u8]) -> Result<()> {
        if bytes.is_empty() && self.textures.contains_key(name) {
            return Ok(());
        }
        let rows = rows(&self.limits, &self.summary.name, name, bytes)?;
        match self.textures.get(name) {
            Some((known, _)) if known.height() >= rows => write(&self.open, known, bytes),
            _ => {
                let made = texture(&self.open, &self.limits, &self.summary.name, name, bytes)?;
                self.textures.insert(name, made);
            }
        }
        self.traffic.up += bytes.len() as u64;
        Ok(())
    }
}

/// Rows of a texture with so many bytes, if the adapter allows it.
fn rows(limits: &wgpu::Limits, adapter: &str, name: &str, bytes: &[u8]) -> Result<u32> {
    let rows = bytes.len().div_ceil(ROW as usize * TEXEL).max(1);
    let most = limits.max_texture_dimension_2d;
    if rows <= most as usize && ROW <= most {
        return Ok(rows as u32);
    }
    Err(Error::Limits {
        problem: format!("{} bytes of {name} exceed the largest texture of {adapter} ({most} rows)", bytes.len()),
        mend: format!("trace fewer spheres, or use {BACKEND} cpu"),
    })
}

/// A texture with these bytes.
pub(super) fn texture(
    open: &Open,
    limits: &wgpu::Limits,
    adapter: &str,
    name: &'static str,
    bytes: &[u8],
) -> Result<(wgpu::Texture, wgpu::TextureView)> {
    let rows = rows(limits, adapter, name, bytes)?;
    let texture = open.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size: wgpu::Extent3d { width: ROW, height: rows, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Uint,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    write(open, &texture, bytes);
    Ok((texture, view))
}

fn write(open: &Open, texture: &wgpu::Texture, bytes: &[u8]) {
    let row = ROW as usize * TEXEL;
    let (whole, rest) = bytes.split_at(bytes.len() / row * row);
    for (part, first) in [(whole, 0), (rest, whole.len() / row)] {
        if part.is_empty() {
            continue;
        }
        let (width, height) = ((part.len() / TEXEL).min(ROW as usize) as u32, part.len().div_ceil(row) as u32);
        let origin = wgpu::Origin3d { x: 0, y: first as u32, z: 0 };
        open.queue.write_texture(
            wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() },
            part,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row as u32), rows_per_image: None },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }
}
