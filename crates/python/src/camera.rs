//! Where a scene is seen from.

use glam::Vec3;
use pyo3::{
    exceptions::{PyTypeError, PyValueError},
    prelude::*,
};
use sheer_render::limits::FIELDS_OF_VIEW_DEGREES;
use sheer_scene::{CameraChoice, CameraPose, Lens, Scene, Viewpoint};

use crate::error::Raise as _;

type Triple = (f32, f32, f32);

/// A pose of a camera: where it is, what it looks at, and what it sees from there.
///
/// eye, target: points in world space (right-handed, +Y up), in the units of the scene. Without an eye it
/// stands where the scene's default camera does; without a target it looks at the middle of the scene.
/// up: what is up in the picture, of any length; (0, 1, 0) if not given.
/// fov: the height of the view in degrees, or
/// ortho: in world units, of parallel rays; that of the scene's default camera if neither is given.
///
/// Raises ValueError for numbers that no camera has, and, when it is used, for one that looks at where it is.
#[pyclass(name = "Camera", module = "sheer", frozen)]
#[derive(Debug)]
pub(crate) struct PyCamera {
    view: Viewpoint,
}

#[pymethods]
impl PyCamera {
    #[new]
    #[pyo3(signature = (eye=None, target=None, *, up=None, fov=None, ortho=None))]
    fn new(
        eye: Option<[f32; 3]>,
        target: Option<[f32; 3]>,
        up: Option<[f32; 3]>,
        fov: Option<f32>,
        ortho: Option<f32>,
    ) -> PyResult<Self> {
        let refuse = |problem: &str| Err(PyValueError::new_err(problem.to_owned()));
        let [eye, target, up] = [eye, target, up].map(|point| point.map(Vec3::from));
        if ![eye, target, up].into_iter().flatten().all(Vec3::is_finite) {
            return refuse("a camera's eye, target or up is not finite");
        }
        if eye.is_none() && (target.is_some() || up.is_some()) {
            return refuse("a camera that has a target or an up needs an eye");
        }
        let lens = match (fov, ortho) {
            (Some(_), Some(_)) => return refuse("give a camera fov or ortho, not both"),
            (Some(degrees), None) if FIELDS_OF_VIEW_DEGREES.contains(&degrees) => {
                Some(Lens::Perspective { yfov_rad: degrees.to_radians() })
            }
            (Some(degrees), None) => {
                let (least, most) = FIELDS_OF_VIEW_DEGREES.into_inner();
                return refuse(&format!("fov is {degrees}: give degrees from {least} to {most}"));
            }
            (None, Some(height)) if height.is_normal() && height > 0.0 => {
                Some(Lens::Orthographic { half_height: 0.5 * height })
            }
            (None, Some(height)) => return refuse(&format!("ortho is {height}: give a height above 0")),
            (None, None) => None,
        };
        Ok(Self { view: Viewpoint { eye, target, up, lens } })
    }

    /// Where the camera is, world space; None for the place of the scene's default camera.
    #[getter]
    fn eye(&self) -> Option<Triple> {
        self.view.eye.map(Into::into)
    }

    /// The point that is looked at, world space; None for the middle of the scene.
    #[getter]
    fn target(&self) -> Option<Triple> {
        self.view.target.map(Into::into)
    }

    /// What is up in the picture; None for (0, 1, 0).
    #[getter]
    fn up(&self) -> Option<Triple> {
        self.view.up.map(Into::into)
    }

    /// The height of the view in degrees, of a perspective camera.
    #[getter]
    fn fov(&self) -> Option<f32> {
        match self.view.lens {
            Some(Lens::Perspective { yfov_rad }) => Some(yfov_rad.to_degrees()),
            _ => None,
        }
    }

    /// The height of the view in world units, of an orthographic camera.
    #[getter]
    fn ortho(&self) -> Option<f32> {
        match self.view.lens {
            Some(Lens::Orthographic { half_height }) => Some(2.0 * half_height),
            _ => None,
        }
    }

    fn __repr__(&self) -> String {
        let vectors = [("eye", self.view.eye), ("target", self.view.target), ("up", self.view.up)];
        let vectors =
            vectors.map(|(name, value)| value.map(|Vec3 { x, y, z }| format!("{name}=({x}, {y}, {z})")));
        let numbers = [("fov", self.fov()), ("ortho", self.ortho())];
        let numbers = numbers.map(|(name, value)| value.map(|value| format!("{name}={value}")));
        let all: Vec<String> = vectors.into_iter().chain(numbers).flatten().collect();
        format!("Camera({})", all.join(", "))
    }
}

impl PyCamera {
    /// A pose of the library's; the depths between which it sees are left out.
    pub(crate) fn of_pose(pose: &CameraPose) -> Self {
        let eye = pose.eye();
        let up = pose.world_from_camera.matrix3.y_axis.into();
        let view = Viewpoint {
            eye: Some(eye),
            target: Some(eye + pose.forward()),
            up: Some(up),
            lens: Some(pose.lens),
        };
        Self { view }
    }
}

/// What a `camera` argument means in a scene: nothing, the name of one, or a pose.
pub(crate) fn camera_choice(camera: Option<&Bound<'_, PyAny>>, scene: &Scene) -> PyResult<CameraChoice> {
    let Some(camera) = camera else { return Ok(CameraChoice::Default) };
    if let Ok(name) = camera.extract::<String>() {
        let choice = if name == "orbit" { CameraChoice::Orbit } else { CameraChoice::Named(name) };
        // A name that is not there is told before anything is built.
        scene.camera(&choice).map_err(|error| error.raise())?;
        return Ok(choice);
    }
    let Ok(camera) = camera.cast::<PyCamera>() else {
        let problem = "camera: give the name of one, a sheer.Camera, or None for the scene's own";
        return Err(PyTypeError::new_err(problem));
    };
    camera.get().view.camera(CameraChoice::Default, scene).map_err(|error| error.raise())
}
