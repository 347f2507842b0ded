//! The CPU backend: the default and the gold standard. Deterministic: the same bits for any number of threads.

use std::time::Instant;

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use sheer_accel::{Hit, Ray};
use sheer_core::{colour::Premul, coverage::Correction};
use sheer_image::{Pixel, Planes};
use sheer_scene::CameraRay;

use crate::{
    contract::{Compositing, Hybrid, MIN_ALPHA, Selection, Tables, Threshold, Visitor},
    method::Method,
    pipeline::RenderError,
    stage::Stage,
};

mod gather;
mod object_space;
mod shade;

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
}

/// What a frame cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Camera rays, continuation rays among them.
    pub camera_rays: u64,
    /// Deep shadow rays.
    pub shadow_rays: u64,
    /// Hits of camera rays that were tested or composited.
    pub hits: u64,
    /// Fragments shaded.
    pub shaded: u64,
}

impl std::ops::Add for Counters {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            camera_rays: self.camera_rays + other.camera_rays,
            shadow_rays: self.shadow_rays + other.shadow_rays,
            hits: self.hits + other.hits,
            shaded: self.shaded + other.shaded,
        }
    }
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
        self.bands(|tracer, at, counters| tracer.composite(method, at, counters))
    }
}

impl Draw<'_> {
    /// Calls `trace` for every pixel, in parallel.
    fn bands(
        self,
        trace: impl Fn(&mut Tracer<'_>, [u32; 2], &mut Counters) -> Pixel + Sync,
    ) -> Result<Rendered, RenderError> {
        let [width, height] = self.settings.size;
        let mut planes = Planes::new(width, height)?;
        let start = Instant::now();
        let counters = self.stage.pool().install(|| {
            let bands = planes.par_bands_mut(BAND_ROWS);
            let costs = bands.map(|mut band| {
                let mut tracer = Tracer::new(self.stage, self.settings, self.correction);
                let mut counters = Counters::default();
                // Squares, not rows: their rays stay together.
                for left in (0..width).step_by(BAND_ROWS as usize) {
                    for row in 0..band.height() {
                        for x in left..(left + BAND_ROWS).min(width) {
                            let pixel = trace(&mut tracer, [x, band.y + row], &mut counters);
                            band.set(x, row, pixel);
                        }
                    }
                }
                counters
            });
            costs.reduce(Counters::default, |a, b| a + b)
        });
        Ok(Rendered { planes, counters, trace_ms: start.elapsed().as_secs_f64() * 1e3 })
    }
}

/// Traces pixels of a frame. One a task; holds what a pixel needs for the time being.
struct Tracer<'a> {
    stage: &'a Stage,
    settings: &'a FrameSettings,
    /// Of what is held against a threshold.
    correction: Correction,
    hits: Vec<(Hit, f32)>,
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
    fn new(stage: &'a Stage, settings: &'a FrameSettings, correction: Correction) -> Self {
        Self { stage, settings, correction, hits: Vec::new(), layers: Vec::new() }
    }

    fn size(&self) -> Vec2 {
        let [width, height] = self.settings.size;
        Vec2::new(width as f32, height as f32)
    }

    /// Where the sample of a pixel lies, in pixels.
    fn sample(&self, [x, y]: [u32; 2]) -> Vec2 {
        Vec2::new(x as f32 + 0.5, y as f32 + 0.5) + self.settings.jitter
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

    /// Opacity of a hit for the camera; 0 where it is less than anyone would see.
    fn alpha(&self, hit: &Hit) -> f32 {
        let alpha = self.stage.frame().opacity_for_camera(hit.triangle, hit.u, hit.v, hit.front);
        if alpha >= MIN_ALPHA { alpha } else { 0.0 }
    }
}
