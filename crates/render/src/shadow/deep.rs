//! Deep shadow rays: the exact light that passes everything between a point and a light (STD section 3.1).

use glam::Vec3;
use sheer_accel::{Hit, Ray};
use sheer_core::{bibliography, parameter::Values};

use super::technique::{Map, Receiver, ShadowInfo, Technique, View};
use crate::{
    contract::{MIN_ALPHA, MIN_VISIBILITY},
    cost::Counters,
    stage::Stage,
};

/// The row of the technique in lists and help.
pub(super) const INFO: ShadowInfo = ShadowInfo {
    id: "deep",
    title: "a ray through everything between a fragment and a light",
    paper: "Brüll, Kern, Grosch (STD), section 3.1",
    works: &[&bibliography::STD],
    bias: "none",
    parameters: &[],
};

/// Deep shadow rays, which have no parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Deep;

impl Deep {
    pub(super) fn new(_: &Values) -> Self {
        Self
    }
}

impl Technique for Deep {
    fn resolution(&self) -> u32 {
        0
    }

    fn texel_bytes(&self, _: usize) -> usize {
        0
    }

    fn map(&self, view: &View<'_>) -> Box<dyn Map> {
        Box::new(Rays { tinted: view.channels > 1 })
    }

    fn values(&self) -> Vec<String> {
        Vec::new()
    }
}

/// In place of a map: a ray for each lookup.
#[derive(Debug)]
struct Rays {
    tinted: bool,
}

impl Map for Rays {
    fn transmittance(&self, stage: &Stage, receiver: &Receiver, counters: &mut Counters) -> Vec3 {
        counters.shadow_rays += 1;
        if self.tinted {
            let through = |light: Vec3, hit: &Hit, alpha| {
                light
                    * stage.frame().light_through(
                        hit.triangle,
                        hit.u,
                        hit.v,
                        hit.front,
                        alpha,
                        receiver.width,
                    )
            };
            product(stage, receiver, Vec3::ONE, Vec3::ZERO, through, Vec3::max_element)
        } else {
            let through = |light: f32, _: &Hit, alpha| light * (1.0 - alpha);
            Vec3::splat(product(stage, receiver, 1.0, 0.0, through, |light| light))
        }
    }
}

/// What is left of `light` after every hit; `none` once its `brightest` channel is too dark to see.
fn product<T: Copy>(
    stage: &Stage,
    receiver: &Receiver,
    light: T,
    none: T,
    through: impl Fn(T, &Hit, f32) -> T,
    brightest: impl Fn(T) -> f32,
) -> T {
    let lift = receiver.lift(stage);
    // Lifted towards the light's side of the surface.
    let side = receiver.normal.dot(receiver.to_light).signum();
    let origin = receiver.position + receiver.normal * (side * lift);
    let distance = receiver.distance - 2.0 * lift;
    let mut transmittance = light;
    let ray = Ray { origin, direction: receiver.to_light, t_min: 0.0, t_max: distance };
    stage.bvh().traverse(&ray, |hit| {
        let alpha = stage.frame().opacity(hit.triangle, hit.u, hit.v, receiver.width);
        if alpha >= MIN_ALPHA {
            transmittance = through(transmittance, &hit, alpha);
        }
        if brightest(transmittance) <= MIN_VISIBILITY {
            transmittance = none;
            return f32::NEG_INFINITY;
        }
        distance
    });
    transmittance
}
