//! Camera-facing particle quads: data, and where each quad is at a time.

use glam::{Vec2, Vec3};

/// Particles that share a material. Each particle is an object of its own for the dithering.
#[derive(Clone, Debug)]
pub struct ParticleSystem {
    /// Name for messages.
    pub name: String,
    /// Index into the scene's materials; uv set 0 spans one atlas tile.
    pub material: u32,
    /// Columns and rows of tiles in the texture.
    pub atlas: [u32; 2],
    /// The particles; their index is part of their identity.
    pub particles: Vec<Particle>,
    /// All particles start anew after this time, each at its own phase; `None`: each lives once.
    pub loop_secs: Option<f32>,
    /// Divergence-free stirring on top of each particle's own motion.
    pub turbulence: Turbulence,
    /// Share of the lifetime spent fading in, and out.
    pub fade: [f32; 2],
    /// Quads fade out between these two distances from the camera (far, near), so that passing through one
    /// does not pop.
    pub near_fade: [f32; 2],
}

/// One particle. Its centre is `origin + velocity·age + acceleration·age²/2`, stirred.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// Time at which it appears, seconds.
    pub birth_secs: f32,
    /// How long it lives; infinite is allowed without a loop.
    pub lifetime_secs: f32,
    /// Point at which it appears, world.
    pub origin: Vec3,
    /// World units a second at birth.
    pub velocity: Vec3,
    /// World units a second squared.
    pub acceleration: Vec3,
    /// Half the edge of the quad at birth and at death, world units.
    pub half_size: [f32; 2],
    /// Turn of the quad in its plane at birth.
    pub rotation_rad: f32,
    /// Turn of the quad in its plane, radians a second.
    pub spin_rad_per_sec: f32,
    /// Opacity factor at its peak, 0 to 1.
    pub alpha: f32,
    /// Linear factor on the base colour.
    pub tint: Vec3,
    /// Tile of the atlas, row-major.
    pub tile: u32,
}

/// A slow field of curls made of sines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turbulence {
    /// How far particles are displaced, world units.
    pub amplitude: f32,
    /// Size of the largest curls, world units; must be positive if the amplitude is.
    pub scale: f32,
    /// Turns of the field a second.
    pub speed: f32,
}

/// A particle at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleState {
    /// Middle of the quad, world.
    pub centre: Vec3,
    /// Half the edge of the quad, world units.
    pub half_size: f32,
    /// Turn of the quad in its plane, radians.
    pub rotation_rad: f32,
    /// Opacity factor, 0 to 1, before the fade near the camera.
    pub alpha: f32,
}

impl ParticleSystem {
    /// Where particle `index` is and how opaque; `None` while it is not alive.
    ///
    /// # Panics
    /// If the system has no particle of that index.
    #[must_use]
    pub fn state_at(&self, index: usize, time_secs: f32) -> Option<ParticleState> {
        let particle = &self.particles[index];
        let mut age_secs = time_secs - particle.birth_secs;
        if let Some(loop_secs) = self.loop_secs {
            age_secs = age_secs.rem_euclid(loop_secs);
        }
        if age_secs < 0.0 || age_secs > particle.lifetime_secs {
            return None;
        }
        let life = age_secs / particle.lifetime_secs;
        let moved = particle.velocity * age_secs + particle.acceleration * (0.5 * age_secs * age_secs);
        let centre = particle.origin + moved;
        let fade_in = ramp(life, 0.0, self.fade[0]);
        let fade_out = ramp(1.0 - life, 0.0, self.fade[1]);
        Some(ParticleState {
            centre: centre + self.turbulence.displacement(centre, time_secs),
            half_size: particle.half_size[0] + (particle.half_size[1] - particle.half_size[0]) * life,
            rotation_rad: particle.rotation_rad + particle.spin_rad_per_sec * age_secs,
            alpha: particle.alpha * fade_in * fade_out,
        })
    }

    /// Opacity factor for a quad at this distance from the camera plane.
    pub(crate) fn near_factor(&self, view_depth: f32) -> f32 {
        ramp(view_depth, self.near_fade[1], self.near_fade[0])
    }

    /// Upper left corner and size of an atlas tile in texture coordinates.
    pub(crate) fn tile(&self, tile: u32) -> (Vec2, Vec2) {
        let [columns, rows] = self.atlas;
        let size = Vec2::new(1.0 / columns as f32, 1.0 / rows as f32);
        (Vec2::new((tile % columns) as f32, (tile / columns % rows) as f32) * size, size)
    }
}

impl Turbulence {
    fn displacement(&self, at: Vec3, time_secs: f32) -> Vec3 {
        if self.amplitude == 0.0 {
            return Vec3::ZERO;
        }
        let mut sum = Vec3::ZERO;
        let (mut frequency, mut weight) = (std::f32::consts::TAU / self.scale, self.amplitude);
        for octave in 0..3 {
            let p = at * frequency;
            let phase = std::f32::consts::TAU * self.speed * time_secs + octave as f32 * 1.7;
            // Each component depends on the other two coordinates alone, which makes the field free of
            // divergence.
            sum += weight
                * Vec3::new(
                    (p.y + phase).sin() + (p.z * 0.8 - phase).cos(),
                    (p.z + phase * 0.7).sin() + (p.x * 0.9 + phase).cos(),
                    (p.x - phase).sin() + (p.y * 1.1 + phase * 0.6).cos(),
                );
            frequency *= 2.1;
            weight *= 0.45;
        }
        sum
    }
}

/// Smoothstep from 0 at `low` to 1 at `high`; a step where the two are equal.
fn ramp(value: f32, low: f32, high: f32) -> f32 {
    if high <= low {
        return f32::from(value >= low);
    }
    let s = ((value - low) / (high - low)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}
