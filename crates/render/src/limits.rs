//! What can be asked for at most: beyond are slips of the keyboard, not pictures.

use std::ops::RangeInclusive;

/// Pixels a side; 16k is more than any display has.
pub const LONGEST_SIDE_PX: u32 = 16_384;
/// Frames of a run.
pub const MOST_FRAMES: u32 = 1_000_000;
/// Index of a frame.
pub const LAST_FRAME: u32 = 1_000_000_000;
/// Samples of a frame.
pub const MOST_SAMPLES: u32 = 65_536;
/// Threads; more than any machine has processors.
pub const MOST_THREADS: usize = 1024;
/// Frames a second.
pub const FRAME_RATES: RangeInclusive<f32> = 0.01..=10_000.0;
/// Stops, brighter or darker; from starlight to the sun are 30.
pub const MOST_EXPOSURE_EV: f32 = 64.0;
/// How many times as bright surroundings are made: a panorama in candela a square metre, or one in units of a
/// candle.
pub const MOST_STRENGTH: f32 = 1e6;
/// Full vertical field of view, degrees.
pub const FIELDS_OF_VIEW_DEGREES: RangeInclusive<f32> = 0.001..=179.0;
