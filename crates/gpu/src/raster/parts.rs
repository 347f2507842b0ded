//! What the techniques of the raster path are made from.

use crate::{device::Gpu, layouts::Layouts, shader::Linker};

/// The device and the shaders of one method.
pub(crate) struct Parts<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) layouts: &'a Layouts,
    /// Knows how rays of light are traced; what goes by it is the same for all methods, and drivers compile it once.
    pub(crate) linker: &'a Linker,
    /// Knows the method, too.
    pub(crate) method_linker: Linker,
    /// Pixels.
    pub(crate) size: [u32; 2],
}
