//! Inputs that kernels read as textures of four u32 a texel: llvmpipe gives eight invocations a texel each at once, but reads
//! numbers of a buffer one by one (docs/performance.md).

use super::Gpu;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::BACKEND;

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
        let (row, most) = (ROW as usize * TEXEL, self.limits.max_texture_dimension_2d);
        let rows = bytes.len().div_ceil(row).max(1);
        if rows > most as usize || ROW > most {
            let (size, adapter) = (bytes.len(), &self.summary.name);
            return Err(Error::Limits {
                problem: format!("{size} bytes of {name} exceed the largest texture of {adapter} ({most} rows)"),
                mend: format!("trace fewer spheres, or use {BACKEND} cpu"),
            });
        }
        if self.textures.get(name).is_none_or(|(known, _)| (known.height() as usize) < rows) {
            let texture = self.open.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(name),
                size: wgpu::Extent3d { width: ROW, height: rows as u32, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba32Uint,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            self.textures.insert(name, (texture, view));
        }
        let texture = &self.textures[name].0;
        let (whole, rest) = bytes.split_at(bytes.len() / row * row);
        let mut first = 0;
        // Rows that are full, as many as one submission writes, then the part of one.
        for part in whole.chunks((self.open.part / row).max(1) * row).chain((!rest.is_empty()).then_some(rest)) {
            let (width, height) = ((part.len() / TEXEL).min(ROW as usize) as u32, part.len().div_ceil(row) as u32);
            let origin = wgpu::Origin3d { x: 0, y: first, z: 0 };
            self.open.queue.write_texture(
                wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() },
                part,
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row as u32), rows_per_image: None },
                wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            );
            self.open.wrote(part.len())?;
            first += height;
        }
        self.traffic.up += bytes.len() as u64;
        Ok(())
    }
}
