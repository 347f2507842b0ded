//! A rendered picture: its planes as NumPy's arrays.

use std::path::PathBuf;

use numpy::{PyArray2, PyArray3, PyArrayMethods as _};
use pyo3::{
    prelude::*,
    types::{PyBytes, PyDict, PyEllipsis},
};
use sheer_image::{
    DisplayShare, Image, Metadata, Piece, PixelLayers, Planes, Tone, display, display_over_black, encode_png,
    write_frame,
};

use crate::{
    error::{Raise as _, unlocked},
    pixels::{channels, plane},
};

/// What a picture has beside its planes.
pub(crate) struct Origin {
    /// How much of it is display-referred.
    pub(crate) share: DisplayShare,
    /// How it is shown.
    pub(crate) tone: Tone,
    /// How it was made.
    pub(crate) metadata: Metadata,
}

/// A rendered picture. Its planes are NumPy arrays whose first index is the row, from the top, and whose
/// second is the column; they take the renderer's memory over, and are the caller's to change.
///
/// Notebooks show it as a PNG file would.
#[pyclass(name = "Picture", module = "sheer", frozen)]
pub(crate) struct PyPicture {
    size: [u32; 2],
    /// Linear light (Rec. 709 primaries), red, green, blue and alpha: float32 of shape (height, width, 4), at
    /// least 0 and without an upper bound. Colour is premultiplied by alpha, which is the opacity, 1 where
    /// nothing shows through. Added up over frames, but for raw.
    #[pyo3(get)]
    colour: Py<PyArray3<f32>>,
    /// Distance along the viewing axis in the units of the scene, infinite where nothing is: float32 of shape
    /// (height, width). This and all that follows is of the last frame.
    #[pyo3(get)]
    depth: Py<PyArray2<f32>>,
    /// Where the surface was in the frame before, minus where it is, in pixels, x to the right and y down:
    /// float32 of shape (height, width, 2).
    #[pyo3(get)]
    motion: Py<PyArray3<f32>>,
    /// Number of the object that is seen, 4294967295 where nothing is: uint32 of shape (height, width).
    #[pyo3(get)]
    instance: Py<PyArray2<u32>>,
    /// Number of its triangle, 4294967295 where nothing is: uint32 of shape (height, width).
    #[pyo3(get)]
    primitive: Py<PyArray2<u32>>,
    /// Whether anything transparent takes part in the pixel: bool of shape (height, width).
    #[pyo3(get)]
    transparent: Py<PyArray2<bool>>,
    layers: Option<Image<PixelLayers>>,
    origin: Origin,
}

#[pymethods]
impl PyPicture {
    /// Width and height, pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        self.size.into()
    }

    /// The opacity, 0 to 1: a view of the fourth channel of colour, float32 of shape (height, width).
    #[getter]
    fn alpha<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.colour.bind(py).get_item((PyEllipsis::get(py), 3))
    }

    /// What each pixel has before its nearest opaque surface, the front, and that surface, the back, where
    /// they are told apart: under "layered", and in raw frames; None elsewhere. A dict of arrays: `coverage`
    /// (share of the front in what is seen, 0 to 1), `absorbed` (red, green and blue that coloured glass in
    /// the front takes from the back beyond that), `share` (probability with which the shaded fragment was
    /// one of the front), `is_front` (bool: whether it is), `front_motion`, `front_depth`, `back_motion`,
    /// `back_depth`. They are copied at each call.
    #[getter]
    fn layers<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(layers) = &self.layers else { return Ok(None) };
        let arrays = PyDict::new(py);
        arrays.set_item("coverage", plane(py, layers.map(|pixel| pixel.coverage))?)?;
        arrays.set_item("absorbed", channels(py, layers.map(|pixel| pixel.absorbed))?)?;
        arrays.set_item("share", plane(py, layers.map(|pixel| pixel.share))?)?;
        arrays.set_item("is_front", plane(py, layers.map(|pixel| pixel.is_front))?)?;
        arrays.set_item("front_motion", channels(py, layers.map(|pixel| pixel.front_motion))?)?;
        arrays.set_item("front_depth", plane(py, layers.map(|pixel| pixel.front_depth))?)?;
        arrays.set_item("back_motion", channels(py, layers.map(|pixel| pixel.back_motion))?)?;
        arrays.set_item("back_depth", plane(py, layers.map(|pixel| pixel.back_depth))?)?;
        Ok(Some(arrays))
    }

    /// How the picture was made: texts by key, as they stand in its files.
    #[getter]
    fn info<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let info = PyDict::new(py);
        self.origin.metadata.entries().try_for_each(|(key, text)| info.set_item(key, text))?;
        Ok(info)
    }

    /// What a display shows, as in a PNG file: uint8 of shape (height, width, 4), sRGB after the tone curve,
    /// straight alpha.
    fn srgb<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let shown = self.shown(py)?;
        channels(py, shown)
    }

    /// What a display shows over black, as metrics take it: float32 of shape (height, width, 3), sRGB after
    /// the tone curve, 0 to 1.
    fn displayed<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let colour = self.colour_image(py)?;
        let Origin { tone, ref share, .. } = self.origin;
        let shown = unlocked(py, || Ok(display_over_black(&colour, tone, share)))?;
        channels(py, shown)
    }

    /// Writes the picture: .png (as `srgb()`), or .exr (linear light with all planes).
    ///
    /// Raises ValueError for another ending, OSError where it cannot be written; no part of a file is left.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let planes = self.planes(py)?;
        let Origin { tone, ref share, ref metadata } = self.origin;
        unlocked(py, || {
            let piece = Piece::whole(self.size);
            write_frame(&path, &planes, &piece, tone, share, metadata).map_err(|error| error.raise())
        })
    }

    /// The bytes of a PNG file.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let shown = self.shown(py)?;
        let metadata = self.origin.tone.described(self.origin.metadata.clone());
        let png = unlocked(py, || encode_png(&shown, &metadata).map_err(|error| error.raise()))?;
        Ok(PyBytes::new(py, &png))
    }

    fn __repr__(&self) -> String {
        let of = |key: &str| self.origin.metadata.get(key).unwrap_or_default().to_owned();
        let [width, height] = self.size;
        format!("<sheer.Picture {width}x{height} of {:?}, {}, {}>", of("scene"), of("method"), of("aa"))
    }
}

impl PyPicture {
    /// Takes the planes over.
    pub(crate) fn new(py: Python<'_>, planes: Planes, origin: Origin) -> PyResult<Self> {
        let (width, height) = planes.colour.size();
        Ok(Self {
            size: [width, height],
            colour: channels(py, planes.colour)?.unbind(),
            depth: plane(py, planes.depth)?.unbind(),
            motion: channels(py, planes.motion)?.unbind(),
            instance: plane(py, planes.instance)?.unbind(),
            primitive: plane(py, planes.primitive)?.unbind(),
            transparent: plane(py, planes.transparent)?.unbind(),
            layers: planes.layers,
            origin,
        })
    }

    fn image<T>(&self, pixels: Vec<T>) -> PyResult<Image<T>> {
        let [width, height] = self.size;
        Image::from_vec(width, height, pixels).map_err(|error| error.raise())
    }

    /// The colour as the caller has left it.
    fn colour_image(&self, py: Python<'_>) -> PyResult<Image<[f32; 4]>> {
        let colour = self.colour.bind(py).try_readonly()?;
        self.image(colour.as_slice()?.as_chunks::<4>().0.to_vec())
    }

    fn shown(&self, py: Python<'_>) -> PyResult<Image<[u8; 4]>> {
        let colour = self.colour_image(py)?;
        let Origin { tone, ref share, .. } = self.origin;
        unlocked(py, || Ok(display(&colour, tone, share)))
    }

    /// All planes as the caller has left them.
    fn planes(&self, py: Python<'_>) -> PyResult<Planes> {
        let motion = self.motion.bind(py).try_readonly()?;
        Ok(Planes {
            colour: self.colour_image(py)?,
            depth: self.image(self.depth.bind(py).to_vec()?)?,
            motion: self.image(motion.as_slice()?.as_chunks::<2>().0.to_vec())?,
            instance: self.image(self.instance.bind(py).to_vec()?)?,
            primitive: self.image(self.primitive.bind(py).to_vec()?)?,
            transparent: self.image(self.transparent.bind(py).to_vec()?)?,
            layers: self.layers.clone(),
        })
    }
}
