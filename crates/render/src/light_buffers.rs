//! Light buffers over what moves in a frame, for rays to lights that are infinitely far away.
//!
//! What moves in most scenes is smoke, of which such rays meet tens of layers. What stays is found through
//! the tree as ever: it is mostly opaque, and a buffer over all of a town would take longer than its shadows.
//! The hits are the same either way, so that a choice is one of time alone. A buffer is made
//!
//! * for what moves, where nothing is drawn as instances,
//! * if the picture has [`PIXELS_PER_TRIANGLE`] for each triangle that moves: every pixel that shows a lit
//!   surface casts a ray to each light, and some methods tens of them,
//! * and if its lists, kept as short as memory allows, find room in [`sheer_scene::light_buffer_bytes`],
//!   which is counted among what a scene takes: some 300,000 triangles with a single sun.
//!
//! It is kept until something moves.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glam::Vec3;
use sheer_accel::LightBuffer;
use sheer_scene::{Frame, light_buffer_bytes, model::LightKind};

/// A triangle takes 3.4 µs to be put into lists, which save a pixel with a single fragment 1 µs at least,
/// measured on a square under smoke: so many pixels a triangle pay twice for what they take.
const PIXELS_PER_TRIANGLE: usize = 8;
/// Bytes for each triangle below which lists would be about as long as the smoke has triangles in all.
const LEAST_BYTES_PER_TRIANGLE: usize = 200;
/// Rays may begin so far outside of what is drawn, as a share of its extent and of its largest coordinate:
/// further than they are lifted off surfaces.
const REACH: [f32; 2] = [1e-3, 1e-5];

/// The light buffers of a stage that have been made, with the directions towards their lights.
#[derive(Debug, Default)]
pub(crate) struct LightBuffers(Mutex<Vec<(Vec3, Arc<LightBuffer>)>>);

impl LightBuffers {
    /// The buffer over what moves in a frame, for rays towards a light, made now if it is not there; none
    /// where it would not pay in a picture of so many pixels. `bounds`: the corners of all that is drawn.
    pub(crate) fn get(
        &self,
        frame: &Frame,
        bounds: Option<[Vec3; 2]>,
        to_light: Vec3,
        pixels: usize,
    ) -> Option<Arc<LightBuffer>> {
        let first = frame.static_count();
        let triangles = &frame.triangles()[first..];
        let suns = frame.lights().iter().filter(|light| light.kind == LightKind::Directional).count();
        let budget = usize::try_from(light_buffer_bytes(triangles.len() as u64)).unwrap_or(usize::MAX);
        let most_bytes = budget / suns.max(1);
        let is_worthwhile = triangles.len() <= pixels / PIXELS_PER_TRIANGLE
            && triangles.len() <= most_bytes / LEAST_BYTES_PER_TRIANGLE;
        if triangles.is_empty() || !is_worthwhile || !frame.instances().is_empty() {
            return None;
        }
        let known = self.made().iter().find(|made| made.0 == to_light).map(|made| Arc::clone(&made.1));
        if known.is_some() {
            return known;
        }
        // Made without the lock: a thread that waits for others may be given work that asks for it, too.
        let [lower, upper] = bounds?;
        let furthest = lower.abs().max(upper.abs()).max_element();
        let reach = REACH[0] * (upper - lower).max_element() + REACH[1] * furthest;
        let region = [lower - reach, upper + reach];
        let is_opaque = |number: u32| frame.is_opaque(number);
        let buffer = LightBuffer::build(triangles, first as u32, is_opaque, to_light, region, most_bytes)?;
        let buffer = Arc::new(buffer);
        self.made().push((to_light, Arc::clone(&buffer)));
        Some(buffer)
    }

    /// Forgets all, as something has moved.
    pub(crate) fn clear(&mut self) {
        self.0.get_mut().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// The list is never half done, whatever has happened to a thread that held it.
    fn made(&self) -> MutexGuard<'_, Vec<(Vec3, Arc<LightBuffer>)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;
    use sheer_accel::Ray;
    use sheer_scene::CameraChoice;

    use super::*;
    use crate::{
        shadow::{Shadow, Shadows, toward},
        stage::{Moment, Stage},
    };

    const PIXELS: usize = 1 << 18;

    /// A plume of smoke under the sun and a lamp.
    fn stage() -> Stage {
        let scene = sheer_gallery::open("plume:particles=4000").unwrap().scene;
        Stage::new(scene, &CameraChoice::Default, Some(2)).unwrap()
    }

    fn sun(stage: &Stage) -> usize {
        let lights = stage.frame().lights();
        lights.iter().position(|light| light.kind == LightKind::Directional).unwrap()
    }

    /// What of the sun arrives at points all through the scene; without buffers, where no pixel asks.
    fn arriving(stage: &Stage, pixels: usize) -> Vec<f32> {
        let shadows = Shadows::for_pixels(stage, &Shadow::default(), 0, 0, pixels).unwrap();
        let triangles = stage.frame().triangles();
        let middles = triangles.iter().step_by(triangles.len() / 2000).map(|[a, b, c]| (a + b + c) / 3.0);
        let light = sun(stage);
        middles.map(|at| shadows.transmittance(stage, light, at, Vec3::Y, [0; 3]).x).collect()
    }

    fn moment(time_secs: f32) -> Moment {
        Moment { time_secs, previous_secs: time_secs }
    }

    #[test]
    fn light_is_the_same_to_the_bit_by_buffers_and_through_the_tree_as_time_goes_on() {
        let mut stage = stage();
        let mut last = Vec::new();
        for time_secs in [0.0, 2.0, 2.5] {
            stage.advance(moment(time_secs));
            let (to_light, _) = toward(&stage.frame().lights()[sun(&stage)], Vec3::ZERO);
            assert!(stage.light_buffer(to_light, 0).is_none());
            // Rays are found in it indeed.
            let buffer = stage.light_buffer(to_light, PIXELS).unwrap();
            let origin = stage.frame().triangles()[stage.frame().static_count()][0];
            let ray = Ray { origin, direction: to_light, t_min: 0.0, t_max: f32::INFINITY };
            assert!(buffer.traverse(&ray, |_| f32::INFINITY));
            let (by_buffers, by_tree) = (arriving(&stage, PIXELS), arriving(&stage, 0));
            assert!(
                by_buffers.iter().zip(&by_tree).all(|(a, b)| a.to_bits() == b.to_bits()),
                "{time_secs} s"
            );
            let partial = by_buffers.iter().filter(|value| (0.05..0.95).contains(*value)).count();
            assert!(partial > 200, "{time_secs} s: {partial} points in half shadow");
            // What is kept of the frame before would be found.
            let moved = by_buffers.iter().zip(&last).filter(|(now, before)| now != before).count();
            assert!(last.is_empty() || moved > 100, "{time_secs} s: {moved}");
            last = by_buffers;
        }
    }

    #[test]
    fn a_buffer_is_kept_until_something_moves_and_not_made_over_too_much() {
        let mut stage = stage();
        let to_light = -stage.frame().lights()[sun(&stage)].direction;
        let first = stage.light_buffer(to_light, PIXELS).unwrap();
        assert!(Arc::ptr_eq(&first, &stage.light_buffer(to_light, PIXELS).unwrap()));
        let elsewhere = stage.light_buffer(vec3(0.0, 1.0, 0.1), PIXELS).unwrap();
        assert!(!Arc::ptr_eq(&first, &elsewhere));
        stage.advance(moment(1.0));
        assert!(!Arc::ptr_eq(&first, &stage.light_buffer(to_light, PIXELS).unwrap()));

        let moving = stage.frame().triangles().len() - stage.frame().static_count();
        assert!(stage.light_buffer(to_light, PIXELS_PER_TRIANGLE * moving).is_some());
        assert!(stage.light_buffer(to_light, PIXELS_PER_TRIANGLE * moving - 1).is_none());
    }

    #[test]
    fn a_buffer_takes_what_is_counted_for_it_at_most() {
        let stage = stage();
        let to_light = -stage.frame().lights()[sun(&stage)].direction;
        let moving = stage.frame().triangles().len() - stage.frame().static_count();
        let bytes = stage.light_buffer(to_light, PIXELS).unwrap().bytes() as u64;
        // Not so little that the bound would mean nothing either.
        let counted = light_buffer_bytes(moving as u64);
        assert!(bytes <= counted && bytes > counted / 20, "{bytes} of {counted}");
    }
}
