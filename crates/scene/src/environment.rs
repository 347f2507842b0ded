//! Light from far away: a sky in closed form, so that it can be looked up blurred without tables or noise, a
//! panorama, or both.

pub mod panorama;

use std::{f32::consts::PI, sync::Arc};

use glam::Vec3;
use sheer_image::{Image, ImageError};

use self::panorama::{DistantLight, EnvironmentMap, LEVEL_DIFFUSE, LEVEL_SHARP, ROUGHNESS_STEPS};

/// How far a reflection of roughness 1 pulls the height of the gradient towards the horizon, as a share. By
/// eye.
pub const HORIZON_BLUR: f32 = 0.6;
/// Squares of roughness below count as this one, so that a mirror's lobe is finite.
pub const LEAST_WIDTH: f32 = 1e-3;
/// How many times faster the gradient reaches the ground's colour below the horizon than the zenith's above.
/// By eye.
pub const GROUND_STEEPNESS: f32 = 3.0;

/// A vertical gradient plus soft lobes plus a panorama, all linear radiance.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Linear radiance from straight above.
    pub zenith: Vec3,
    /// Linear radiance from the horizon.
    pub horizon: Vec3,
    /// Linear radiance from straight below.
    pub ground: Vec3,
    /// Soft boxes, the glow around a sun: what reflections live on.
    pub lobes: Vec<Lobe>,
    /// What a picture adds to that.
    pub map: Option<Arc<EnvironmentMap>>,
    /// A light that casts shadows, and that surfaces which blur what they reflect do not find in the above.
    pub light: Option<DistantLight>,
}

/// Surroundings that have a name.
#[derive(Clone, Copy, Debug)]
pub struct NamedEnvironment {
    /// The name.
    pub name: &'static str,
    /// What they are, for lists and help.
    pub what: &'static str,
    /// Makes them.
    pub make: fn() -> Environment,
}

/// All surroundings that have a name.
pub const NAMED: [NamedEnvironment; 3] = [
    NamedEnvironment { name: "none", what: "no light", make: Environment::black },
    NamedEnvironment {
        name: "studio",
        what: "a dim grey room with four soft lights, which files are shown in",
        make: Environment::neutral_studio,
    },
    NamedEnvironment {
        name: "plain",
        what: "even white light from everywhere, in which base colours come out as they were authored",
        make: Environment::plain,
    },
];

/// A spherical Gaussian: `radiance · exp(sharpness · (cos - 1))` (Wang et al. 2009).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Unit direction towards the brightest point.
    pub direction: Vec3,
    /// Linear radiance of the brightest point.
    pub radiance: Vec3,
    /// Greater is smaller: 2 fills a third of the sky, 500 is a lamp.
    pub sharpness: f32,
}

impl Default for Environment {
    fn default() -> Self {
        Self::neutral_studio()
    }
}

impl Environment {
    /// No light at all.
    #[must_use]
    pub fn black() -> Self {
        Self {
            zenith: Vec3::ZERO,
            horizon: Vec3::ZERO,
            ground: Vec3::ZERO,
            lobes: Vec::new(),
            map: None,
            light: None,
        }
    }

    /// Radiance 1 from all directions.
    #[must_use]
    pub fn plain() -> Self {
        Self { zenith: Vec3::ONE, horizon: Vec3::ONE, ground: Vec3::ONE, ..Self::black() }
    }

    /// The surroundings of a panorama, see [`panorama`]: equirectangular, linear radiance, finite and not
    /// negative, top row first.
    ///
    /// # Errors
    /// [`ImageError::Size`] if memory does not suffice.
    pub fn from_panorama(panorama: &Image<[f32; 3]>) -> Result<Self, ImageError> {
        let (map, light) = EnvironmentMap::new(panorama)?;
        Ok(Self { map: Some(Arc::new(map)), light, ..Self::black() })
    }

    /// The same surroundings, `strength` times as bright.
    #[must_use]
    pub fn scaled(mut self, strength: f32) -> Self {
        self.zenith *= strength;
        self.horizon *= strength;
        self.ground *= strength;
        for lobe in &mut self.lobes {
            lobe.radiance *= strength;
        }
        if let Some(light) = &mut self.light {
            light.irradiance *= strength;
        }
        self.map = self.map.map(|map| Arc::new(Arc::unwrap_or_clone(map).scaled(strength)));
        self
    }

    /// What files are shown in: a dim grey room with a key, a fill, a rim light and a large
    /// soft one in front. Dim, so that white things stand out and metals have something dark to reflect.
    #[must_use]
    pub fn neutral_studio() -> Self {
        let lobe = |x: f32, y: f32, z: f32, strength: f32, sharpness: f32| Lobe {
            direction: Vec3::new(x, y, z).normalize(),
            radiance: Vec3::splat(strength),
            sharpness,
        };
        Self {
            zenith: Vec3::splat(0.34),
            horizon: Vec3::splat(0.2),
            ground: Vec3::splat(0.09),
            lobes: vec![
                lobe(0.6, 0.9, 0.7, 6.5, 16.0),
                lobe(-0.9, 0.35, 0.5, 1.8, 9.0),
                lobe(0.1, 1.5, -1.0, 3.0, 14.0),
                lobe(0.15, 0.3, 1.0, 0.8, 4.0),
            ],
            ..Self::black()
        }
    }

    /// Radiance arriving from a unit direction, averaged over a lobe of the given width: 0 is a mirror's
    /// view, 1 nearly the whole hemisphere (perceptual roughness).
    #[must_use]
    pub fn radiance(&self, direction: Vec3, roughness: f32) -> Vec3 {
        let level = LEVEL_SHARP as f32 + roughness.clamp(0.0, 1.0) * ROUGHNESS_STEPS as f32;
        self.closed_form(direction, roughness) + self.map_at(direction, level)
    }

    fn map_at(&self, direction: Vec3, level: f32) -> Vec3 {
        self.map.as_ref().map_or(Vec3::ZERO, |map| map.at(direction, level))
    }

    fn closed_form(&self, direction: Vec3, roughness: f32) -> Vec3 {
        // The gradient is smooth: blurring it pulls the height towards the horizon's mix.
        let blur = 1.0 - HORIZON_BLUR * roughness * roughness;
        let mut sum = self.gradient(direction.y * blur);
        // A rough reflection is itself a spherical Gaussian; the product's width adds as 1/sharpness (Wang et
        // al. 2009, section 3.2).
        let alpha = (roughness * roughness).max(LEAST_WIDTH);
        let view_sharpness = 2.0 / (alpha * alpha) / 4.0;
        for lobe in &self.lobes {
            let sharpness = lobe.sharpness * view_sharpness / (lobe.sharpness + view_sharpness);
            let energy = sharpness / lobe.sharpness;
            sum += lobe.radiance * energy * (sharpness * (direction.dot(lobe.direction) - 1.0)).exp();
        }
        sum
    }

    /// Irradiance on a surface with the given unit normal, divided by pi: the radiance that a white diffuse
    /// surface shows.
    #[must_use]
    pub fn diffuse(&self, normal: Vec3) -> Vec3 {
        // Cosine-weighted mean of the gradient in closed form: the hemisphere's mean height is 2/3 of the
        // normal's.
        let mut sum = self.gradient(normal.y * (2.0 / 3.0));
        for lobe in &self.lobes {
            // Lobe integral times a clamped cosine softened by the lobe's width.
            let integral = 2.0 * PI / lobe.sharpness * (1.0 - (-2.0 * lobe.sharpness).exp());
            let softness = 1.0 / (1.0 + lobe.sharpness);
            let cosine = normal.dot(lobe.direction);
            let facing = ((cosine + softness) / (1.0 + softness)).max(0.0);
            sum += lobe.radiance * integral * facing / PI;
        }
        sum + self.map_at(normal, LEVEL_DIFFUSE as f32)
    }

    fn gradient(&self, height: f32) -> Vec3 {
        if height >= 0.0 {
            self.horizon.lerp(self.zenith, height.min(1.0).sqrt())
        } else {
            self.horizon.lerp(self.ground, (-height * GROUND_STEEPNESS).min(1.0).sqrt())
        }
    }
}
