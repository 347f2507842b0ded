//! The CPU backend: the default and the gold standard. Deterministic: the same bits for any number of threads.

use std::{iter, time::Instant};

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use sheer_accel::{Hit, Ray};
use sheer_core::{colour::Premul, coverage::Correction};
use sheer_image::{Image, Pixel, Planes};
use sheer_scene::{CameraPose, CameraRay, FaceSide};

use self::composite::{Nanoseconds, Workspace};
use crate::{
    contract::{Compositing, Gathering, Hybrid, MIN_ALPHA, Selection, Tables, Threshold, Visitor},
    method::Method,
    pipeline::RenderError,
    shadow::{Shadow, Shadows},
    stage::Stage,
};

mod composite;
mod gather;
mod layer_filter;
mod object_space;
mod samples;
pub mod shade;

/// What lies behind everything (`--background`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Background {
    /// The scene's environment.
    #[default]
    Environment,
    /// A constant linear colour.
    Colour(Vec3),
    /// Nothing: the picture is transparent there.
    None,
}

/// What one frame is rendered with.
#[derive(Clone, Copy, Debug)]
pub struct FrameSettings {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Frame index for the dithering.
    pub frame: u32,
    /// Seed of the run.
    pub seed: u32,
    /// Offset of the sample from the pixel centre, pixels.
    pub jitter: Vec2,
    /// What lies behind everything.
    pub background: Background,
    /// How light is shadowed.
    pub shadow: Shadow,
}

/// What a frame cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Camera rays, continuation rays among them.
    pub camera_rays: u64,
    /// Deep shadow rays, and rays that make shadow maps.
    pub shadow_rays: u64,
    /// Hits of camera rays that were tested or composited.
    pub hits: u64,
    /// Fragments shaded.
    pub shaded: u64,
    /// Fragments that bounded memory had no place for, so that they were merged with others; of a hybrid, pixels whose exact fragments
    /// ran out before the visibility had fallen, so that one draw stands for more than it should.
    pub merged: u64,
}

impl std::ops::Add for Counters {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            camera_rays: self.camera_rays + other.camera_rays,
            shadow_rays: self.shadow_rays + other.shadow_rays,
            hits: self.hits + other.hits,
            shaded: self.shaded + other.shaded,
            merged: self.merged + other.merged,
        }
    }
}

/// A step of a compositing method and how long all threads together were at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepTime {
    /// `gather`, one of the method's passes, `composite`, or `filter`.
    pub name: &'static str,
    /// Milliseconds, summed over threads; of `filter`, as the clock has them.
    pub ms: f64,
}

/// A frame and its cost.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The picture, one jittered sample a pixel.
    pub planes: Planes,
    /// What was traced and shaded.
    pub counters: Counters,
    /// Milliseconds from the first ray to the last pixel; building the acceleration structure comes on top.
    pub trace_ms: f64,
    /// Milliseconds of these that went into shadow maps.
    pub shadow_ms: f64,
    /// The steps of methods with an unordered gathering; empty for all others.
    pub steps: Vec<StepTime>,
}

/// Renders one frame of a stage.
///
/// # Errors
/// [`RenderError::Image`] if the size is zero or too much for the memory.
pub fn render(stage: &Stage, method: &Method, settings: &FrameSettings) -> Result<Rendered, RenderError> {
    method.visit(Draw { stage, settings, hybrid: method.hybrid(), correction: method.correction() })
}

/// Renders one frame with a compositing method of the caller's own.
///
/// # Errors
/// As [`render`].
pub fn render_compositing(
    stage: &Stage,
    method: &impl Compositing,
    settings: &FrameSettings,
) -> Result<Rendered, RenderError> {
    Draw { stage, settings, hybrid: Hybrid::NONE, correction: Correction::NONE }.compositing(method)
}

/// Rows a task: few enough that 2 to 64 threads share a frame evenly, enough that neighbouring rays share the cache.
const BAND_ROWS: u32 = 8;

struct Draw<'a> {
    stage: &'a Stage,
    settings: &'a FrameSettings,
    hybrid: Hybrid,
    correction: Correction,
}

impl Visitor for Draw<'_> {
    type Output = Result<Rendered, RenderError>;

    fn threshold(self, method: &impl Threshold) -> Self::Output {
        let (tables, hybrid) = (Tables::get(), self.hybrid);
        self.bands(|tracer, at, counters| {
            tracer.stochastic(hybrid, at, counters, |tracer, ray, after, counters| {
                tracer.first_kept(method, &tables, at, ray, after, counters)
            })
        })
    }

    fn selection(self, method: &impl Selection) -> Self::Output {
        let (tables, hybrid) = (Tables::get(), self.hybrid);
        let FrameSettings { frame, seed, .. } = *self.settings;
        self.bands(|tracer, at, counters| {
            let threshold = method.threshold(at, frame, seed, &tables);
            tracer.stochastic(hybrid, at, counters, |tracer, ray, after, counters| {
                tracer.first_exceeding(threshold, ray, after, counters)
            })
        })
    }

    fn compositing(self, method: &impl Compositing) -> Self::Output {
        let offsets = samples::offsets(method.samples(), self.settings.jitter);
        let pass_names = (0..method.pass_count()).map(|pass| method.pass_name(pass));
        let filter = method.layer_filter();
        let (stage, [width, height]) = (self.stage, self.settings.size);
        let (mut rendered, byproducts) = self.timed_bands(|tracer, at, counters| {
            tracer.composite(method, &offsets, filter.is_some(), at, counters)
        })?;
        if matches!(method.gathering(), Gathering::Unordered { .. }) {
            let names = iter::once("gather").chain(pass_names).chain(["composite"]);
            let Nanoseconds { gather, passes, composite } = byproducts.nanoseconds;
            let times = iter::once(gather).chain(passes).chain([composite]);
            rendered.steps =
                names.zip(times).map(|(name, ns)| StepTime { name, ms: ns as f64 * 1e-6 }).collect();
        }
        if let Some(filter) = filter {
            let start = Instant::now();
            let mut layer = Image::filled(width, height, Premul::CLEAR)?;
            for ([x, y], light) in byproducts.layer {
                layer[(x, y)] = light;
            }
            stage.pool().install(|| layer_filter::apply(&filter, &layer, &mut rendered.planes.colour));
            let ms = start.elapsed().as_secs_f64() * 1e3;
            rendered.trace_ms += ms;
            rendered.steps.push(StepTime { name: "filter", ms });
        }
        Ok(rendered)
    }
}

impl Draw<'_> {
    /// Calls `trace` for every pixel, in parallel.
    fn bands(
        self,
        trace: impl Fn(&mut Tracer<'_>, [u32; 2], &mut Counters) -> Pixel + Sync,
    ) -> Result<Rendered, RenderError> {
        Ok(self.timed_bands(trace)?.0)
    }

    /// The same, with the time of each step and what else the pixels leave behind.
    fn timed_bands(
        self,
        trace: impl Fn(&mut Tracer<'_>, [u32; 2], &mut Counters) -> Pixel + Sync,
    ) -> Result<(Rendered, Byproducts), RenderError> {
        let [width, height] = self.settings.size;
        let mut planes = Planes::new(width, height)?;
        let start = Instant::now();
        let FrameSettings { frame, seed, shadow, .. } = self.settings;
        let shadows = Shadows::new(self.stage, shadow, *frame, *seed)?;
        let (counters, byproducts) = self.stage.pool().install(|| {
            let bands = planes.par_bands_mut(BAND_ROWS);
            let costs = bands.map(|mut band| {
                let mut tracer = Tracer::new(self.stage, self.settings, &shadows, self.correction);
                let mut counters = Counters::default();
                // Squares, not rows: their rays stay together.
                for left in (0..width).step_by(BAND_ROWS as usize) {
                    for row in 0..band.height() {
                        for x in left..(left + BAND_ROWS).min(width) {
                            tracer.pixel_at = [x, band.y + row];
                            let pixel = trace(&mut tracer, [x, band.y + row], &mut counters);
                            band.set(x, row, pixel);
                        }
                    }
                }
                (counters, tracer.byproducts)
            });
            costs.reduce(Default::default, |(counters, costs), (more, further)| {
                (counters + more, costs.plus(further))
            })
        });
        let counters = counters + Counters { shadow_rays: shadows.rays(), ..Counters::default() };
        let trace_ms = start.elapsed().as_secs_f64() * 1e3;
        let rendered =
            Rendered { planes, counters, trace_ms, shadow_ms: shadows.build_ms(), steps: Vec::new() };
        Ok((rendered, byproducts))
    }
}

/// What pixels leave behind beside themselves.
#[derive(Debug, Default)]
struct Byproducts {
    nanoseconds: Nanoseconds,
    /// Light and total alpha of the fragments of pixels, for a filter.
    layer: Vec<([u32; 2], Premul)>,
}

impl Byproducts {
    /// The sum of both.
    fn plus(mut self, mut other: Self) -> Self {
        self.layer.append(&mut other.layer);
        Self { nanoseconds: self.nanoseconds.plus(&other.nanoseconds), layer: self.layer }
    }
}

/// Traces pixels of a frame. One a task; holds what a pixel needs for the time being.
struct Tracer<'a> {
    stage: &'a Stage,
    settings: &'a FrameSettings,
    shadows: &'a Shadows,
    /// Column and row of the pixel that is being traced.
    pixel_at: [u32; 2],
    /// Of what is held against a threshold.
    correction: Correction,
    /// See [`crate::contract::PixelSite::depth_range`].
    depth_range: [f32; 2],
    workspace: Workspace,
    byproducts: Byproducts,
    layers: Vec<Layer>,
}

/// A fragment among those nearest to the eye.
#[derive(Clone, Copy, Debug)]
struct Layer {
    hit: Hit,
    alpha: f32,
    /// What is seen through it and everything in front of it.
    visibility: f32,
}

impl<'a> Tracer<'a> {
    fn new(
        stage: &'a Stage,
        settings: &'a FrameSettings,
        shadows: &'a Shadows,
        correction: Correction,
    ) -> Self {
        Self {
            stage,
            settings,
            shadows,
            pixel_at: [0; 2],
            correction,
            depth_range: depth_range(stage.bvh().bounds(), stage.frame().camera()),
            workspace: Workspace::default(),
            byproducts: Byproducts::default(),
            layers: Vec::new(),
        }
    }

    fn size(&self) -> Vec2 {
        let [width, height] = self.settings.size;
        Vec2::new(width as f32, height as f32)
    }

    /// The centre of a pixel, in pixels.
    fn centre(&self, [x, y]: [u32; 2]) -> Vec2 {
        Vec2::new(x as f32 + 0.5, y as f32 + 0.5)
    }

    /// Where the one sample of a pixel lies, in pixels.
    fn sample(&self, at: [u32; 2]) -> Vec2 {
        self.centre(at) + self.settings.jitter
    }

    fn camera_ray(&self, sample: Vec2) -> CameraRay {
        self.stage.frame().camera().ray(sample, self.size())
    }

    /// What a camera ray that meets nothing sees.
    fn background(&self, ray: &CameraRay) -> Premul {
        let scene = self.stage.frame().scene().parts();
        match self.settings.background {
            Background::Environment => {
                let rgb = scene.environment.radiance(ray.direction, 0.0) * scene.exposure;
                Premul { rgb, alpha: 1.0 }
            }
            Background::Colour(rgb) => Premul { rgb, alpha: 1.0 },
            Background::None => Premul::CLEAR,
        }
    }

    /// A pixel that shows `colour` and has the depth, motion and ids of a hit, or of the far distance without one.
    fn pixel(
        &self,
        colour: Premul,
        sample: Vec2,
        ray: &CameraRay,
        hit: Option<&Hit>,
        transparent: bool,
    ) -> Pixel {
        let frame = self.stage.frame();
        let Some(hit) = hit else {
            let before = frame.previous_camera().project_direction(ray.direction, self.size());
            let motion = before.map_or(Vec2::ZERO, |before| before - sample).to_array();
            return Pixel { colour: colour.to_array(), motion, transparent, ..Pixel::EMPTY };
        };
        let [position, previous_position] = frame.positions(hit.triangle, hit.u, hit.v);
        // From projected to projected, not from the sample: so a still surface has a motion of exactly zero.
        let now = frame.camera().project(position, self.size());
        let before = frame.previous_camera().project(previous_position, self.size());
        let motion = now.zip(before).map_or(Vec2::ZERO, |(now, before)| before - now).to_array();
        Pixel {
            colour: colour.to_array(),
            depth: frame.camera().view_depth(position),
            motion,
            instance: frame.object(hit.triangle).id,
            primitive: frame.primitive(hit.triangle),
            transparent,
        }
    }

    fn ray(&self, ray: &CameraRay) -> Ray {
        Ray { origin: ray.origin, direction: ray.direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The ray from a hit on, inclusively: there may be a second one at its depth.
    fn ray_from(&self, ray: &CameraRay, after: Option<Hit>) -> Ray {
        let ray = self.ray(ray);
        Ray { t_min: after.map_or(ray.t_min, |hit| hit.t), ..ray }
    }

    /// Whether the side of the surface is seen that its vertices go around clockwise.
    fn is_back(&self, hit: &Hit) -> bool {
        self.stage.frame().side(hit.triangle, hit.front) == FaceSide::Back
    }

    /// Opacity of a hit for the camera; 0 where it is less than anyone would see.
    fn alpha(&self, hit: &Hit) -> f32 {
        let alpha = self.stage.frame().opacity_for_camera(hit.triangle, hit.u, hit.v, hit.front);
        if alpha >= MIN_ALPHA { alpha } else { 0.0 }
    }
}

/// A camera inside the scene sees things as near as you like; depths are told apart from this share of the furthest one on.
const NEAREST_SHARE: f32 = 1e-3;

/// The depths between which all surfaces lie, along the view axis, from the lowest and highest corner of all triangles; both above 0.
#[must_use]
pub fn depth_range(bounds: Option<[Vec3; 2]>, camera: &CameraPose) -> [f32; 2] {
    let Some([low, high]) = bounds else { return [1.0, 2.0] };
    let corner = |index: u32| {
        let bit = |axis: u32| index >> axis & 1 != 0;
        camera.view_depth(Vec3::select(glam::BVec3::new(bit(0), bit(1), bit(2)), high, low))
    };
    let (near, far) = (0..8)
        .map(corner)
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(near, far), depth| (near.min(depth), far.max(depth)));
    let far = far.max(f32::MIN_POSITIVE / NEAREST_SHARE);
    [near.max(NEAREST_SHARE * far), far]
}
