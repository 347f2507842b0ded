//! What a scene takes in memory until its first ray is traced, worked out from counts alone.
//!
//! The constants are the sizes of the lists that frames and acceleration structures keep, with what growing
//! lists hold in reserve; a test of the command line holds them against the memory that runs take.

/// Bytes of a triangle wherever it is drawn: 44 in the frame's lists, which double as they grow, two
/// references of 32 while the tree is built, and about 50 in its blocks and nodes.
const TRIANGLE_BYTES: u64 = 200;
/// Bytes more of one that is not opaque all over: an entry of 56 in a list that doubles as it grows.
const OPACITY_BYTES: u64 = 112;
/// Bytes more of one that moves: where it was, twice while that is found out, in lists that double.
const MOTION_BYTES: u64 = 120;
/// Bytes that light buffers may take for a triangle that moves: some twenty places in lists, which double as
/// they grow.
const LIGHT_BUFFER_BYTES: u64 = 2000;
/// Bytes that the light buffers of a frame may take in all: beyond, they are coarse, and then not worth their
/// making.
const MOST_LIGHT_BUFFER_BYTES: u64 = 64 << 20;
/// Bytes of an object: its entry in the scene, that in the frame, and a vector of weights.
const OBJECT_BYTES: u64 = 400;

/// Bytes of a texel of an image that is kept: four, its alpha once more, and a third of both for the levels
/// below.
pub const TEXEL_BYTES: u64 = 7;
/// Bytes beside that while it is decoded, or while levels are made of it.
pub const DECODING_BYTES: u64 = 12;

/// How triangles are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drawn {
    /// They are where a node, a skin or a morph takes them anew in each frame.
    pub moves: bool,
    /// Opaque all over.
    pub is_opaque: bool,
}

/// Bytes of an object of so many triangles.
#[must_use]
pub fn of_object(triangles: u64, drawn: Drawn) -> u64 {
    let opacity = if drawn.is_opaque { 0 } else { OPACITY_BYTES };
    let motion = if drawn.moves { MOTION_BYTES } else { 0 };
    triangles.saturating_mul(TRIANGLE_BYTES + opacity + motion).saturating_add(OBJECT_BYTES)
}

/// Bytes that all light buffers of a frame in which so many triangles move may take: lists of these triangles
/// for the rays to each light that is infinitely far away. Whoever makes them keeps to it.
#[must_use]
pub fn light_buffer_bytes(moving_triangles: u64) -> u64 {
    moving_triangles.saturating_mul(LIGHT_BUFFER_BYTES).min(MOST_LIGHT_BUFFER_BYTES)
}
