//! What passes work on, as thin layers over wgpu: buffers and their limits, targets, and how they are bound.

pub(crate) mod bind_group;
pub(crate) mod buffer;
pub(crate) mod list;
pub(crate) mod target;
