//! Formats of the targets that several techniques draw to, and how fragments are blended there.

use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, TextureFormat};

/// Format of a visibility buffer: triangle, two weights, side.
pub(crate) const SURFACE_FORMAT: TextureFormat = TextureFormat::Rgba32Uint;
/// Depths keep all bits of the distances they are made from.
pub(crate) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// No triangle.
pub(super) const NO_SURFACE: wgpu::Color = wgpu::Color { r: u32::MAX as f64, g: 0.0, b: 0.0, a: 0.0 };

/// What the fragments for which there is no memory add up to: radiance times alpha, alpha; and their transmittance.
pub(super) const TAIL_FORMATS: [TextureFormat; 2] = [TextureFormat::Rgba16Float, TextureFormat::R16Float];

/// Sums.
pub(super) const ADD: BlendState = same(BlendFactor::One, BlendFactor::One);
/// Products of what was there with what comes.
pub(super) const MULTIPLY: BlendState = same(BlendFactor::Zero, BlendFactor::Src);

const fn same(src_factor: BlendFactor, dst_factor: BlendFactor) -> BlendState {
    let component = BlendComponent { src_factor, dst_factor, operation: BlendOperation::Add };
    BlendState { color: component, alpha: component }
}
