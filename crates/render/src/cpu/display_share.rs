//! How much of what each pixel shows is display-referred ([`DisplayShare`]): unlit surfaces and a background
//! of one colour, against lit surfaces and the surroundings.
//!
//! It is found by visibility alone, for a picture and not for a frame: which surfaces are seen, and how much
//! of each, is the same for all methods, so none of them has to carry it, nor the histories that add frames
//! up. Nothing is shaded, and pixels that look like their neighbours take one ray, so that it costs less than
//! a frame; scenes that have light of one kind take none. Where a picture shows the past, as a history does
//! behind what moves, the share is that of the present.

use glam::Vec2;
use sheer_accel::{Hit, Ray};
use sheer_image::{DisplayShare, Image, ImageError, Region};
use sheer_scene::{CameraRay, PixelBeam, Scene, model::ShadingModel};

use crate::{
    contract::{MIN_ALPHA, MIN_VISIBILITY},
    error::RenderError,
    settings::{Background, Settings},
    stage::Stage,
    temporal::Antialiasing,
};

/// Rows and columns of samples in a pixel where several things meet.
const SAMPLES_A_SIDE: u32 = 4;
/// A pixel whose kinds of light differ by more than this from those of a neighbour takes all samples. Half a
/// level of 8 bits, as curves differ by less than 1 from no curve.
const LEAST_DIFFERENCE: f32 = 0.5 / 255.0;

/// The share of each pixel of a picture of a stage, or of the part of it that is rendered; through the
/// centres of its pixels without anti-aliasing.
///
/// # Errors
/// [`RenderError::Image`] if the size is zero or too much for the memory.
pub fn display_share(
    stage: &Stage,
    settings: &Settings,
    antialiasing: Antialiasing,
) -> Result<DisplayShare, RenderError> {
    if let Some(share) = uniform_display_share(stage.frame().scene(), settings.background) {
        return Ok(share);
    }
    let region = settings.region();
    // Pixels are held against their neighbours.
    let Region { left, top, width, height } = region.grown(1, settings.size);
    let probe = Probe::new(stage, settings);
    let shares: Result<_, ImageError> = stage.pool().install(|| {
        let centre = |x, y| probe.seen(left + x, top + y, Vec2::splat(0.5));
        let centres = Image::par_from_fn(width, height, centre)?;
        let [from_x, from_y] = [region.left - left, region.top - top];
        Image::par_from_fn(region.width, region.height, |x, y| {
            let (x, y) = (from_x + x, from_y + y);
            if antialiasing == Antialiasing::NONE || is_even(&centres, x, y) {
                return centres[(x, y)].share();
            }
            probe.seen_by_samples(left + x, top + y).share()
        })
    });
    Ok(DisplayShare::PerPixel(shares?))
}

/// The share of all pictures of a scene, where it has light of one kind alone.
#[must_use]
pub fn uniform_display_share(scene: &Scene, background: Background) -> Option<DisplayShare> {
    let materials = &scene.parts().materials;
    let unlit = materials.iter().filter(|material| material.model == ShadingModel::Unlit).count();
    let has_display_light = unlit > 0 || matches!(background, Background::Colour(_));
    let has_scene_light = unlit < materials.len() || background == Background::Environment;
    match (has_display_light, has_scene_light) {
        (false, _) => Some(DisplayShare::Nothing),
        (true, false) => Some(DisplayShare::Everything),
        (true, true) => None,
    }
}

/// What is seen of each kind of light, by visibility.
#[derive(Clone, Copy, Default)]
struct Seen {
    display: f32,
    scene: f32,
}

impl Seen {
    fn add(&mut self, is_display_referred: bool, visibility: f32) {
        *(if is_display_referred { &mut self.display } else { &mut self.scene }) += visibility;
    }

    fn share(self) -> f32 {
        let covered = self.display + self.scene;
        if covered > 0.0 { self.display / covered } else { 0.0 }
    }
}

/// Whether a pixel's neighbours see as much of each kind.
fn is_even(centres: &Image<Seen>, x: u32, y: u32) -> bool {
    let here = centres[(x, y)];
    let differs = |dx: i64, dy: i64| {
        let there = centres.get_clamped(i64::from(x) + dx, i64::from(y) + dy);
        (there.display - here.display).abs() > LEAST_DIFFERENCE
            || (there.scene - here.scene).abs() > LEAST_DIFFERENCE
    };
    !(-1..=1).any(|dy| (-1..=1).any(|dx| differs(dx, dy)))
}

/// Follows rays through a picture.
struct Probe<'a> {
    stage: &'a Stage,
    size: Vec2,
    beam: PixelBeam,
    background: Background,
}

impl<'a> Probe<'a> {
    fn new(stage: &'a Stage, settings: &Settings) -> Self {
        let [width, height] = settings.size.map(|side| side as f32);
        Self {
            stage,
            size: Vec2::new(width, height),
            beam: stage.frame().camera().pixel_beam(height),
            background: settings.background,
        }
    }

    /// The mean over a grid of samples.
    fn seen_by_samples(&self, x: u32, y: u32) -> Seen {
        let mut sum = Seen::default();
        let place = |at: u32| (at as f32 + 0.5) / SAMPLES_A_SIDE as f32;
        for row in 0..SAMPLES_A_SIDE {
            for column in 0..SAMPLES_A_SIDE {
                let seen = self.seen(x, y, Vec2::new(place(column), place(row)));
                sum.display += seen.display;
                sum.scene += seen.scene;
            }
        }
        sum
    }

    /// What the ray through a place in a pixel, `within` from its upper left corner, sees of each kind.
    fn seen(&self, x: u32, y: u32, within: Vec2) -> Seen {
        let frame = self.stage.frame();
        let CameraRay { origin, direction, nearest, furthest } =
            frame.camera().ray(Vec2::new(x as f32, y as f32) + within, self.size);
        let ray = Ray { origin, direction, t_min: nearest, t_max: furthest };

        // All that is visible up to the first opaque surface, front to back.
        let mut hits: Vec<(Hit, f32)> = Vec::new();
        let mut t_opaque = furthest;
        self.stage.bvh().traverse(&ray, |hit| {
            let width = self.beam.width_at(hit.t);
            let alpha = frame.opacity_for_camera(hit.triangle, hit.u, hit.v, hit.front, width);
            if alpha >= MIN_ALPHA {
                hits.push((hit, alpha));
            }
            if alpha >= 1.0 {
                t_opaque = t_opaque.min(hit.t);
            }
            t_opaque
        });
        hits.sort_unstable_by(|(a, _), (b, _)| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));

        let mut seen = Seen::default();
        let mut visibility = 1.0;
        for (hit, alpha) in hits {
            let material = frame.object(hit.triangle).material;
            let model = frame.scene().parts().materials[material as usize].model;
            seen.add(model == ShadingModel::Unlit, visibility * alpha);
            visibility *= 1.0 - alpha;
            if visibility <= MIN_VISIBILITY {
                return seen;
            }
        }
        match self.background {
            Background::Environment => seen.add(false, visibility),
            Background::Colour(_) => seen.add(true, visibility),
            Background::None => {}
        }
        seen
    }
}
