//! Tables that thresholds are made from.

use sheer_core::{
    blue_noise::blue_noise_64,
    threshold_map::{ThresholdMap, std_maps},
};

/// Side of the blue noise tile, pixels.
pub const BLUE_NOISE_SIDE: u32 = 64;

/// Tables that thresholds are made from, built once a process.
#[derive(Clone, Copy, Debug)]
pub struct Tables {
    /// The 288 maps of STD section 3.3.
    pub std_maps: &'static [ThresholdMap],
    /// 64×64 blue noise in (0, 1), row-major.
    pub blue_noise: &'static [f32],
}

impl Tables {
    /// Builds the tables on first use.
    #[must_use]
    pub fn get() -> Self {
        Self { std_maps: std_maps(), blue_noise: blue_noise_64().values() }
    }

    /// The blue noise of a pixel, in (0, 1): `BlueNoise64x64Tex[pixel % 64]` of STD Listings 1 and 4.
    #[must_use]
    #[inline]
    pub fn blue_noise_at(&self, pixel: [u32; 2]) -> f32 {
        let [x, y] = pixel.map(|coordinate| coordinate % BLUE_NOISE_SIDE);
        self.blue_noise[(y * BLUE_NOISE_SIDE + x) as usize]
    }
}
