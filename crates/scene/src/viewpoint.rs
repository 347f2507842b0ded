//! Views of a caller's own.

use glam::Vec3;

use crate::{
    SceneError,
    camera::{Camera, CameraPose, Lens},
    scene::{CameraChoice, Scene},
};

/// Where a scene is seen from, where none of its cameras will do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Viewpoint {
    /// Where the camera is, world; where the chosen camera is if none.
    pub eye: Option<Vec3>,
    /// What an [`eye`](Self::eye) looks at, world; the middle of the scene if none.
    pub target: Option<Vec3>,
    /// What is up in the picture that it sees, of any length; +Y if none.
    pub up: Option<Vec3>,
    /// What is seen from there; what the chosen camera sees if none.
    pub lens: Option<Lens>,
}

impl Viewpoint {
    /// The camera that looks from here; the chosen one where nothing is asked for.
    ///
    /// # Errors
    /// [`SceneError::NoCamera`] if there is no such camera, [`SceneError::NoDirection`] if it is to look at
    /// where it is.
    pub fn camera(&self, chosen: CameraChoice, scene: &Scene) -> Result<CameraChoice, SceneError> {
        if self.eye.is_none() && self.lens.is_none() {
            return Ok(chosen);
        }
        let camera = scene.camera(&chosen)?;
        let lens = self.lens.unwrap_or(camera.lens);
        // Under a name of its own no animation of a lens applies to it.
        let name = "own".to_owned();
        let Some(eye) = self.eye else {
            return Ok(CameraChoice::Own(Camera { name, lens, ..camera }));
        };
        let target = self.target.unwrap_or_else(|| scene.bounding_sphere().0);
        if eye == target {
            return Err(SceneError::NoDirection);
        }
        let up = self.up.unwrap_or(Vec3::Y);
        Ok(CameraChoice::Own(Camera::still(&name, CameraPose::looking_at_with_up(lens, eye, target, up))))
    }
}
