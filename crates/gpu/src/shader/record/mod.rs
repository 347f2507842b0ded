//! All structs that Rust and shaders share.

use super::declaration::{Declaration, ShaderType};

pub(crate) mod frame;
pub(crate) mod opaque;
pub(crate) mod pixel;
pub(crate) mod scene;
pub(crate) mod shadow;
pub(crate) mod temporal;
pub(crate) mod tree;

/// The declaration of each type, in the order given.
macro_rules! declarations {
    ($($type:ty),+ $(,)?) => {
        vec![$(<$type as ShaderType>::declaration().expect("a struct has a declaration")),+]
    };
}

/// The structs that pieces import as `struct/<Name>`.
pub(crate) fn all() -> Vec<Declaration> {
    declarations![
        frame::CameraUniform,
        frame::FrameUniform,
        opaque::OpaqueUniform,
        pixel::Counts,
        pixel::FragmentStats,
        pixel::LayersRecord,
        pixel::ListNode,
        pixel::PixelRecord,
        pixel::Round,
        pixel::RoundSums,
        pixel::Tested,
        scene::Light,
        scene::Lobe,
        scene::Material,
        scene::MeshOffsets,
        scene::Object,
        scene::Opacity,
        scene::Texture,
        scene::TextureUse,
        shadow::ShadowFace,
        shadow::ShadowLight,
        temporal::KeptLayers,
        temporal::TemporalUniform,
        tree::BvhBlock,
        tree::BvhHeader,
        tree::BvhNode,
    ]
}
