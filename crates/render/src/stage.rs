//! A scene at a time, ready to be traced.

use std::{sync::Arc, time::Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};
use sheer_accel::Bvh;
use sheer_scene::{Animator, CameraChoice, Frame, Scene};

use crate::pipeline::{Moment, RenderError};

/// A scene, seen through one of its cameras, at a time: the frame's geometry and the acceleration structure over it. Several pipelines
/// can render from one stage.
#[derive(Debug)]
pub struct Stage {
    animator: Animator,
    bvh: Bvh,
    pool: ThreadPool,
    build_ms: f64,
    /// Ray origins are lifted off surfaces by this much, so that rounding does not shadow a surface by itself: world units.
    lift: f32,
}

/// Share of the scene's radius by which shadow rays are lifted off their surface. At a few times the rounding error of a hit point.
pub const LIFT: f32 = 1e-5;

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
        let scene = scene.into();
        let camera = scene.camera(camera)?;
        let pool = ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build()?;
        let lift = LIFT * scene.bounding_sphere().1;
        let start = Instant::now();
        let (animator, bvh) = pool.install(|| {
            let animator = Animator::new(scene, camera);
            let frame = animator.frame();
            let mut bvh = Bvh::build(&frame.triangles()[..frame.static_count()]);
            if frame.static_count() < frame.triangles().len() {
                bvh.rebuild_after(frame.static_count(), frame.triangles());
            }
            (animator, bvh)
        });
        Ok(Self { animator, bvh, pool, build_ms: start.elapsed().as_secs_f64() * 1e3, lift })
    }

    /// Moves everything to a moment and rebuilds the acceleration structure over what moves.
    pub fn advance(&mut self, moment: Moment) {
        let start = Instant::now();
        self.pool.install(|| {
            let frame = self.animator.advance(moment.time_secs, moment.previous_secs);
            let static_count = frame.static_count();
            if static_count < frame.triangles().len() {
                self.bvh.rebuild_after(static_count, frame.triangles());
            }
        });
        self.build_ms = start.elapsed().as_secs_f64() * 1e3;
    }

    /// Milliseconds that the last [`Self::advance`] took: animation and acceleration structure.
    #[must_use]
    pub fn build_ms(&self) -> f64 {
        self.build_ms
    }

    /// The geometry.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        self.animator.frame()
    }

    /// The acceleration structure over [`Self::frame`].
    #[must_use]
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
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
