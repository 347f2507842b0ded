//! A scene at a time, on the device.
//!
//! The twin of the CPU's stage: the same animator moves the scene, and what has moved is sent. What never
//! moves comes first in every list of a frame, is sent once and has its own part of the acceleration
//! structure; all triangles are in world space, those of instances copied, so that hits agree to the bit with
//! the CPU's and a hundred thousand particles are no hundred thousand instances.
//!
//! Bind groups hold buffers, and a buffer that grows is another one: [`GpuStage::version`] tells pipelines
//! when to bind anew. It counts over all stages of the process, so that a pipeline that turns to another
//! stage notices that as well.

use std::{
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::Instant,
};

use glam::Vec3;
use rayon::{ThreadPool, ThreadPoolBuilder, prelude::*};
use sheer_image::DisplayShare;
use sheer_render::{
    Antialiasing, Moment, RenderError, Settings, Stage,
    cpu::{depth_range, display_share, uniform_display_share},
    lift,
};
use sheer_scene::{Animator, CameraChoice, CameraPose, Frame, Scene, Sharing};

use crate::{
    accel::Accel,
    device::{Gpu, Tracer},
    error::GpuError,
    scene::SceneBuffers,
    view::View,
};

/// How large a scene is at a moment, world units: bounds for depths and distances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// Ray origins are lifted off surfaces by this much, world units.
    pub(crate) lift: f32,
    /// Lowest and highest corner of what never moves.
    still: Option<[Vec3; 2]>,
    /// Lowest and highest corner of all triangles.
    bounds: Option<[Vec3; 2]>,
}

fn bounds_of(triangles: &[[Vec3; 3]]) -> Option<[Vec3; 2]> {
    let grown = |[low, high]: [Vec3; 2], triangle: &[Vec3; 3]| {
        triangle.iter().fold([low, high], |[low, high], corner| [low.min(*corner), high.max(*corner)])
    };
    let nothing = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    let [low, high] = triangles.par_iter().fold(|| nothing, grown).reduce(
        || nothing,
        |[low, high], [other_low, other_high]| [low.min(other_low), high.max(other_high)],
    );
    (low.x <= high.x).then_some([low, high])
}

impl Extent {
    fn new(frame: &Frame) -> Self {
        let lift = lift(frame.scene());
        let still = bounds_of(&frame.triangles()[..frame.static_count()]);
        let mut extent = Self { lift, still, bounds: None };
        extent.update(frame);
        extent
    }

    fn update(&mut self, frame: &Frame) {
        let moving = bounds_of(&frame.triangles()[frame.static_count()..]);
        self.bounds = match (self.still, moving) {
            (Some([low, high]), Some([other_low, other_high])) => {
                Some([low.min(other_low), high.max(other_high)])
            }
            (still, moving) => still.or(moving),
        };
    }

    /// The depths between which all surfaces lie, as the CPU has them.
    pub(crate) fn depth_range(&self, camera: &CameraPose) -> [f32; 2] {
        depth_range(self.bounds, camera)
    }

    /// A power of two that no distance from a ray's origin to a surface exceeds: dividing by it loses no bit.
    pub(crate) fn reach(&self, camera: &CameraPose) -> f32 {
        let Some([low, high]) = self.bounds else { return 1.0 };
        let furthest = (low - camera.eye()).abs().max((high - camera.eye()).abs()).length();
        // The rays of an orthographic camera start beside the eye.
        let furthest = 2.0 * (furthest + (high - low).length());
        furthest.max(f32::MIN_POSITIVE).log2().ceil().exp2()
    }
}

fn next_version() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// A scene, seen through one of its cameras, at a time: the frame's geometry on the device and the
/// acceleration structure over it. Several pipelines can render from one stage.
#[derive(Debug)]
pub struct GpuStage {
    gpu: Arc<Gpu>,
    animator: Animator,
    source: Arc<Scene>,
    camera: CameraChoice,
    /// A pose of the caller's, which takes the camera's place.
    own_pose: Option<CameraPose>,
    /// What the animator was last advanced to; none at time zero.
    moment: Option<Moment>,
    /// The scene on the processor, where it was needed there.
    twin: Mutex<Option<Stage>>,
    pool: ThreadPool,
    extent: Extent,
    scene: SceneBuffers,
    accel: Accel,
    build_ms: f64,
    /// The device that everything was made with.
    generation: u32,
    /// Another one for each set of buffers in the process, so that bind groups are made anew.
    version: u64,
}

impl GpuStage {
    /// Prepares a scene at time zero. `threads`: how many to use for animation, all the processor's by
    /// default.
    ///
    /// # Errors
    /// The scene has no such camera, is too large for the device, or the threads cannot be started.
    pub fn new(
        gpu: &Arc<Gpu>,
        scene: impl Into<Arc<Scene>>,
        camera: &CameraChoice,
        threads: Option<usize>,
    ) -> Result<Self, GpuError> {
        let scene = scene.into();
        let (source, choice) = (Arc::clone(&scene), camera.clone());
        let camera = scene.camera(camera)?;
        let pool = ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0));
        let pool = pool.build().map_err(RenderError::from)?;
        let start = Instant::now();
        let (animator, extent) = pool.install(|| {
            let animator = Animator::with_sharing(scene, camera, Sharing::FLATTENED);
            let extent = Extent::new(animator.frame());
            (animator, extent)
        });
        let generation = gpu.generation();
        let (scene, accel) = pool.install(|| upload(gpu, animator.frame()))?;
        gpu.expect_glass(animator.frame().tints_light());
        let build_ms = start.elapsed().as_secs_f64() * 1e3;
        Ok(Self {
            gpu: Arc::clone(gpu),
            animator,
            source,
            camera: choice,
            own_pose: None,
            moment: None,
            twin: Mutex::new(None),
            pool,
            extent,
            scene,
            accel,
            build_ms,
            generation,
            version: next_version(),
        })
    }

    /// From the next [`Self::advance`] on, the scene is seen from this pose, and no longer from its camera,
    /// until another is given: for cameras that a user moves. Motion vectors point to the pose of the frame
    /// before; where it jumps, [`GpuPipeline::reset_history`](crate::GpuPipeline::reset_history) says so.
    pub fn look_from(&mut self, pose: CameraPose) {
        self.own_pose = Some(pose);
        self.animator.look_from(pose);
    }

    /// The same by a camera's matrices, for a picture of so many columns and rows.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] says what is off with the projection.
    pub fn look_through(&mut self, view: &View, size: [u32; 2]) -> Result<(), GpuError> {
        self.look_from(view.pose(size)?);
        Ok(())
    }

    /// Moves everything to a moment, uploads what has moved and rebuilds the acceleration structure over it.
    ///
    /// # Errors
    /// What moves has grown beyond what the device holds, or the caller's device is lost. In the place of one
    /// that [`Gpu`] has opened, [`GpuPipeline::render`](crate::GpuPipeline::render) takes another.
    pub fn advance(&mut self, moment: Moment) -> Result<(), GpuError> {
        let start = Instant::now();
        self.moment = Some(moment);
        let Self { animator, pool, extent, .. } = self;
        let count_before = animator.frame().triangles().len();
        pool.install(|| {
            animator.advance(moment.time_secs, moment.previous_secs);
            extent.update(animator.frame());
        });
        let result = self.upload_moving(count_before);
        self.build_ms = start.elapsed().as_secs_f64() * 1e3;
        match result {
            // The pipeline that renders next makes everything anew.
            Err(GpuError::DeviceLost { .. }) if !self.gpu.is_foreign() => Ok(()),
            other => other,
        }
    }

    /// `count_before`: how many triangles there were.
    fn upload_moving(&mut self, count_before: usize) -> Result<(), GpuError> {
        let Self { gpu, animator, pool, scene, accel, .. } = self;
        let frame = animator.frame();
        let moves = frame.static_count() < frame.triangles().len().max(count_before);
        if !moves && frame.lights().is_empty() && !frame.animates_materials() {
            return Ok(());
        }
        let mut update = || {
            let mut replaced = scene.update(&gpu.device(), &gpu.queue(), frame)?;
            replaced |= accel.update(gpu, scene.positions(), frame)?;
            Ok(replaced)
        };
        // Error scopes are a thread's own.
        let replaced = pool.install(|| gpu.scoped("what moves", &mut update))?;
        if replaced {
            self.version = next_version();
        }
        self.gpu.settle()
    }

    /// Makes everything anew if the device has changed.
    pub(crate) fn renew(&mut self) -> Result<(), GpuError> {
        let generation = self.gpu.generation();
        if generation != self.generation {
            (self.scene, self.accel) = self.pool.install(|| upload(&self.gpu, self.animator.frame()))?;
            self.generation = generation;
            self.version = next_version();
        }
        Ok(())
    }

    /// Milliseconds that the last [`Self::advance`] took: animation, upload and acceleration structure.
    #[must_use]
    pub fn build_ms(&self) -> f64 {
        self.build_ms
    }

    /// Everything of the scene at the moment that it was advanced to, on the CPU's side.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        self.animator.frame()
    }

    /// How much of what each pixel of a picture shows is display-referred: by rays on the processor where the
    /// scene mixes both kinds of light, for which it is prepared there once.
    ///
    /// # Errors
    /// There is not enough memory, or the threads cannot be started.
    pub fn display_share(
        &self,
        settings: &Settings,
        antialiasing: Antialiasing,
    ) -> Result<DisplayShare, GpuError> {
        if let Some(share) = uniform_display_share(&self.source, settings.background) {
            return Ok(share);
        }
        // The lock guards no data that a panic could have left half-changed: a stage is advanced before it is
        // used.
        let mut twin = self.twin.lock().unwrap_or_else(PoisonError::into_inner);
        let stage = match &mut *twin {
            Some(stage) => stage,
            none => none.insert(Stage::new(Arc::clone(&self.source), &self.camera, Some(self.threads()))?),
        };
        if let Some(pose) = self.own_pose {
            stage.look_from(pose);
        }
        if let Some(moment) = self.moment {
            stage.advance(moment);
        }
        Ok(display_share(stage, settings, antialiasing)?)
    }

    /// How many threads animate the scene and build acceleration structures.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// The device that the scene lies on.
    #[must_use]
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// Bytes of all buffers and textures of the scene.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.scene.bytes() + self.accel.bytes()
    }

    pub(crate) fn extent(&self) -> &Extent {
        &self.extent
    }

    pub(crate) fn pool(&self) -> &ThreadPool {
        &self.pool
    }

    /// Tells [`Self::entries`] from those of earlier times and of other stages.
    pub(crate) fn version(&self) -> u64 {
        self.version
    }

    /// Layout of the bindings of [`Self::entries`].
    pub(crate) fn layout_entries(tracer: Tracer) -> Vec<wgpu::BindGroupLayoutEntry> {
        // Rays of light start in fragment shaders, too.
        let visibility = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let mut entries = SceneBuffers::layout_entries().to_vec();
        entries.extend(Accel::layout_entries(tracer, visibility));
        entries
    }

    /// The stage's part of group 0.
    pub(crate) fn entries(&self) -> Vec<wgpu::BindGroupEntry<'_>> {
        let mut entries = self.scene.entries().to_vec();
        entries.extend(self.accel.entries());
        entries
    }
}

fn upload(gpu: &Gpu, frame: &Frame) -> Result<(SceneBuffers, Accel), GpuError> {
    gpu.scoped("the scene", || {
        let scene = SceneBuffers::new(&gpu.device(), &gpu.queue(), frame)?;
        let accel = Accel::new(gpu, scene.positions(), frame)?;
        gpu.settle()?;
        Ok((scene, accel))
    })
}
