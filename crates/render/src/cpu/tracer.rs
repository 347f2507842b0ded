//! What all families do alike for a pixel: rays through it, opacity of what they hit, the pixel that is
//! written.

use glam::{Vec2, Vec3};
use sheer_accel::{Hit, Ray};
use sheer_core::{colour::Premul, coverage::Correction};
use sheer_image::{Pixel, PixelLayers};
use sheer_scene::{CameraPose, CameraRay, FaceSide, PixelBeam};

use super::workspace::{Byproducts, NearLayers, Workspace};
use crate::{
    contract::{Fragment, MIN_ALPHA, PixelSite},
    settings::{Background, FrameSettings},
    shadow::Shadows,
    stage::Stage,
};

/// Traces pixels of a frame. One a task; holds what a tile needs for the time being.
pub(super) struct Tracer<'a> {
    pub(super) stage: &'a Stage,
    pub(super) settings: &'a FrameSettings,
    pub(super) shadows: &'a Shadows,
    /// Column and row of the pixel that is being shaded.
    pub(super) pixel_at: [u32; 2],
    /// The curve from opacity to the coverage that is held against a threshold.
    pub(super) correction: Correction,
    /// See [`crate::contract::PixelSite::depth_range`].
    pub(super) depth_range: [f32; 2],
    /// What a pixel sees of a surface.
    pub(super) beam: PixelBeam,
    /// Whether anything in the scene tints what shines through it.
    pub(super) has_glass: bool,
    pub(super) workspace: Workspace,
    pub(super) byproducts: Byproducts,
    /// One a ray of a tile; memory that is kept.
    pub(super) near_layers: Vec<NearLayers>,
}

impl<'a> Tracer<'a> {
    pub(super) fn new(
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
            beam: stage.frame().camera().pixel_beam(settings.run.size[1] as f32),
            has_glass: stage.frame().tints_light(),
            workspace: Workspace::default(),
            byproducts: Byproducts::default(),
            near_layers: Vec::new(),
        }
    }

    pub(super) fn size(&self) -> Vec2 {
        let [width, height] = self.settings.run.size;
        Vec2::new(width as f32, height as f32)
    }

    /// The centre of a pixel, in pixels.
    pub(super) fn centre(&self, [x, y]: [u32; 2]) -> Vec2 {
        Vec2::new(x as f32 + 0.5, y as f32 + 0.5)
    }

    /// Where the one sample of a pixel lies, in pixels.
    pub(super) fn sample(&self, at: [u32; 2]) -> Vec2 {
        self.centre(at) + self.settings.jitter
    }

    pub(super) fn camera_ray(&self, sample: Vec2) -> CameraRay {
        self.stage.frame().camera().ray(sample, self.size())
    }

    /// What a camera ray that meets nothing sees, glass left out.
    pub(super) fn background(&self, ray: &CameraRay) -> Premul {
        let scene = self.stage.frame().scene().parts();
        match self.settings.run.background {
            Background::Environment => {
                let rgb = scene.environment.radiance(ray.direction, 0.0) * scene.exposure;
                Premul { rgb, alpha: 1.0 }
            }
            Background::Colour(rgb) => Premul { rgb, alpha: 1.0 },
            Background::None => Premul::CLEAR,
        }
    }

    /// A pixel that shows `colour` and has the depth, motion and ids of a hit, or of the far distance without
    /// one.
    pub(super) fn pixel(
        &self,
        colour: Premul,
        sample: Vec2,
        ray: &CameraRay,
        hit: Option<&Hit>,
        transparent: bool,
    ) -> Pixel {
        let frame = self.stage.frame();
        let Some(hit) = hit else {
            let motion = self.motion_at_infinity(sample, ray);
            let layers = PixelLayers { back_motion: motion, ..PixelLayers::EMPTY };
            return Pixel { colour: colour.to_array(), motion, transparent, layers, ..Pixel::EMPTY };
        };
        let (motion, depth) = self.motion_and_depth(hit);
        Pixel {
            colour: colour.to_array(),
            depth,
            motion,
            instance: frame.object(hit.triangle).id,
            primitive: frame.primitive(hit.triangle),
            transparent,
            // All of it is one layer, unless a method knows better.
            layers: PixelLayers { back_motion: motion, back_depth: depth, ..PixelLayers::EMPTY },
        }
    }

    /// Motion of a hit in pixels, and its depth.
    pub(super) fn motion_and_depth(&self, hit: &Hit) -> ([f32; 2], f32) {
        let [position, previous] = self.stage.frame().positions(hit.triangle, hit.u, hit.v);
        self.motion_and_depth_of(position, previous)
    }

    /// The same of a point that was elsewhere in the frame before.
    pub(super) fn motion_and_depth_of(&self, position: Vec3, previous: Vec3) -> ([f32; 2], f32) {
        let frame = self.stage.frame();
        // From projected to projected, not from the sample: so a still surface has a motion of exactly zero.
        let now = frame.camera().project(position, self.size());
        let before = frame.previous_camera().project(previous, self.size());
        let motion = now.zip(before).map_or(Vec2::ZERO, |(now, before)| before - now);
        (motion.to_array(), frame.camera().view_depth(position))
    }

    /// Motion in pixels of what is infinitely far away, which the camera's turning alone moves.
    pub(super) fn motion_at_infinity(&self, sample: Vec2, ray: &CameraRay) -> [f32; 2] {
        let before = self.stage.frame().previous_camera().project_direction(ray.direction, self.size());
        before.map_or(Vec2::ZERO, |before| before - sample).to_array()
    }

    pub(super) fn ray(&self, ray: &CameraRay) -> Ray {
        let &CameraRay { origin, direction, nearest, furthest } = ray;
        Ray { origin, direction, t_min: nearest, t_max: furthest }
    }

    /// Whether the side of the surface is seen that its vertices go around clockwise.
    pub(super) fn is_back(&self, hit: &Hit) -> bool {
        self.stage.frame().side(hit.triangle, hit.front) == FaceSide::Back
    }

    /// Opacity of a hit for the camera, of coloured glass to the channel that passes best; 0 where it is less
    /// than anyone would see.
    pub(super) fn alpha(&self, hit: &Hit) -> f32 {
        if let Some(glass) = self.glass(hit) {
            return glass.alpha;
        }
        let alpha = self.stage.frame().opacity_for_camera(
            hit.triangle,
            hit.u,
            hit.v,
            hit.front,
            self.beam.width_at(hit.t),
        );
        if alpha >= MIN_ALPHA { alpha } else { 0.0 }
    }

    /// What a compositing method may know of a pixel before its first fragment.
    pub(super) fn pixel_site(&self, at: [u32; 2]) -> PixelSite {
        let (frame, seed) = (self.settings.frame, self.settings.run.seed);
        PixelSite { pixel: at, frame, seed, depth_range: self.depth_range }
    }

    /// A hit as a fragment of `alpha` that covers the samples of a mask; `depths`: one a sample ray.
    pub(super) fn fragment<'d>(
        &self,
        hit: &Hit,
        alpha: f32,
        coverage: u64,
        depths: &'d [f32],
    ) -> Fragment<'d> {
        let object = self.stage.frame().object(hit.triangle);
        Fragment {
            alpha,
            coverage,
            depths,
            order: hit.triangle,
            instance: object.id,
            geometry: object.geometry,
            primitive: hit.triangle - object.first_triangle,
            is_back: self.is_back(hit),
        }
    }

    /// Distance along the view axis: never falls as `t` grows, rounding included.
    pub(super) fn depth(&self, ray: &CameraRay, hit: &Hit) -> f32 {
        let camera = self.stage.frame().camera();
        let cosine = ray.direction.dot(camera.forward());
        camera.view_depth(ray.origin) + hit.t * cosine
    }
}

/// A camera inside the scene sees things as near as you like; depths are distinguished from this share of the
/// furthest one on.
const NEAREST_SHARE: f32 = 1e-3;

/// The depths between which all surfaces lie, along the view axis, from the lowest and highest corner of all
/// triangles; both above 0.
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
