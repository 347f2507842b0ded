//! Numbers that stand for words in buffers: uploads write them, shaders read them as constants of the same name.

/// In place of a triangle: the ray hits nothing.
pub(crate) const MISS: u32 = u32::MAX;

/// [`Background::Environment`](sheer_render::Background::Environment).
pub(crate) const BACKGROUND_ENVIRONMENT: u32 = 0;
/// [`Background::Colour`](sheer_render::Background::Colour).
pub(crate) const BACKGROUND_COLOUR: u32 = 1;
/// [`Background::None`](sheer_render::Background::None).
pub(crate) const BACKGROUND_NONE: u32 = 2;

/// In place of infinity, which WGSL has no word for: further than anything, and still a number when a few roundings make it larger.
pub(crate) const FAR_AWAY: f32 = 1e30;
/// Depth of a pixel that sees nothing.
pub(crate) const NO_DEPTH: f32 = FAR_AWAY;
