//! Validated scenes: their parts, files that they come from, animation.
//!
//! A [`Scene`] is validated once and then immutable. [`Animator`] turns a scene and a time into a [`Frame`]:
//! world-space triangles, their opacity, and surfaces to shade. Loaders live in [`load`], one file a format;
//! built-in scenes in a crate of their own, `sheer-gallery`.

pub mod camera;
mod content_hash;
mod cost;
pub mod environment;
mod error;
mod frame;
mod framing;
mod keys;
pub mod load;
mod memory;
pub mod model;
pub mod particle;
mod scene;
mod texture;

pub use crate::{
    camera::{Camera, CameraPose, CameraRay, ClipPlanes, Lens, PixelBeam},
    environment::Environment,
    error::SceneError,
    frame::{
        Animator, Beam, FaceSide, Frame, FrameLight, HEAD_ON, LEAST_GRAZING, Look, MIRRORED, MeshInstance,
        MorphedAttributes, NO_TEXTURE, OPAQUE, Object, SINGLE_SIDED, SLOT, Sharing, StaticCounts, Surface,
        TINTED, Transmitted, TriangleOpacity, scene_lights,
    },
    keys::Interpolate,
    load::{LoadOptions, LoadWarning, Loaded, open, open_with},
    memory::SceneMemory,
    model::SceneParts,
    scene::{CameraChoice, Scene},
    texture::{LEAST_GAP, MOST_PROBES, MipChain, NEXT_LEVEL, decode_tables},
};
