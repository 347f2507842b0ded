//! Shading: glTF metallic-roughness under punctual lights with shadows, and the environment.

use std::f32::consts::PI;

use glam::Vec3;
use sheer_accel::Hit;
use sheer_scene::{
    CameraRay, FrameLight, Surface,
    model::{LightKind, ShadingModel},
};

use super::{Counters, Tracer};
use crate::shadow::{Receiver, toward};

/// Reflectance of common dielectrics at normal incidence, index of refraction 1.5 (glTF 2.0, appendix B.2).
const DIELECTRIC_F0: f32 = 0.04;
/// Below this roughness a highlight of a light with no extent would be smaller than a pixel.
const MIN_ROUGHNESS: f32 = 0.045;
/// How far light reaches around a puff of smoke: 0 a hard ball, 1 all the way around.
const SMOKE_WRAP: f32 = 0.6;
/// Forward share of light that shines through a puff towards the viewer, and the width of that glow (Henyey-Greenstein 1941).
const SMOKE_ANISOTROPY: f32 = 0.45;

/// Light that arrives at a surface from one light.
struct Incident {
    /// Unit direction towards the light.
    to_light: Vec3,
    /// World units.
    distance: f32,
    /// Irradiance on a surface that faces the light.
    irradiance: Vec3,
}

impl Tracer<'_> {
    /// Linear radiance that leaves a hit towards the camera.
    pub(super) fn shade(&self, ray: &CameraRay, hit: &Hit, counters: &mut Counters) -> Vec3 {
        let frame = self.stage.frame();
        let surface = frame.surface(hit.triangle, hit.u, hit.v, hit.front);
        counters.shaded += 1;
        let to_viewer = -ray.direction;
        let scene = frame.scene().parts();
        let radiance = match surface.model {
            ShadingModel::Unlit => surface.base_colour,
            ShadingModel::MetallicRoughness => {
                let lobes = Lobes::new(&surface, to_viewer);
                let reflected =
                    (2.0 * lobes.n_dot_v * surface.normal - to_viewer).normalize_or(surface.normal);
                let diffuse = scene.environment.diffuse(surface.normal);
                let specular = scene.environment.radiance(reflected, surface.roughness);
                let ambient = lobes.diffuse * diffuse + lobes.environment_specular() * specular;
                surface.emissive
                    + ambient * surface.occlusion
                    + self.lit(&surface, hit, counters, |incident| {
                        let n_dot_l = surface.normal.dot(incident.to_light);
                        (n_dot_l > 0.0)
                            .then(|| lobes.reflect(&surface, to_viewer, incident.to_light) * n_dot_l)
                    })
            }
            ShadingModel::Smoke => {
                let ambient =
                    0.5 * (scene.environment.diffuse(surface.normal) + scene.environment.diffuse(to_viewer));
                surface.emissive
                    + surface.base_colour * ambient
                    + self.lit(&surface, hit, counters, |incident| {
                        Some(smoke_phase(&surface, to_viewer, incident.to_light))
                    })
            }
        };
        radiance * scene.exposure
    }

    /// Sum over all lights: irradiance × `response` × transmittance; shadows are looked for wherever the response is not none.
    fn lit(
        &self,
        surface: &Surface,
        hit: &Hit,
        counters: &mut Counters,
        response: impl Fn(&Incident) -> Option<Vec3>,
    ) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for (index, light) in self.stage.frame().lights().iter().enumerate() {
            let Some(incident) = arriving(light, surface.position) else { continue };
            let Some(response) = response(&incident) else { continue };
            let receiver = Receiver {
                position: surface.position,
                normal: surface.geometric_normal,
                to_light: incident.to_light,
                distance: incident.distance,
                key: [self.pixel_at[0], self.pixel_at[1], hit.triangle],
            };
            let transmittance = self.shadows.at(self.stage, index, &receiver, counters);
            sum += incident.irradiance * response * transmittance;
        }
        sum
    }
}

/// Light from a punctual light at a point (`KHR_lights_punctual`); none beyond its range or outside its cone.
fn arriving(light: &FrameLight, position: Vec3) -> Option<Incident> {
    let (to_light, distance) = toward(light, position);
    let falloff = |range: f32| {
        let window = (1.0 - (distance / range).powi(4)).clamp(0.0, 1.0);
        window / (distance * distance).max(1e-8)
    };
    let strength = match light.kind {
        LightKind::Directional => 1.0,
        LightKind::Point { range } => falloff(range),
        LightKind::Spot { range, inner_cone_rad, outer_cone_rad } => {
            let cosine = light.direction.dot(-to_light);
            let (inner, outer) = (inner_cone_rad.cos(), outer_cone_rad.cos());
            let cone = ((cosine - outer) / (inner - outer).max(1e-4)).clamp(0.0, 1.0);
            falloff(range) * cone * cone
        }
    };
    let irradiance = light.intensity * strength;
    (strength > 0.0 && to_light.is_finite()).then_some(Incident { to_light, distance, irradiance })
}

/// The terms of the BRDF that do not depend on the light (glTF 2.0, appendix B.3).
struct Lobes {
    /// Albedo of the diffuse lobe.
    diffuse: Vec3,
    /// Specular reflectance at normal incidence.
    f0: Vec3,
    n_dot_v: f32,
    /// Perceptual roughness.
    roughness: f32,
}

impl Lobes {
    fn new(surface: &Surface, to_viewer: Vec3) -> Self {
        Self {
            diffuse: surface.base_colour * (1.0 - surface.metallic),
            f0: Vec3::splat(DIELECTRIC_F0).lerp(surface.base_colour, surface.metallic),
            n_dot_v: surface.normal.dot(to_viewer).max(1e-3),
            roughness: surface.roughness.clamp(MIN_ROUGHNESS, 1.0),
        }
    }

    /// BRDF value: Lambert, and GGX with height-correlated Smith shadowing and Schlick's Fresnel (glTF 2.0, appendix B.3).
    fn reflect(&self, surface: &Surface, to_viewer: Vec3, to_light: Vec3) -> Vec3 {
        let half = (to_viewer + to_light).normalize_or(surface.normal);
        let n_dot_l = surface.normal.dot(to_light).max(1e-3);
        let n_dot_h = surface.normal.dot(half).clamp(0.0, 1.0);
        let v_dot_h = to_viewer.dot(half).clamp(0.0, 1.0);
        let alpha = self.roughness * self.roughness;
        let alpha2 = alpha * alpha;
        let lobe = n_dot_h * n_dot_h * (alpha2 - 1.0) + 1.0;
        let distribution = alpha2 / (PI * lobe * lobe);
        let masking = |cosine: f32, other: f32| other * (cosine * cosine * (1.0 - alpha2) + alpha2).sqrt();
        let visibility = 0.5 / (masking(self.n_dot_v, n_dot_l) + masking(n_dot_l, self.n_dot_v));
        let fresnel = self.f0 + (Vec3::ONE - self.f0) * (1.0 - v_dot_h).powi(5);
        (Vec3::ONE - fresnel) * self.diffuse / PI + fresnel * (distribution * visibility)
    }

    /// Directional albedo of the specular lobe (Karis 2014, *Physically Based Shading on Mobile*).
    fn environment_specular(&self) -> Vec3 {
        let r = self.roughness;
        let (x, y, z, w) = (1.0 - r, 0.0425 - 0.0275 * r, 1.04 - 0.572 * r, 0.022 * r - 0.04);
        let grazing = (x * x).min((-9.28 * self.n_dot_v).exp2()) * x + y;
        let (scale, bias) = (-1.04 * grazing + z, 1.04 * grazing + w);
        self.f0 * scale + Vec3::splat(bias.max(0.0))
    }
}

/// Scattering of a puff: light wraps around its inscribed ball, and some of it shines through towards the viewer.
fn smoke_phase(surface: &Surface, to_viewer: Vec3, to_light: Vec3) -> Vec3 {
    let wrapped = (surface.normal.dot(to_light) + SMOKE_WRAP) / (1.0 + SMOKE_WRAP);
    let wrapped = wrapped.max(0.0) / (1.0 + SMOKE_WRAP);
    let g = SMOKE_ANISOTROPY;
    let cosine = -to_viewer.dot(to_light);
    let forward = (1.0 - g * g) / (4.0 * (1.0 + g * g - 2.0 * g * cosine).powf(1.5));
    surface.base_colour * (0.7 * wrapped + 0.3 * forward) / PI
}
