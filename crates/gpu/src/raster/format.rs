//! Formats of the targets that several techniques draw to, and how fragments are blended there.

use sheer_render::contract::{Blend, TargetFormat};
use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, Features, TextureFormat};

/// Format of a visibility buffer: triangle, two weights, side.
pub(crate) const SURFACE_FORMAT: TextureFormat = TextureFormat::Rgba32Uint;
/// Format of depth buffers, which keep all bits of the distances that they are made from.
pub(crate) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// What a visibility buffer is cleared to: NONE in place of a triangle.
pub(super) const NO_SURFACE: wgpu::Color = wgpu::Color { r: u32::MAX as f64, g: 0.0, b: 0.0, a: 0.0 };

/// What the fragments for which there is no memory add up to: radiance times alpha, alpha; and their
/// transmittance.
pub(super) const TAIL_FORMATS: [TextureFormat; 2] = [TextureFormat::Rgba16Float, TextureFormat::R16Float];

/// Adds what a fragment brings to what the target holds.
pub(super) const ADD: BlendState = same(BlendFactor::One, BlendFactor::One);
/// Multiplies what the target holds by what a fragment brings.
pub(super) const MULTIPLY: BlendState = same(BlendFactor::Zero, BlendFactor::Src);

const fn same(src_factor: BlendFactor, dst_factor: BlendFactor) -> BlendState {
    let component = BlendComponent { src_factor, dst_factor, operation: BlendOperation::Add };
    BlendState { color: component, alpha: component }
}

/// The device's format for a target.
pub(super) fn texture_format(format: TargetFormat) -> TextureFormat {
    match format {
        TargetFormat::R16Float => TextureFormat::R16Float,
        TargetFormat::Rgba16Float => TextureFormat::Rgba16Float,
        TargetFormat::R32Float => TextureFormat::R32Float,
        TargetFormat::Rg32Float => TextureFormat::Rg32Float,
        TargetFormat::Rgba32Float => TextureFormat::Rgba32Float,
        TargetFormat::Rg32Uint => TextureFormat::Rg32Uint,
    }
}

/// What a device has to be capable of to blend into a format.
pub(super) fn blend_features(format: TextureFormat) -> Features {
    match format {
        TextureFormat::R32Float | TextureFormat::Rg32Float | TextureFormat::Rgba32Float => {
            Features::FLOAT32_BLENDABLE
        }
        _ => Features::empty(),
    }
}

/// The device's state for a way to blend.
pub(super) fn blend_state(blend: Blend) -> BlendState {
    match blend {
        Blend::Add => ADD,
        Blend::Multiply => MULTIPLY,
    }
}
