//! The panorama of the surroundings as one texture.

use sheer_image::Image;
use sheer_scene::Scene;

use crate::error::GpuError;

/// Bytes of a texel: four 32-bit floats.
const TEXEL_BYTES: u32 = 16;

/// The texels of the scene's panorama; a table of no levels where it has none.
pub(super) fn upload(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    scene: &Scene,
) -> Result<wgpu::Texture, GpuError> {
    let nothing = Image::filled(1, 1, [0.0; 4])?;
    let texels = scene.parts().environment.map.as_ref().map_or(&nothing, |map| map.texels());
    let (width, height) = texels.size();
    let limit = device.limits().max_texture_dimension_2d;
    if width.max(height) > limit {
        return Err(GpuError::Limit {
            what: "the panorama of the surroundings".to_owned(),
            needed: width.max(height).into(),
            limit: limit.into(),
            instead: "take a smaller one or --backend cpu".to_owned(),
        });
    }
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("environment map"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(texels.as_slice()),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(TEXEL_BYTES * width),
            rows_per_image: Some(height),
        },
        size,
    );
    Ok(texture)
}

/// Bytes of device memory that it takes.
pub(super) fn bytes(texture: &wgpu::Texture) -> u64 {
    u64::from(TEXEL_BYTES) * u64::from(texture.width()) * u64::from(texture.height())
}
