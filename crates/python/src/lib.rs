//! Sheer for Python: a thin layer over the library, which the wheel `sheer` holds as `sheer._sheer`.
//!
//! Nothing is rendered or measured here: arguments are checked and translated, and planes are handed over as
//! NumPy's arrays. The Python beside it (`crates/python/python/sheer`) gives things their public names and
//! types.

mod camera;
mod compare;
mod error;
mod metrics;
mod picture;
mod pixels;
mod render;
mod run;
mod scene;

use pyo3::prelude::*;

/// What the package `sheer` is made of; import that instead.
#[pymodule]
mod _sheer {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::{
        camera::PyCamera,
        compare::compare,
        error::{SheerError, SheerWarning},
        metrics::{bias, error_map, flicker, flip, flip_map, psnr, rms, ssim, ssim_map, tpsnr, vdp},
        picture::PyPicture,
        render::{PySequence, render, sequence},
        run::methods,
        scene::{PyScene, open, scenes},
    };

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
