//! The figures of pictures, on arrays.

use numpy::{PyArray2, PyArray3};
use pyo3::{exceptions::PyValueError, prelude::*};
use sheer_image::{Image, u8_from_unit};
use sheer_lab::ERROR_FULL_SCALE;
use sheer_metrics::{DEFAULT_PIXELS_PER_DEGREE, MetricError, TemporalPsnr};

use crate::{
    error::{Raise as _, unlocked},
    pixels::{channels, clip, displayed, linear, plane},
};

type Pictures = (Image<[f32; 3]>, Image<[f32; 3]>);
type Clips = (Vec<Image<[f32; 3]>>, Vec<Image<[f32; 3]>>);

/// The figure of two pictures or clips.
fn figure<P: Send, T: Send>(
    py: Python<'_>,
    (reference, image): (P, P),
    metric: impl FnOnce(&P, &P) -> Result<T, MetricError> + Send,
) -> PyResult<T> {
    unlocked(py, move || metric(&reference, &image).map_err(|error| error.raise()))
}

fn both_displayed(reference: &Bound<'_, PyAny>, image: &Bound<'_, PyAny>) -> PyResult<Pictures> {
    Ok((displayed(reference, "reference")?, displayed(image, "image")?))
}

fn both_linear(reference: &Bound<'_, PyAny>, image: &Bound<'_, PyAny>) -> PyResult<Pictures> {
    Ok((linear(reference, "reference")?, linear(image, "image")?))
}

fn both_clips(references: &Bound<'_, PyAny>, images: &Bound<'_, PyAny>) -> PyResult<Clips> {
    Ok((clip(references, "references")?, clip(images, "images")?))
}

/// Structural similarity of two pictures as displayed (Wang et al. 2004): 1 is the same picture.
///
/// Pictures are arrays of shape (height, width, 3), sRGB: floats from 0 to 1, or uint8.
#[pyfunction]
pub(crate) fn ssim(py: Python<'_>, reference: &Bound<'_, PyAny>, image: &Bound<'_, PyAny>) -> PyResult<f64> {
    figure(py, both_displayed(reference, image)?, sheer_metrics::ssim)
}

/// Structural similarity around each pixel and of each channel: float32 of shape (height, width, 3).
///
/// Takes what ssim takes.
#[pyfunction]
pub(crate) fn ssim_map<'py>(
    py: Python<'py>,
    reference: &Bound<'py, PyAny>,
    image: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    channels(py, figure(py, both_displayed(reference, image)?, sheer_metrics::ssim_map)?)
}

/// Peak signal-to-noise ratio of two pictures as displayed, decibels; infinite where they are the same.
///
/// Takes what ssim takes.
#[pyfunction]
pub(crate) fn psnr(py: Python<'_>, reference: &Bound<'_, PyAny>, image: &Bound<'_, PyAny>) -> PyResult<f64> {
    figure(py, both_displayed(reference, image)?, sheer_metrics::psnr_db)
}

/// FLIP of two pictures as displayed (Andersson et al. 2020): the difference that an eye would notice when
/// they alternate on a display, 0 for none, at most 1.
///
/// Takes what ssim takes. The viewer sits before a 4K monitor 0.7 m wide at 0.7 m: 67 pixels a degree, as the
/// paper has it.
#[pyfunction]
pub(crate) fn flip(py: Python<'_>, reference: &Bound<'_, PyAny>, image: &Bound<'_, PyAny>) -> PyResult<f64> {
    figure(py, both_displayed(reference, image)?, sheer_metrics::flip)
}

/// FLIP of each pixel: float32 of shape (height, width). Its mean is the FLIP of the picture.
///
/// Takes what ssim takes. pixels_per_degree: of the viewer's field of view; 67 if not given, as for flip.
#[pyfunction]
#[pyo3(signature = (reference, image, pixels_per_degree=None))]
pub(crate) fn flip_map<'py>(
    py: Python<'py>,
    reference: &Bound<'py, PyAny>,
    image: &Bound<'py, PyAny>,
    pixels_per_degree: Option<f32>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let pixels_per_degree = pixels_per_degree.unwrap_or(DEFAULT_PIXELS_PER_DEGREE);
    // Filters of lower resolutions are narrower than a pixel, of higher ones wider than any picture.
    if !(1.0..=1000.0).contains(&pixels_per_degree) {
        let problem = format!("pixels_per_degree is {pixels_per_degree}: give a number from 1 to 1000");
        return Err(PyValueError::new_err(problem));
    }
    let map = figure(py, both_displayed(reference, image)?, |reference, image| {
        sheer_metrics::flip_map(reference, image, pixels_per_degree)
    })?;
    plane(py, map)
}

/// Root mean square error of two pictures in linear light.
///
/// Pictures are arrays of floats of shape (height, width, 3), linear, as `picture.colour[..., :3]`, which is
/// over black.
#[pyfunction]
pub(crate) fn rms(py: Python<'_>, reference: &Bound<'_, PyAny>, image: &Bound<'_, PyAny>) -> PyResult<f64> {
    figure(py, both_linear(reference, image)?, sheer_metrics::rms)
}

/// Mean error of a picture in linear light with its sign: above 0 it is too bright. Takes what rms takes.
#[pyfunction]
pub(crate) fn bias(py: Python<'_>, reference: &Bound<'_, PyAny>, image: &Bound<'_, PyAny>) -> PyResult<f64> {
    figure(py, both_linear(reference, image)?, sheer_metrics::bias)
}

/// How much the error of a clip changes from frame to frame: its standard deviation over time. A steady error
/// does not flicker.
///
/// Clips are arrays of shape (frames, height, width, 3) or lists of pictures as ssim takes them.
#[pyfunction]
pub(crate) fn flicker(
    py: Python<'_>,
    references: &Bound<'_, PyAny>,
    images: &Bound<'_, PyAny>,
) -> PyResult<f64> {
    figure(py, both_clips(references, images)?, |references, images| {
        sheer_metrics::flicker(references, images)
    })
}

/// Peak signal-to-noise ratio of the changes of a clip from frame to frame, decibels: what shimmers lowers
/// it, a steady error does not. Infinite where they are the same, None for a clip of one frame.
///
/// Takes what flicker takes.
#[pyfunction]
pub(crate) fn tpsnr(
    py: Python<'_>,
    references: &Bound<'_, PyAny>,
    images: &Bound<'_, PyAny>,
) -> PyResult<Option<f64>> {
    figure(py, both_clips(references, images)?, |references, images| {
        if references.len() != images.len() || images.is_empty() {
            return Err(MetricError::FramesDiffer { references: references.len(), images: images.len() });
        }
        let mut tpsnr = TemporalPsnr::new();
        references.iter().zip(images).try_for_each(|(reference, image)| tpsnr.add(reference, image))?;
        Ok(tpsnr.value_db())
    })
}

/// Quality of a clip to a viewer by ColorVideoVDP (Mantiuk et al. 2024), in just-objectionable differences:
/// 10 is no visible one; at 9, three in four viewers prefer the reference.
///
/// Takes what flicker takes. fps: frames a second at which the clip is played.
#[pyfunction]
#[pyo3(signature = (references, images, fps=30.0))]
pub(crate) fn vdp(
    py: Python<'_>,
    references: &Bound<'_, PyAny>,
    images: &Bound<'_, PyAny>,
    fps: f32,
) -> PyResult<f64> {
    let bytes = |clip: &[Image<[f32; 3]>]| -> Vec<Image<[u8; 3]>> {
        clip.iter().map(|frame| frame.map(|pixel| pixel.map(u8_from_unit))).collect()
    };
    figure(py, both_clips(references, images)?, |references, images| {
        sheer_metrics::video_vdp_jod(&bytes(references), &bytes(images), fps)
    })
}

/// Where two pictures as displayed differ, in false colours: uint8 of shape (height, width, 4), sRGB. The
/// last colour stands for a root mean square difference of full_scale over the channels.
///
/// Takes what ssim takes.
#[pyfunction]
#[pyo3(signature = (reference, image, full_scale=None))]
pub(crate) fn error_map<'py>(
    py: Python<'py>,
    reference: &Bound<'py, PyAny>,
    image: &Bound<'py, PyAny>,
    full_scale: Option<f32>,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let full_scale = full_scale.unwrap_or(ERROR_FULL_SCALE);
    if !(full_scale.is_normal() && full_scale > 0.0) {
        return Err(PyValueError::new_err(format!("full_scale is {full_scale}: give a number above 0")));
    }
    let map = figure(py, both_displayed(reference, image)?, |reference, image| {
        sheer_metrics::error_map(reference, image, full_scale)
    })?;
    channels(py, map)
}
