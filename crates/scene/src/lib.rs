//! Validated scenes: their parts, animation.
//!
//! A [`Scene`] is validated once and then immutable. [`Animator`] turns a scene and a time into a [`Frame`]:
//! world-space triangles, their opacity, and surfaces to shade. Files are read by `sheer-load`, built-in
//! scenes are those of `sheer-gallery`.

pub mod camera;
mod content_hash;
pub mod cost;
pub mod environment;
mod error;
mod frame;
mod framing;
mod keys;
mod memory;
pub mod model;
pub mod particle;
mod scene;
mod texture;
mod viewpoint;

pub use crate::{
    camera::{Camera, CameraPose, CameraRay, ClipPlanes, Lens, PixelBeam},
    cost::light_buffer_bytes,
    environment::Environment,
    error::SceneError,
    frame::{
        Animator, Beam, FaceSide, Frame, FrameLight, FrameSize, GONE, HEAD_ON, LEAST_GRAZING, LEAST_SHARED,
        Look, MIRRORED, MeshInstance, MorphedAttributes, MovingObjects, NO_TEXTURE, OPAQUE, Object,
        SINGLE_SIDED, SLOT, Sharing, StaticCounts, Surface, TINTED, Transmitted, TriangleOpacity,
        scene_lights,
    },
    keys::Interpolate,
    memory::SceneMemory,
    model::SceneParts,
    scene::{CameraChoice, Scene},
    texture::{LEAST_GAP, MOST_PROBES, MipChain, NEXT_LEVEL, decode_tables, level_bytes},
    viewpoint::Viewpoint,
};
