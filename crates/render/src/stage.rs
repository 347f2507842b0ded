//! A scene at a time, ready to be traced.

use std::{sync::Arc, time::Instant};

use glam::{UVec2, Vec2, Vec3};
use rayon::{ThreadPool, ThreadPoolBuilder, prelude::*};
use sheer_accel::{Bvh, Instance, LightBuffer, MeshTree, Ray};
use sheer_scene::{
    Animator, CameraChoice, CameraPose, CameraRay, Frame, MeshInstance, MovingObjects, Scene, Sharing,
};

use crate::{error::RenderError, light_buffers::LightBuffers};

/// A point in time and the one its motion vectors point to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Time of the frame, seconds.
    pub time_secs: f32,
    /// Time of the frame before, seconds.
    pub previous_secs: f32,
}

/// A scene, seen through one of its cameras, at a time: the frame's geometry and the acceleration structure
/// over it. Several pipelines can render from one stage.
#[derive(Debug)]
pub struct Stage {
    animator: Animator,
    bvh: Bvh,
    /// What moves in the frame that `bvh` was last fitted to.
    moving: MovingObjects,
    /// The scene's meshes whose triangles instances share, ascending: those of the acceleration structure.
    shared_meshes: Vec<u32>,
    light_buffers: LightBuffers,
    pool: ThreadPool,
    build_ms: f64,
    /// Ray origins are lifted off surfaces by this much, so that rounding does not shadow a surface by
    /// itself: world units.
    lift: f32,
}

/// Share of the scene's radius by which shadow rays are lifted off their surface. At a few times the rounding
/// error of a hit point.
const LIFT: f32 = 1e-5;

/// How far the rays that start on a surface of a scene are lifted off it, world units. Of a scene that lies
/// far from the origin for its size it is the rounding error of its coordinates that counts.
#[must_use]
pub fn lift(scene: &Scene) -> f32 {
    let (centre, radius) = scene.bounding_sphere();
    (LIFT * radius).max(4.0 * f32::EPSILON * centre.abs().max_element())
}

impl Stage {
    /// Prepares a scene at time zero. `threads`: how many to use, all the processor's by default.
    ///
    /// # Errors
    /// The scene has no such camera, or the threads cannot be started.
    pub fn new(
        scene: impl Into<Arc<Scene>>,
        camera: &CameraChoice,
        threads: Option<usize>,
    ) -> Result<Self, RenderError> {
        Self::with_sharing(scene, camera, threads, Sharing::default())
    }

    /// The same with another choice of the meshes that are stored once.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_sharing(
        scene: impl Into<Arc<Scene>>,
        camera: &CameraChoice,
        threads: Option<usize>,
        sharing: Sharing,
    ) -> Result<Self, RenderError> {
        let scene = scene.into();
        let camera = scene.camera(camera)?;
        let pool = ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build()?;
        let lift = lift(&scene);
        let start = Instant::now();
        let (animator, bvh, moving, shared_meshes) = pool.install(|| {
            let animator = Animator::with_sharing(scene, camera, sharing);
            let frame = animator.frame();
            let shared_meshes = shared_meshes(frame);
            let mut bvh = build_static(frame, &shared_meshes);
            bvh.place_instances(0, &placed(frame, &shared_meshes));
            if frame.static_count() < frame.triangles().len() {
                bvh.rebuild_after(frame.static_count(), frame.triangles());
            }
            let moving = frame.moving_objects();
            (animator, bvh, moving, shared_meshes)
        });
        let build_ms = start.elapsed().as_secs_f64() * 1e3;
        let light_buffers = LightBuffers::default();
        Ok(Self { animator, bvh, moving, shared_meshes, light_buffers, pool, build_ms, lift })
    }

    /// From the next [`Self::advance`] on, the scene is seen from this pose, and no longer from its camera,
    /// until another is given: for cameras that a user moves. Motion vectors point to the pose of the frame
    /// before; where it jumps, [`Pipeline::reset_history`](crate::Pipeline::reset_history) says so.
    pub fn look_from(&mut self, pose: CameraPose) {
        self.animator.look_from(pose);
    }

    /// Moves everything to a moment and fits the acceleration structure to what moves.
    pub fn advance(&mut self, moment: Moment) {
        let start = Instant::now();
        self.pool.install(|| {
            let count_before = self.animator.frame().triangles().len();
            let frame = self.animator.advance(moment.time_secs, moment.previous_secs);
            let static_count = frame.static_count();
            // Also where all that moves has gone, by being hidden or by dying.
            if static_count < frame.triangles().len().max(count_before) {
                let moving = frame.moving_objects();
                let successors = self.moving.successors(&moving);
                self.bvh.refit_after(static_count, frame.triangles(), &successors);
                self.moving = moving;
                self.light_buffers.clear();
            }
            let still_count = frame.static_counts().instances;
            if still_count < frame.instances().len() {
                self.bvh.place_instances(still_count, &placed(frame, &self.shared_meshes));
            }
        });
        self.build_ms = start.elapsed().as_secs_f64() * 1e3;
    }

    /// Milliseconds that the last [`Self::advance`] took: animation and acceleration structure.
    #[must_use]
    pub fn build_ms(&self) -> f64 {
        self.build_ms
    }

    /// Geometry, camera and lights at the moment.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        self.animator.frame()
    }

    /// The acceleration structure over [`Self::frame`].
    #[must_use]
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// What moves, for rays towards a light infinitely far away and a picture of so many pixels; none where
    /// it is to be found through the acceleration structure.
    pub(crate) fn light_buffer(&self, to_light: Vec3, pixels: usize) -> Option<Arc<LightBuffer>> {
        self.light_buffers.get(self.frame(), self.bvh.bounds(), to_light, pixels)
    }

    /// All triangles that the camera's ray through a point meets, by number, in ascending order. `point_px`:
    /// pixels from the upper left corner of a picture of `size` pixels.
    #[must_use]
    pub fn triangles_through(&self, point_px: Vec2, size: [u32; 2]) -> Vec<u32> {
        let CameraRay { origin, direction, nearest, furthest } =
            self.frame().camera().ray(point_px, UVec2::from(size).as_vec2());
        let ray = Ray { origin, direction, t_min: nearest, t_max: furthest };
        let mut triangles = Vec::new();
        self.bvh.traverse(&ray, |hit| {
            triangles.push(hit.triangle);
            f32::INFINITY
        });
        triangles.sort_unstable();
        triangles
    }

    /// Whether other triangles are met within `reach_px` of a pixel's centre: at the edges of triangles, seen
    /// or not, where another renderer's rounding may find other hits. The pixel is given by column and row.
    #[must_use]
    pub fn is_near_edge(&self, (x, y): (u32, u32), size: [u32; 2], reach_px: f32) -> bool {
        let centre_px = UVec2::new(x, y).as_vec2() + 0.5;
        let here = self.triangles_through(centre_px, size);
        let around = [
            [-1.0, -1.0],
            [0.0, -1.0],
            [1.0, -1.0],
            [-1.0, 0.0],
            [1.0, 0.0],
            [-1.0, 1.0],
            [0.0, 1.0],
            [1.0, 1.0],
        ];
        around
            .map(Vec2::from)
            .into_iter()
            .any(|offset| self.triangles_through(centre_px + offset * reach_px, size) != here)
    }

    /// How many threads render.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    pub(crate) fn pool(&self) -> &ThreadPool {
        &self.pool
    }

    pub(crate) fn lift(&self) -> f32 {
        self.lift
    }
}

/// The scene's meshes whose triangles instances of a frame share, ascending.
fn shared_meshes(frame: &Frame) -> Vec<u32> {
    let mut meshes: Vec<u32> = frame.instances().iter().map(MeshInstance::mesh).collect();
    meshes.sort_unstable();
    meshes.dedup();
    meshes
}

/// The acceleration structure over what never moves, with a tree for each of the meshes.
fn build_static(frame: &Frame, shared_meshes: &[u32]) -> Bvh {
    let triangles = &frame.triangles()[..frame.static_count()];
    if shared_meshes.is_empty() {
        return Bvh::build(triangles);
    }
    let tree = |&mesh: &u32| {
        let mesh = &frame.scene().parts().meshes[mesh as usize];
        let corners = |corners: &[u32; 3]| corners.map(|corner| mesh.positions[corner as usize]);
        MeshTree::build(&mesh.indices.iter().map(corners).collect::<Vec<_>>())
    };
    let trees = shared_meshes.par_iter().map(tree).collect();
    Bvh::build_with_meshes(triangles, trees, frame.instanced_triangles().len() as u32)
}

/// The instances of a frame, of which each finds its mesh among those that are shared.
fn placed(frame: &Frame, shared_meshes: &[u32]) -> Vec<Instance> {
    let placed = |instance: &MeshInstance| Instance {
        mesh: shared_meshes.partition_point(|&mesh| mesh < instance.mesh()),
        world_from_object: *instance.world_from_object(),
        first_triangle: instance.first_triangle(),
    };
    frame.instances().iter().map(placed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_of_the_callers_takes_the_place_of_the_camera() {
        let scene = Arc::new(sheer_gallery::open("smoke-square").unwrap().scene);
        let orbit = scene.camera(&CameraChoice::Orbit).unwrap();
        let mut by_camera = Stage::new(Arc::clone(&scene), &CameraChoice::Orbit, Some(1)).unwrap();
        let mut by_pose = Stage::new(Arc::clone(&scene), &CameraChoice::Default, Some(1)).unwrap();
        let seen_by = |stage: &Stage| (*stage.frame().camera(), *stage.frame().previous_camera());
        let moment = |frame: u8| Moment {
            time_secs: 0.1 * f32::from(frame),
            previous_secs: 0.1 * f32::from(frame.saturating_sub(1)),
        };
        for frame in 0..4 {
            by_camera.advance(moment(frame));
            by_pose.look_from(scene.pose(&orbit, moment(frame).time_secs));
            by_pose.advance(moment(frame));
            // Before the first pose the scene was seen from elsewhere.
            if frame > 0 {
                assert_eq!(seen_by(&by_pose), seen_by(&by_camera), "frame {frame}");
                assert_eq!(by_pose.frame().triangles(), by_camera.frame().triangles(), "frame {frame}");
            }
        }
        // Time may stand while the camera moves, and both may.
        let pose = scene.pose(&orbit, 5.0);
        by_pose.look_from(pose);
        for is_still in [false, true] {
            by_pose.advance(Moment { time_secs: 0.3, previous_secs: 0.3 });
            let (now, before) = seen_by(&by_pose);
            assert_eq!((now, before == pose, by_pose.frame().is_still()), (pose, is_still, is_still));
        }
    }

    #[test]
    fn a_stage_that_has_played_finds_what_a_new_one_does() {
        let scene = Arc::new(sheer_gallery::open("plume:particles=3000").unwrap().scene);
        let new = || Stage::new(Arc::clone(&scene), &CameraChoice::Default, Some(2)).unwrap();
        let (mut played, size) = (new(), [48, 27]);
        let mut counts = Vec::new();
        for frame in 0..8_u8 {
            let time_secs = 3.0 + 0.2 * f32::from(frame);
            let moment = Moment { time_secs, previous_secs: time_secs };
            let mut at_once = new();
            for stage in [&mut played, &mut at_once] {
                stage.advance(moment);
            }
            for pixel in 0..48 * 27 {
                let point_px = UVec2::new(pixel % 48, pixel / 48).as_vec2() + 0.5;
                let through = [&played, &at_once].map(|stage| stage.triangles_through(point_px, size));
                assert_eq!(through[0], through[1], "{point_px} at {time_secs} s");
            }
            counts.push(played.frame().triangles().len());
        }
        // Particles were born and died.
        counts.dedup();
        assert!(counts.len() > 4, "{counts:?}");
    }

    #[test]
    fn edges_are_where_triangles_end_and_nowhere_else() {
        let scene = sheer_gallery::open("pane").unwrap().scene;
        let stage = Stage::new(scene, &CameraChoice::Default, Some(1)).unwrap();
        let size = [64, 36];
        let pixels = (0..36).flat_map(|y| (0..64).map(move |x| (x, y)));
        let shares = [1.0 / 64.0, 0.5].map(|reach_px| {
            let near = pixels.clone().filter(|&pixel| stage.is_near_edge(pixel, size, reach_px)).count();
            near as f64 / (64.0 * 36.0)
        });
        assert!(shares[0] > 0.0 && shares[0] < shares[1] && shares[1] < 1.0, "{shares:?}");
        // What is no edge is none in between either.
        for (x, y) in pixels.filter(|&pixel| !stage.is_near_edge(pixel, size, 0.25)).step_by(50) {
            let centre = UVec2::new(x, y).as_vec2() + 0.5;
            let beside = stage.triangles_through(centre + Vec2::new(0.1, -0.05), size);
            assert_eq!(stage.triangles_through(centre, size), beside, "{x} {y}");
        }
    }
}
