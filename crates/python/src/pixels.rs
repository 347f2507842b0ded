//! NumPy's arrays made of pictures, without a copy, and pictures made of arrays.

use numpy::{
    Element, PyArray, PyArray2, PyArray3, PyArrayDescrMethods as _, PyArrayDyn, PyArrayMethods as _,
    PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods as _,
};
use pyo3::{
    exceptions::{PyTypeError, PyValueError},
    prelude::*,
};
use sheer_image::{Image, unit_from_u8};

use crate::error::Raise as _;

/// One number a pixel, as an array of height by width that takes the pixels over.
pub(crate) fn plane<T: Element>(py: Python<'_>, image: Image<T>) -> PyResult<Bound<'_, PyArray2<T>>> {
    let (width, height) = image.size();
    PyArray::from_vec(py, image.into_vec()).reshape([height as usize, width as usize])
}

/// Several numbers a pixel, as an array of height by width by their number that takes the pixels over.
pub(crate) fn channels<T: Element, const N: usize>(
    py: Python<'_>,
    image: Image<[T; N]>,
) -> PyResult<Bound<'_, PyArray3<T>>> {
    let (width, height) = image.size();
    PyArray::from_vec(py, image.into_vec().into_flattened()).reshape([height as usize, width as usize, N])
}

/// What kinds of numbers an array holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Numbers {
    /// Of any width.
    Floats,
    /// 0 to 255.
    Bytes,
    /// Of any other width, signed or not.
    Integers,
}

/// Whatever NumPy makes an array of, with its shape and the kind of its numbers. `what` names it in messages.
pub(crate) fn array_of<'py>(
    object: &Bound<'py, PyAny>,
    what: &str,
) -> PyResult<(Bound<'py, PyUntypedArray>, Vec<usize>, Numbers)> {
    let numpy = object.py().import("numpy")?;
    let array = numpy.call_method1("asarray", (object,))?.cast_into::<PyUntypedArray>()?;
    let dtype = array.dtype();
    let numbers = match (dtype.kind(), dtype.itemsize()) {
        (b'f', _) => Numbers::Floats,
        (b'u', 1) => Numbers::Bytes,
        (b'i' | b'u', _) => Numbers::Integers,
        _ => {
            return Err(PyTypeError::new_err(format!(
                "{what}: an array of {dtype} holds no numbers that could be"
            )));
        }
    };
    let shape = array.shape().to_vec();
    Ok((array, shape, numbers))
}

/// The numbers of an array row by row, as a type: themselves where they are so already.
pub(crate) fn in_order<'py, T: Element>(
    array: &Bound<'py, PyUntypedArray>,
    dtype: &str,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let numpy = array.py().import("numpy")?;
    let array = numpy.call_method1("ascontiguousarray", (array, dtype))?.cast_into::<PyArrayDyn<T>>()?;
    Ok(array.try_readonly()?)
}

/// A picture of three channels, 0 to 1 where it is of bytes. `what` names it in messages.
fn picture(
    array: &Bound<'_, PyUntypedArray>,
    numbers: Numbers,
    [height, width]: [usize; 2],
) -> PyResult<Image<[f32; 3]>> {
    let pixels = match numbers {
        Numbers::Bytes => {
            let bytes = in_order::<u8>(array, "uint8")?;
            bytes.as_slice()?.as_chunks::<3>().0.iter().map(|pixel| pixel.map(unit_from_u8)).collect()
        }
        _ => in_order::<f32>(array, "float32")?.as_slice()?.as_chunks::<3>().0.to_vec(),
    };
    let side = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
    Image::from_vec(side(width), side(height), pixels).map_err(|error| error.raise())
}

/// A picture of a display: height by width by three, floats from 0 to 1, or bytes.
pub(crate) fn displayed(object: &Bound<'_, PyAny>, what: &str) -> PyResult<Image<[f32; 3]>> {
    let (array, shape, numbers) = array_of(object, what)?;
    let [height, width] = picture_shape(&shape, what)?;
    if numbers == Numbers::Integers {
        let problem = format!("{what}: give floats from 0 to 1, or uint8, sRGB as displayed");
        return Err(PyTypeError::new_err(problem));
    }
    picture(&array, numbers, [height, width])
}

/// A picture of linear light: height by width by three, floats.
pub(crate) fn linear(object: &Bound<'_, PyAny>, what: &str) -> PyResult<Image<[f32; 3]>> {
    let (array, shape, numbers) = array_of(object, what)?;
    let size = picture_shape(&shape, what)?;
    if numbers != Numbers::Floats {
        let problem = format!("{what}: give floats, linear light; integers are no light");
        return Err(PyTypeError::new_err(problem));
    }
    picture(&array, numbers, size)
}

/// The frames of a clip for a display: an array of frames by height by width by three, or a sequence of
/// pictures.
pub(crate) fn clip(object: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<Image<[f32; 3]>>> {
    object
        .try_iter()?
        .enumerate()
        .map(|(frame, picture)| displayed(&picture?, &format!("{what}[{frame}]")))
        .collect()
}

fn picture_shape(shape: &[usize], what: &str) -> PyResult<[usize; 2]> {
    match *shape {
        [height, width, 3] => Ok([height, width]),
        _ => Err(PyValueError::new_err(format!(
            "{what}: its shape is {shape:?}; give height by width by 3 (red, green, blue), over a background if it has alpha"
        ))),
    }
}
