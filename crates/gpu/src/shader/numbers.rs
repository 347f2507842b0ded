//! Numbers that stand for words in buffers: uploads write them, shaders read them as constants of the same
//! name.

/// In place of a triangle: the ray hits nothing.
pub(crate) const MISS: u32 = u32::MAX;

/// [`Background::Environment`](sheer_render::Background::Environment).
pub(crate) const BACKGROUND_ENVIRONMENT: u32 = 0;
/// [`Background::Colour`](sheer_render::Background::Colour).
pub(crate) const BACKGROUND_COLOUR: u32 = 1;
/// [`Background::None`](sheer_render::Background::None).
pub(crate) const BACKGROUND_NONE: u32 = 2;

/// In place of infinity, which WGSL has no word for: further than anything, and still a number when a few
/// roundings make it larger.
pub(crate) const FAR_AWAY: f32 = 1e30;
/// Depth of a pixel that sees nothing.
pub(crate) const NO_DEPTH: f32 = FAR_AWAY;

/// The end of a list of nodes, which are counted from 1: what a cleared buffer holds.
pub(crate) const LIST_END: u32 = 0;

/// Columns and rows of pixels that a workgroup makes.
pub(crate) const GROUP_SIDE: u32 = 8;
/// Inputs that a workgroup of a test's shader takes.
pub(crate) const PROBE_GROUP: u32 = 64;

/// Relative spacing of 32-bit floats.
pub(crate) const EPSILON: f32 = f32::EPSILON;
/// The least 32-bit float with all its digits: keeps divisors away from zero.
pub(crate) const LEAST_NORMAL: f32 = f32::MIN_POSITIVE;
/// The largest 32-bit float.
pub(crate) const GREATEST: f32 = f32::MAX;
/// The largest 16-bit float: more comes out of a blending unit as infinite.
pub(crate) const LARGEST_HALF: f32 = 65504.0;
