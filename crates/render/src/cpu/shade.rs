//! Shading: glTF metallic-roughness under punctual lights with shadows, and the environment.

use std::f32::consts::PI;

use glam::Vec3;
use sheer_accel::Hit;
use sheer_scene::{
    Beam, CameraRay, FrameLight, Surface,
    model::{LightKind, ShadingModel},
};

use super::tracer::Tracer;
use crate::{
    cost::Counters,
    shadow::{Receiver, toward},
};

/// Reflectance of common dielectrics at normal incidence, index of refraction 1.5 (glTF 2.0, appendix B.2).
pub const DIELECTRIC_F0: f32 = 0.04;
/// Below this roughness a highlight of a light with no extent would be smaller than a pixel.
pub const MIN_ROUGHNESS: f32 = 0.045;
/// How far light reaches around a puff of smoke: 0 a hard ball, 1 all the way around.
pub const SMOKE_WRAP: f32 = 0.6;
/// Forward share of light that shines through a puff towards the viewer, and the width of that glow
/// (Henyey-Greenstein 1941).
pub const SMOKE_ANISOTROPY: f32 = 0.45;
/// Share of the light that is reflected at the surface of a fibre (refractive index 1.55, Marschner et al.
/// 2003). By eye: more of it and of [`FIBRE_THROUGH`] makes fur look wet, less makes it felt.
pub const FIBRE_SURFACE: f32 = 0.0465;
/// Share of the light that enters a fibre which shines through it. What neither does this nor is
/// [`FIBRE_BACK`] has gone from hair to hair and comes from everywhere.
pub const FIBRE_THROUGH: f32 = 0.30;
/// Share of the light that enters a fibre which is reflected at its far side.
pub const FIBRE_BACK: f32 = 0.15;
/// How much the scales of a hair tilt its highlights towards the root, as the sine of an angle of about 3
/// degrees (Marschner et al. 2003).
pub const FIBRE_TILT: f32 = 0.05;

/// Coefficients of the closed forms of Karis 2016 (*Physically Based Hair Shading in Unreal*): the logarithm
/// of what shines through a fibre is the first of them by the cosine of the angle around it, plus the second.
pub const FIBRE_THROUGH_FIT: [f32; 2] = [-3.65, -3.98];
/// The same for what its far side reflects.
pub const FIBRE_BACK_FIT: [f32; 2] = [17.0, -16.78];
/// Shares of the light of a puff that wraps around it and that shines through it. By eye: more of the second
/// glows against the sun.
pub const SMOKE_SHARES: [f32; 2] = [0.7, 0.3];
/// Slopes, by roughness, of the fit of the specular lobe's albedo (Karis 2014, *Physically Based Shading on
/// Mobile*, `c0`).
pub const SPECULAR_FIT_SLOPES: [f32; 4] = [-1.0, -0.0275, -0.572, 0.022];
/// Where these begin (`c1` there).
pub const SPECULAR_FIT_STARTS: [f32; 4] = [1.0, 0.0425, 1.04, -0.04];
/// How fast the fit falls off towards the normal, in octaves a unit of cosine.
pub const SPECULAR_FIT_FALL: f32 = -9.28;
/// The share of the fit's grazing part that goes over from the lobe's scale to its bias.
pub const SPECULAR_FIT_GRAZING: f32 = 1.04;
/// Cosines below count as this one, which keeps the divisors of the BRDF away from zero.
pub const LEAST_COSINE: f32 = 1e-3;
/// A spot's cone has a soft edge at least as wide as this, in cosines: a division.
pub const LEAST_CONE: f32 = 1e-4;
/// Squares of distances below count as this one: light does not become infinite at a lamp.
pub const LEAST_SQUARE_DISTANCE: f32 = 1e-8;

/// Light that arrives at a surface from one light.
struct Incident {
    /// Unit direction towards the light.
    to_light: Vec3,
    /// Distance to the light, world units.
    distance: f32,
    /// Irradiance on a surface that faces the light.
    irradiance: Vec3,
}

impl Tracer<'_> {
    /// Linear radiance that leaves a hit towards the camera; what shines through it is not among it.
    pub(super) fn shade(&self, ray: &CameraRay, hit: &Hit, counters: &mut Counters) -> Vec3 {
        let frame = self.stage.frame();
        // As wide as a pixel is at the depth of the hit, which is nearer than the hit itself towards corners.
        let beam = Beam { direction: ray.direction, width: self.beam.width_at(self.depth(ray, hit)) };
        let surface = frame.surface(hit.triangle, hit.u, hit.v, hit.front, beam);
        counters.shaded += 1;
        let to_viewer = -ray.direction;
        let scene = frame.scene().parts();
        let radiance = match surface.model {
            ShadingModel::Unlit | ShadingModel::Luminous => surface.base_colour,
            ShadingModel::MetallicRoughness => {
                let lobes = Lobes::new(&surface, to_viewer);
                let reflected =
                    (2.0 * lobes.n_dot_v * surface.normal - to_viewer).normalize_or(surface.normal);
                let diffuse = scene.environment.diffuse(surface.normal);
                let specular = scene.environment.radiance(reflected, surface.roughness);
                let ambient = lobes.diffuse * diffuse + lobes.environment_specular() * specular;
                surface.emissive
                    + ambient * surface.occlusion
                    + self.lit(&surface, hit, beam.width, counters, |incident| {
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
                    + self.lit(&surface, hit, beam.width, counters, |incident| {
                        Some(smoke_phase(&surface, to_viewer, incident.to_light))
                    })
            }
            ShadingModel::Fibre => {
                // The side that is seen of a round thing looks towards the viewer as far as its direction
                // allows.
                let facing = across(surface.normal, to_viewer).normalize_or(to_viewer);
                surface.emissive
                    + surface.base_colour * scene.environment.diffuse(facing) * surface.occlusion
                    + self.lit(&surface, hit, beam.width, counters, |incident| {
                        Some(fibre_scattering(&surface, to_viewer, incident.to_light))
                    })
            }
        };
        let own_share = self.glass(hit).map_or(1.0, |glass| glass.own_share);
        radiance * scene.exposure * own_share
    }

    /// Sum over all lights: irradiance × `response` × transmittance; shadows are looked for wherever the
    /// response is not none, with beams of `width`, world units.
    fn lit(
        &self,
        surface: &Surface,
        hit: &Hit,
        width: f32,
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
                width,
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
        window / (distance * distance).max(LEAST_SQUARE_DISTANCE)
    };
    let strength = match light.kind {
        LightKind::Directional => 1.0,
        LightKind::Point { range } => falloff(range),
        LightKind::Spot { range, inner_cone_rad, outer_cone_rad } => {
            let cosine = light.direction.dot(-to_light);
            let (inner, outer) = (inner_cone_rad.cos(), outer_cone_rad.cos());
            let cone = ((cosine - outer) / (inner - outer).max(LEAST_CONE)).clamp(0.0, 1.0);
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
    /// Perceptual roughness, the square root of the width of the lobe.
    roughness: f32,
}

impl Lobes {
    fn new(surface: &Surface, to_viewer: Vec3) -> Self {
        Self {
            diffuse: surface.base_colour * (1.0 - surface.metallic),
            f0: Vec3::splat(DIELECTRIC_F0).lerp(surface.base_colour, surface.metallic),
            n_dot_v: surface.normal.dot(to_viewer).max(LEAST_COSINE),
            roughness: surface.roughness.clamp(MIN_ROUGHNESS, 1.0),
        }
    }

    /// BRDF value: Lambert, and GGX with height-correlated Smith shadowing and Schlick's Fresnel (glTF 2.0,
    /// appendix B.3).
    fn reflect(&self, surface: &Surface, to_viewer: Vec3, to_light: Vec3) -> Vec3 {
        let half = (to_viewer + to_light).normalize_or(surface.normal);
        let n_dot_l = surface.normal.dot(to_light).max(LEAST_COSINE);
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
        let [x, y, z, w] =
            std::array::from_fn(|index| SPECULAR_FIT_SLOPES[index] * r + SPECULAR_FIT_STARTS[index]);
        let grazing = (x * x).min((SPECULAR_FIT_FALL * self.n_dot_v).exp2()) * x + y;
        let (scale, bias) = (-SPECULAR_FIT_GRAZING * grazing + z, SPECULAR_FIT_GRAZING * grazing + w);
        self.f0 * scale + Vec3::splat(bias.max(0.0))
    }
}

/// Scattering of a puff: light wraps around its inscribed ball, and some of it shines through towards the
/// viewer.
fn smoke_phase(surface: &Surface, to_viewer: Vec3, to_light: Vec3) -> Vec3 {
    let wrapped = (surface.normal.dot(to_light) + SMOKE_WRAP) / (1.0 + SMOKE_WRAP);
    let wrapped = wrapped.max(0.0) / (1.0 + SMOKE_WRAP);
    let g = SMOKE_ANISOTROPY;
    let cosine = -to_viewer.dot(to_light);
    let nearness = 1.0 + g * g - 2.0 * g * cosine;
    // nearness^1.5, to two roundings.
    let forward = (1.0 - g * g) / (4.0 * (nearness * nearness.sqrt()));
    surface.base_colour * (SMOKE_SHARES[0] * wrapped + SMOKE_SHARES[1] * forward) / PI
}

/// The part of a direction that is perpendicular to a unit axis.
fn across(axis: Vec3, direction: Vec3) -> Vec3 {
    direction - axis * axis.dot(direction)
}

/// Scattering of a fibre, the cosine of the light included: a highlight, light that shines through, light
/// from its far side (Marschner et al. 2003, in the closed forms of Karis 2016, *Physically Based Hair
/// Shading in Unreal*), and a diffuse part (after Kajiya and Kay 1989) that stands for all light that has met
/// other hairs before. White scatters no more than what arrives.
fn fibre_scattering(surface: &Surface, to_viewer: Vec3, to_light: Vec3) -> Vec3 {
    let along = surface.normal;
    let (light_across, view_across) = (across(along, to_light), across(along, to_viewer));
    let cosine = light_across.length();
    // Of the angle around the fibre.
    let around = light_across.normalize_or_zero().dot(view_across.normalize_or_zero()).clamp(-1.0, 1.0);
    let rise = along.dot(to_light) + along.dot(to_viewer);
    let width = surface.roughness.max(MIN_ROUGHNESS).powi(2);
    let lobe = |tilt: f32, width: f32| {
        let offset = (rise - tilt) / width;
        (-0.5 * offset * offset).exp() / (width * (2.0 * PI).sqrt())
    };
    let reflected = FIBRE_SURFACE * lobe(-2.0 * FIBRE_TILT, width) * 0.25 * (0.5 + 0.5 * around).sqrt();
    let through = FIBRE_THROUGH
        * lobe(FIBRE_TILT, 0.5 * width)
        * (FIBRE_THROUGH_FIT[0] * around + FIBRE_THROUGH_FIT[1]).exp();
    let back = FIBRE_BACK
        * lobe(4.0 * FIBRE_TILT, 2.0 * width)
        * (FIBRE_BACK_FIT[0] * around + FIBRE_BACK_FIT[1]).exp();
    let diffuse = (1.0 - FIBRE_THROUGH - FIBRE_BACK) * (1.0 + around) / (PI * PI);
    let inside = (1.0 - FIBRE_SURFACE) * (through + back + diffuse);
    (Vec3::splat(reflected) + surface.base_colour * inside) * cosine
}

#[cfg(test)]
mod tests {
    use sheer_scene::FaceSide;

    use super::*;

    fn fibre(roughness: f32) -> Surface {
        Surface {
            position: Vec3::ZERO,
            previous_position: Vec3::ZERO,
            geometric_normal: Vec3::Z,
            normal: Vec3::X,
            side: FaceSide::Front,
            base_colour: Vec3::ONE,
            metallic: 0.0,
            roughness,
            emissive: Vec3::ZERO,
            occlusion: 1.0,
            model: ShadingModel::Fibre,
        }
    }

    /// Share of the light from everywhere that goes to the viewer: midpoints over height along the fibre and
    /// angle around it.
    fn albedo(surface: &Surface, to_viewer: Vec3) -> f32 {
        let (rises, turns) = (400, 200);
        let mut sum = 0.0;
        for rise in 0..rises {
            let x = (rise as f32 + 0.5) / rises as f32 * 2.0 - 1.0;
            for turn in 0..turns {
                let (sin, cos) = ((turn as f32 + 0.5) / turns as f32 * 2.0 * PI).sin_cos();
                let radius = (1.0 - x * x).sqrt();
                sum += fibre_scattering(surface, to_viewer, Vec3::new(x, radius * cos, radius * sin)).x;
            }
        }
        sum * 4.0 * PI / (rises * turns) as f32
    }

    #[test]
    fn a_white_fibre_gives_back_most_of_the_light_and_never_more() {
        for roughness in [0.25, 0.4, 0.7] {
            for angle_rad in [0.0_f32, 0.5, 1.0] {
                let to_viewer = Vec3::new(angle_rad.sin(), 0.0, angle_rad.cos());
                let albedo = albedo(&fibre(roughness), to_viewer);
                let least = 0.75 * angle_rad.cos();
                assert!(albedo <= 1.0 && albedo > least, "{albedo} at {roughness}, {angle_rad}");
            }
        }
    }

    #[test]
    fn a_fibre_has_no_sides_and_shines_against_the_light() {
        let surface = fibre(0.4);
        let (viewer, light) = (Vec3::new(0.2, 0.3, 0.9).normalize(), Vec3::new(-0.1, 0.8, 0.5).normalize());
        // Turned around its own direction, viewer and light with it, it looks the same.
        let turned = glam::Quat::from_rotation_x(2.1);
        let before = fibre_scattering(&surface, viewer, light).x;
        let after = fibre_scattering(&surface, turned * viewer, turned * light).x;
        assert!((before - after).abs() < 1e-5 * before, "{before} {after}");
        let at = |light: Vec3| fibre_scattering(&surface, Vec3::Z, light).x;
        assert!(at(Vec3::NEG_Z) > at(Vec3::Y) && at(Vec3::Z) > at(Vec3::Y), "glow and highlight stand out");
    }
}
