//! How a caller sees the scene: the two matrices that engines have of a camera, as plain arrays.

use glam::{Affine3A, Mat3, Mat4};
use sheer_scene::{CameraPose, ClipPlanes, Lens};

use crate::error::GpuError;

/// Sides of a pixel may differ by this share: what rounding leaves of a projection.
const ASPECT_SLACK: f32 = 1e-4;
/// What rounding leaves of a product of rotations.
const ROTATION_SLACK: f32 = 1e-3;

/// A camera by its matrices, columns first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Rigid; the camera looks along its own -Z, +Y is up, world is right-handed.
    pub world_from_view: [[f32; 4]; 4],
    /// The projection of wgpu, with depths from 0 to 1: perspective or orthographic, the near plane at 0 or,
    /// reversed, at 1, the far plane finite or not. Symmetric about the axis, without jitter: that is
    /// [`GpuPipeline::jitter`](crate::GpuPipeline::jitter).
    pub clip_from_view: [[f32; 4]; 4],
}

impl View {
    /// The camera's pose for a picture of so many columns and rows.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] says what is off: the projection is skewed or has pixels that are not
    /// square.
    pub fn pose(&self, [width, height]: [u32; 2]) -> Result<CameraPose, GpuError> {
        let refused = |what: &str, instead: &str| GpuError::Unsupported {
            what: format!("the projection of the view {what}"),
            instead: instead.to_owned(),
        };
        let [x, y, z, w] = self.clip_from_view;
        let is_orthographic = w[3] != 0.0;
        if [x[1], x[2], x[3], y[0], y[2], y[3], z[0], z[1], w[0], w[1]].iter().any(|&entry| entry != 0.0) {
            return Err(refused("is skewed or jittered", "leave jitter to the pipeline"));
        }
        if !(x[0] > 0.0 && y[1] > 0.0) || is_orthographic != (z[3] == 0.0) {
            return Err(refused("is neither perspective nor orthographic", "take one of the two"));
        }
        let aspect = y[1] / x[0] * (height as f32 / width as f32);
        if (aspect - 1.0).abs() > ASPECT_SLACK {
            return Err(refused(
                &format!("has pixels {aspect} times as wide as high in a picture of {width}x{height}"),
                "give it the picture's aspect ratio",
            ));
        }
        let axes = Mat3::from_mat4(Mat4::from_cols_array_2d(&self.world_from_view));
        let is_rigid = (axes.transpose() * axes).abs_diff_eq(Mat3::IDENTITY, ROTATION_SLACK);
        if !is_rigid || axes.determinant() < 0.0 {
            return Err(GpuError::Unsupported {
                what: "the matrix of the view mirrors, scales or shears".to_owned(),
                instead: "take a rotation and a translation".to_owned(),
            });
        }
        let lens = if is_orthographic {
            Lens::Orthographic { half_height: w[3] / y[1] }
        } else {
            Lens::Perspective { yfov_rad: 2.0 * (z[3].abs() / y[1]).atan() }
        };
        // Where depth is 0 and where it is 1, in whichever order.
        let [one, other] = [0.0, 1.0].map(|ndc| DepthRow::of(&self.clip_from_view).distance(ndc));
        let (near, far) = if one < other { (one, other) } else { (other, one) };
        Ok(CameraPose {
            world_from_camera: Affine3A::from_mat4(Mat4::from_cols_array_2d(&self.world_from_view)),
            lens,
            clip: ClipPlanes { near, far },
        })
    }
}

/// What a projection makes of distances: the third and fourth entry of its third and fourth column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DepthRow(pub(crate) [f32; 4]);

impl DepthRow {
    pub(crate) fn of([_, _, z, w]: &[[f32; 4]; 4]) -> Self {
        Self([z[2], w[2], z[3], w[3]])
    }

    /// Distance along the viewing axis that has a depth; infinite where it is beyond all.
    pub(crate) fn distance(self, ndc: f32) -> f32 {
        let Self([z_of_z, z_of_one, w_of_z, w_of_one]) = self;
        // ndc = (z_of_z · z + z_of_one) / (w_of_z · z + w_of_one), solved for -z.
        let distance = (z_of_one - ndc * w_of_one) / (z_of_z - ndc * w_of_z);
        if distance.is_finite() && distance >= 0.0 { distance } else { f32::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [96, 64];
    const ASPECT: f32 = 1.5;

    fn view(clip_from_view: [[f32; 4]; 4]) -> View {
        View { world_from_view: Mat4::IDENTITY.to_cols_array_2d(), clip_from_view }
    }

    /// Depth 0 at `first` and 1 at `last`, either of which may be infinite.
    fn perspective(yfov_rad: f32, aspect: f32, first: f32, last: f32) -> [[f32; 4]; 4] {
        let y = (0.5 * yfov_rad).tan().recip();
        let [slope, offset] = if last.is_infinite() {
            [-1.0, -first]
        } else if first.is_infinite() {
            [0.0, last]
        } else {
            [last / (first - last), first * last / (first - last)]
        };
        [[y / aspect, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, slope, -1.0], [0.0, 0.0, offset, 0.0]]
    }

    fn orthographic(half_height: f32, first: f32, last: f32) -> [[f32; 4]; 4] {
        let y = half_height.recip();
        let (slope, offset) = ((first - last).recip(), first / (first - last));
        [[y / ASPECT, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, slope, 0.0], [0.0, 0.0, offset, 1.0]]
    }

    #[test]
    fn every_usual_projection_gives_its_lens_and_its_clip_planes() {
        let (yfov_rad, near, far) = (1.0_f32, 0.1, 100.0);
        let deep = Lens::Perspective { yfov_rad };
        let flat = Lens::Orthographic { half_height: 2.0 };
        let infinity = f32::INFINITY;
        for (matrix, lens, far) in [
            (perspective(yfov_rad, ASPECT, near, far), deep, far),
            // Reversed.
            (perspective(yfov_rad, ASPECT, far, near), deep, far),
            (perspective(yfov_rad, ASPECT, near, infinity), deep, infinity),
            (perspective(yfov_rad, ASPECT, infinity, near), deep, infinity),
            (orthographic(2.0, near, far), flat, far),
            (orthographic(2.0, far, near), flat, far),
        ] {
            let pose = view(matrix).pose(SIZE).unwrap();
            let is_near = |found: f32, expected: f32| {
                found == expected || (found - expected).abs() <= 1e-3 * expected.abs()
            };
            match (pose.lens, lens) {
                (Lens::Perspective { yfov_rad: found }, Lens::Perspective { yfov_rad: expected })
                | (Lens::Orthographic { half_height: found }, Lens::Orthographic { half_height: expected }) =>
                {
                    assert!(is_near(found, expected), "{matrix:?}: {found}");
                }
                (found, _) => panic!("{matrix:?}: {found:?}"),
            }
            assert!(
                is_near(pose.clip.near, near) && is_near(pose.clip.far, far),
                "{matrix:?}: {:?}",
                pose.clip
            );
        }
    }

    #[test]
    fn what_is_no_plain_camera_is_refused_by_what_is_wrong() {
        let plain = perspective(1.0, ASPECT, 0.1, 10.0);
        let mut jittered = plain;
        jittered[2][0] = 0.01;
        let mut mirrored = view(plain);
        mirrored.world_from_view[0][0] = -1.0;
        for (view, word) in [
            (view(jittered), "jittered"),
            (view(perspective(1.0, 1.0, 0.1, 10.0)), "as wide as high"),
            (view([[0.0; 4]; 4]), "neither"),
            (mirrored, "mirrors"),
        ] {
            let error = view.pose(SIZE).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
