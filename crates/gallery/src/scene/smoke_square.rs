//! `smoke-square`: a cloud of smoke drifts over the town square, and the camera passes through it (STD Fig. 9
//! and 12).
//!
//! In the middle of the cloud a ray meets tens of layers, which is where rendering all of them becomes slow.

use std::f32::consts::{PI, TAU};

use glam::Vec3;
use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};
use sheer_scene::{
    Scene, SceneError,
    camera::{Camera, CameraKey, CameraMotion, ClipPlanes, Lens},
    particle::{Particle, ParticleSystem, Turbulence},
};

use crate::{
    builder::SceneBuilder,
    kit::{
        smoke::{self, ATLAS},
        square,
    },
    rng::Rng,
    seed::SEED,
};

pub(crate) const PARAMETERS: &[ParameterInfo] = &[
    ParameterInfo {
        key: "particles",
        default: "3600",
        range: ParameterRange::Count(0, 1_000_000),
        what: "how many quads the cloud is made of",
    },
    ParameterInfo {
        key: "density",
        default: "1.0",
        range: ParameterRange::Real(0.0, 3.0),
        what: "factor on the opacity of every puff",
    },
    SEED,
];

/// The middle of the bank of smoke, and from there to where it dissolves; the other way lies the fire.
const CLOUD: Vec3 = Vec3::new(3.2, 1.75, 0.0);
const CLOUD_REACH: Vec3 = Vec3::new(-4.2, 0.35, 0.8);
/// The cloud is never twice the same within this time.
const LOOP_SECS: f32 = 18.0;
/// The wind blows from the fire bowl towards the west.
const WIND: Vec3 = Vec3::new(-0.20, 0.015, 0.05);
const YFOV_RAD: f32 = 0.87;

pub(crate) fn build(values: &Values) -> Result<Scene, SceneError> {
    let mut builder = SceneBuilder::new("smoke-square", square::sky());
    square::raise(&mut builder, values.count(SEED.key));
    let material = smoke::material(&mut builder, values.count(SEED.key));
    let cloud = cloud(values.count("particles"), values.real("density"), values.count(SEED.key));
    builder.particles(ParticleSystem {
        name: "cloud".to_owned(),
        material,
        atlas: ATLAS,
        particles: cloud,
        loop_secs: Some(LOOP_SECS),
        turbulence: Turbulence { amplitude: 0.10, scale: 2.6, speed: 0.035 },
        fade: [0.22, 0.34],
        near_fade: [1.1, 0.2],
    });

    let key = |time_secs, eye: Vec3, target: Vec3| CameraKey { time_secs, eye, target };
    builder.camera(Camera {
        name: "path".to_owned(),
        lens: Lens::Perspective { yfov_rad: YFOV_RAD },
        clip: ClipPlanes::NONE,
        motion: CameraMotion::Path {
            keys: vec![
                key(0.0, Vec3::new(12.8, 1.75, 5.6), Vec3::new(3.5, 2.3, -4.0)),
                key(3.0, Vec3::new(8.6, 1.70, 3.0), Vec3::new(1.0, 2.2, -5.5)),
                key(6.0, Vec3::new(3.6, 1.68, 0.6), Vec3::new(-2.4, 2.2, -7.5)),
                key(9.0, Vec3::new(-1.6, 1.70, 1.4), Vec3::new(-5.0, 2.4, -8.0)),
                key(12.0, Vec3::new(-7.4, 1.75, 5.0), Vec3::new(-3.8, 3.0, -8.0)),
            ],
        },
    });
    builder.camera(Camera::fixed("static", 0.76, Vec3::new(3.0, 1.72, 15.0), Vec3::new(-1.4, 3.7, -5.0)));
    // Around the cloud; the circle that fits the whole town would run through its walls.
    let eye = CLOUD + Vec3::new(5.4, 0.5, 4.2);
    builder.camera(Camera::orbit(Lens::Perspective { yfov_rad: YFOV_RAD }, CLOUD, eye));
    builder.finish()
}

/// A head of smoke: it swells, rolls along with the wind and dissolves.
struct Head {
    /// Halfway through its life.
    centre: Vec3,
    radius: f32,
    birth_secs: f32,
    drift: Vec3,
}

/// Puffs of a head, or of the haze between heads, that stay together.
#[derive(Clone, Copy, Default)]
struct Billow {
    /// Halfway through its life.
    centre: Vec3,
    size: f32,
    birth_secs: f32,
    drift: Vec3,
    /// Factor on the opacity of its puffs.
    thickness: f32,
}

const HEAD_COUNT: u32 = 22;
const BILLOW_SIZE: u32 = 40;

impl Head {
    /// One of the heads, evenly spread over the loop and over the way from the fire to where the cloud
    /// dissolves.
    fn new(index: u32, rng: &mut Rng) -> Self {
        // Steps of the golden ratio: heads that are born one after the other lie apart.
        let way = (index as f32 * 0.618_034 + rng.about(0.0, 0.03)).rem_euclid(1.0);
        let girth = 0.65 + 1.45 * (PI * (0.12 + 0.80 * way)).sin();
        let spine = CLOUD + CLOUD_REACH * (2.0 * way - 1.0);
        let out = rng.direction() * Vec3::new(0.5, 0.75, 1.1) + Vec3::Y * 0.15;
        Self {
            centre: spine + out * girth * 0.75,
            radius: girth * rng.between(0.48, 0.78),
            birth_secs: LOOP_SECS * index as f32 / HEAD_COUNT as f32,
            drift: WIND * rng.between(0.8, 1.2) + Vec3::Y * rng.between(0.0, 0.035),
        }
    }
}

impl Billow {
    fn new(heads: &[Head], rng: &mut Rng) -> Self {
        let head = rng.pick(heads);
        let direction = rng.direction();
        let haze = rng.happens(0.22);
        // Billows sit on the surface of their head; haze lies around it.
        let reach = head.radius * if haze { rng.between(0.8, 1.7) } else { rng.between(0.25, 0.8) };
        Self {
            centre: head.centre + direction * reach * Vec3::new(1.1, 0.9, 1.0),
            size: head.radius * if haze { rng.between(0.6, 0.9) } else { rng.between(0.30, 0.50) },
            birth_secs: head.birth_secs + rng.about(0.0, 1.5),
            drift: head.drift + direction * 0.03,
            thickness: if haze { rng.between(0.35, 0.7) } else { rng.between(0.8, 1.5) },
        }
    }
}

/// Heads that roll along with the wind and dissolve, and a stream that feeds them from the fire bowl.
fn cloud(count: u32, density: f32, seed: u32) -> Vec<Particle> {
    let mut rng = Rng::new(seed, "cloud");
    let stream_count = count / 6;
    let mut particles = Vec::with_capacity(count as usize);
    let heads: Vec<Head> = (0..HEAD_COUNT).map(|index| Head::new(index, &mut rng)).collect();
    let mut billow = Billow::default();
    for index in 0..count - stream_count {
        if index % BILLOW_SIZE == 0 {
            billow = Billow::new(&heads, &mut rng);
        }
        let Billow { centre, size, birth_secs, drift, thickness } = billow;
        let shell = rng.direction() * rng.unit().powf(0.42) * size;
        let mut middle = centre + shell * Vec3::new(1.2, 0.8, 1.0);
        // Smoke spreads over the ground where it sinks to it.
        middle.y = if middle.y < 0.35 { 0.35 + 0.3 * (0.35 - middle.y).min(1.0) } else { middle.y };
        let velocity = drift + shell * 0.02;
        let wisp = rng.happens(0.14);
        let half_size = if wisp { rng.between(0.6, 0.95) } else { rng.between(0.28, 0.50) };
        let alpha = if wisp { rng.between(0.05, 0.12) } else { rng.between(0.10, 0.34) };
        particles.push(Particle {
            birth_secs: birth_secs + rng.about(0.0, 0.8),
            lifetime_secs: LOOP_SECS,
            origin: middle - velocity * (0.5 * LOOP_SECS),
            velocity,
            acceleration: Vec3::ZERO,
            half_size: [half_size * 0.7, half_size * 1.3],
            rotation_rad: rng.between(0.0, TAU),
            spin_rad_per_sec: rng.about(0.0, 0.10),
            alpha: (density * thickness * alpha).min(1.0),
            tint: smoke::tint(&mut rng),
            tile: rng.below(ATLAS[0] * ATLAS[1]),
        });
    }
    for _ in 0..stream_count {
        let lifetime_secs = 9.0;
        let aim = CLOUD + Vec3::new(2.6, -0.1, -0.6) + rng.gaussian() * Vec3::new(0.9, 0.35, 0.5);
        let origin = square::FIRE_BOWL + Vec3::Y * 1.0 + rng.gaussian() * Vec3::new(0.12, 0.03, 0.12);
        // It shoots up and bends over: the acceleration takes back the rise by the end of its life.
        let lift = Vec3::Y * rng.between(0.45, 0.62);
        let acceleration = -lift * (1.7 / lifetime_secs);
        let velocity = (aim - origin - 0.5 * acceleration * lifetime_secs * lifetime_secs) / lifetime_secs;
        particles.push(Particle {
            birth_secs: rng.between(0.0, LOOP_SECS),
            lifetime_secs,
            origin,
            velocity,
            acceleration,
            half_size: [rng.between(0.07, 0.12), rng.between(0.45, 0.75)],
            rotation_rad: rng.between(0.0, TAU),
            spin_rad_per_sec: rng.about(0.0, 0.35),
            alpha: (density * rng.between(0.12, 0.30)).min(1.0),
            tint: smoke::tint(&mut rng) * 0.9,
            tile: rng.below(ATLAS[0] * ATLAS[1]),
        });
    }
    particles
}

#[cfg(test)]
mod tests {
    use sheer_scene::particle::ParticleState;
    use std::sync::LazyLock;

    use super::*;
    use crate::catalogue;

    /// Built once for all tests.
    static SCENE: LazyLock<Scene> = LazyLock::new(|| catalogue::build("smoke-square").unwrap());

    /// Where the puffs are at a time, those that can be seen.
    fn puffs(time_secs: f32) -> Vec<ParticleState> {
        let system = &SCENE.parts().particles[0];
        let alive = (0..system.particles.len()).filter_map(|index| system.state_at(index, time_secs));
        alive.filter(|puff| puff.alpha > 0.02).collect()
    }

    /// Optical depth of the puffs around a point: how much a metre of smoke there would hide.
    fn thickness(puffs: &[ParticleState], at: Vec3) -> f32 {
        let near = puffs.iter().filter(|puff| puff.centre.distance(at) < 0.8);
        near.map(|puff| puff.alpha * 4.0 * puff.half_size * puff.half_size).sum()
    }

    #[test]
    fn the_camera_passes_through_the_cloud() {
        let camera = &SCENE.parts().cameras[0];
        let eye = |time_secs| camera.pose_on_rails(time_secs).unwrap().eye();
        let inside = thickness(&puffs(6.0), eye(6.0));
        for time_secs in [0.0, 12.0] {
            let outside = thickness(&puffs(time_secs), eye(time_secs));
            assert!(outside < 0.02 * inside, "{outside} at {time_secs} s, {inside} in the middle");
        }
        assert!(eye(0.0).x > eye(6.0).x && eye(6.0).x > eye(12.0).x, "from right to left");
    }

    #[test]
    fn a_ray_through_the_middle_meets_tens_of_layers() {
        // Quads face the camera: one that is nearer to the ray than the radius of its puff is met.
        let met = |puff: &&ParticleState| (puff.centre - CLOUD).with_z(0.0).length() < puff.half_size;
        let layer_count = puffs(2.0).iter().filter(met).count();
        assert!((30..=200).contains(&layer_count), "{layer_count}");
    }

    #[test]
    fn the_lamp_post_stands_between_the_sun_and_the_cloud() {
        let sun = square::towards_sun();
        // Where the shadow of a point of the post passes the axis of the cloud.
        let lantern = square::SHADOW_LAMP + Vec3::Y * 4.1;
        let travel = (lantern.z - CLOUD.z) / sun.z;
        let shadow = lantern - sun * travel;
        let along = (shadow - CLOUD).dot(CLOUD_REACH) / CLOUD_REACH.length_squared();
        let offset = (shadow - CLOUD - CLOUD_REACH * along).length();
        assert!(travel > 0.0 && along.abs() < 0.8 && offset < 1.2, "shadow at {shadow}, {along}, {offset}");
    }

    #[test]
    fn the_town_keeps_to_its_budget() {
        let parts = SCENE.parts();
        let triangle_count: usize =
            parts.instances.iter().map(|instance| parts.meshes[instance.mesh as usize].indices.len()).sum();
        assert!((150_000..=400_000).contains(&triangle_count), "{triangle_count} triangles");
        let texels: usize = parts.textures.iter().map(|texture| texture.image.as_slice().len()).sum();
        assert!(4 * texels <= 60 << 20, "{texels} texels");
        let largest = parts.textures.iter().map(|texture| texture.image.width()).max();
        assert!(largest <= Some(512));
    }
}
