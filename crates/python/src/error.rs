//! Errors of the library as Python's exceptions, with its words, and what happens beside Python's lock.

use std::{error::Error, io};

use pyo3::{
    create_exception,
    exceptions::{
        PyException, PyFileNotFoundError, PyIsADirectoryError, PyOSError, PyPermissionError, PyUserWarning,
        PyValueError,
    },
    prelude::*,
};
use sheer_core::caught_panic;
use sheer_gallery::GalleryError;
use sheer_image::ImageError;
use sheer_lab::LabError;
use sheer_load::LoadError;
use sheer_metrics::MetricError;
use sheer_render::{MethodError, RenderError, shadow::ShadowError, temporal::AntialiasingError};
use sheer_scene::SceneError;

create_exception!(
    sheer,
    SheerError,
    PyException,
    "What went wrong though everything was asked for as it should be: a broken file, a limit that is reached."
);
create_exception!(
    sheer,
    SheerWarning,
    PyUserWarning,
    "What is not shown as the author of a file meant it, or not measured as one may think."
);

/// An error of the library that becomes one of Python's.
pub(crate) trait Raise {
    /// The exception.
    fn raise(self) -> PyErr;
}

impl Raise for LoadError {
    fn raise(self) -> PyErr {
        let text = in_python(&self.to_string());
        match self {
            Self::Read { source, .. } => of_system(&source, text),
            Self::UnknownFormat { .. } | Self::NoChoice { .. } => PyValueError::new_err(text),
            Self::File { .. } | Self::Limit { .. } => SheerError::new_err(text),
        }
    }
}

impl Raise for GalleryError {
    fn raise(self) -> PyErr {
        match self {
            Self::Load(error) => error.raise(),
            Self::Scene(error) => error.raise(),
            other => wrong_value(&other),
        }
    }
}

impl Raise for SceneError {
    fn raise(self) -> PyErr {
        wrong_value(&self)
    }
}

impl Raise for MethodError {
    fn raise(self) -> PyErr {
        wrong_value(&self)
    }
}

impl Raise for AntialiasingError {
    fn raise(self) -> PyErr {
        wrong_value(&self)
    }
}

impl Raise for ShadowError {
    fn raise(self) -> PyErr {
        wrong_value(&self)
    }
}

impl Raise for ImageError {
    fn raise(self) -> PyErr {
        let text = in_python(&self.to_string());
        match self {
            Self::MissingFolder { .. } => PyFileNotFoundError::new_err(text),
            Self::IsFolder { .. } => PyIsADirectoryError::new_err(text),
            Self::Read { source, .. } | Self::Write { source, .. } => of_system(&source, text),
            Self::Size { .. }
            | Self::PixelCount { .. }
            | Self::SizesDiffer { .. }
            | Self::UnknownExtension { .. }
            | Self::MetadataKey { .. } => PyValueError::new_err(text),
            _ => SheerError::new_err(text),
        }
    }
}

impl Raise for RenderError {
    fn raise(self) -> PyErr {
        match self {
            Self::Scene(error) => error.raise(),
            Self::Image(error) => error.raise(),
            Self::Crop { .. } => wrong_value(&self),
            Self::Threads(_) | Self::ShadowMaps { .. } => SheerError::new_err(in_python(&self.to_string())),
        }
    }
}

impl Raise for MetricError {
    fn raise(self) -> PyErr {
        match self {
            Self::SizesDiffer { .. } | Self::FramesDiffer { .. } => wrong_value(&self),
            Self::Image(error) => error.raise(),
            other => SheerError::new_err(in_python(&other.to_string())),
        }
    }
}

impl Raise for LabError {
    fn raise(self) -> PyErr {
        match self {
            Self::Misuse(_) => wrong_value(&self),
            Self::Render(error) => error.raise(),
            Self::Gallery(error) => error.raise(),
            Self::Scene(error) => error.raise(),
            Self::Image(error) => error.raise(),
            Self::Metric(error) => error.raise(),
            Self::Method(error) => error.raise(),
            Self::Shadow(error) => error.raise(),
            Self::Temporary(ref error) => of_system(error, in_python(&self.to_string())),
            Self::Backend(inner) => match inner.downcast::<RenderError>() {
                Ok(error) => error.raise(),
                Err(other) => SheerError::new_err(in_python(&other.to_string())),
            },
            // What Python itself has raised on the way: KeyboardInterrupt.
            Self::Output(inner) => match inner.downcast::<PyErr>() {
                Ok(error) => *error,
                Err(other) => SheerError::new_err(in_python(&other.to_string())),
            },
            other => SheerError::new_err(in_python(&other.to_string())),
        }
    }
}

/// What was asked for cannot be.
fn wrong_value(error: &dyn Error) -> PyErr {
    PyValueError::new_err(in_python(&error.to_string()))
}

/// What the operating system refuses.
fn of_system(error: &io::Error, text: String) -> PyErr {
    match error.kind() {
        io::ErrorKind::NotFound => PyFileNotFoundError::new_err(text),
        io::ErrorKind::PermissionDenied => PyPermissionError::new_err(text),
        io::ErrorKind::IsADirectory => PyIsADirectoryError::new_err(text),
        _ => PyOSError::new_err(text),
    }
}

/// A message of the library, which names options of the command line, in the words of a Python program:
/// parameters are called as the options are, `memory_limit=` for `--memory-limit`.
fn in_python(text: &str) -> String {
    let mut parts = text.split("--");
    let mut said = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let end =
            part.find(|letter: char| !letter.is_ascii_lowercase() && letter != '-').unwrap_or(part.len());
        let (option, rest) = part.split_at(end);
        // In the name of a file there are dashes, too.
        if option.is_empty() || said.ends_with(|before: char| !before.is_whitespace() && before != '(') {
            said += "--";
            said += part;
        } else {
            said += &option.replace('-', "_");
            // A value may follow it already.
            said += if rest.starts_with('=') { "" } else { "=" };
            said += rest;
        }
    }
    said.replace("`sheer scenes`", "`sheer.scenes()`").replace("`sheer methods`", "`sheer.methods()`")
}

/// Does something while other threads of Python run. A panic is an exception like others.
pub(crate) fn unlocked<T: Send>(py: Python<'_>, task: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    py.detach(|| caught_panic::catch(task)).unwrap_or_else(|panic| {
        Err(SheerError::new_err(format!(
            "a fault of the library: {panic}; please report it with what led to it"
        )))
    })
}

/// Raises KeyboardInterrupt, and what else handlers of signals raise, where one has come since.
pub(crate) fn check_signals() -> sheer_lab::Result<()> {
    Python::attach(|py| py.check_signals()).map_err(|error| LabError::Output(error.into()))
}
