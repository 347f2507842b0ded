//! What the techniques of the raster path are made from.

use crate::{device::Gpu, layouts::Layouts, shader::Linker};

/// The device and the shaders of one method.
pub(crate) struct Parts<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) layouts: &'a Layouts,
    /// Knows how rays of light are traced; what goes by it is the same for all methods, and drivers compile
    /// it once.
    pub(crate) linker: &'a Linker,
    /// Knows the method as well: for shaders that differ from method to method.
    pub(crate) method_linker: Linker,
    /// Columns and rows of pixels of the picture.
    pub(crate) size: [u32; 2],
}
