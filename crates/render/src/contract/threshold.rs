//! Methods that keep or drop each hit by a threshold of its own.

use glam::Vec3;

use super::{fragment::MIN_ALPHA, tables::Tables};

/// What the threshold of a hit may depend on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Site {
    /// Column and row of the pixel, from the upper left.
    pub pixel: [u32; 2],
    /// Index of the frame.
    pub frame: u32,
    /// Seed of the run.
    pub seed: u32,
    /// `InstanceID()` of STD Listing 4.
    pub instance: u32,
    /// `GeometryIndex()` of STD Listing 4.
    pub geometry: u32,
    /// `PrimitiveIndex()` of STD Listing 4.
    pub primitive: u32,
    /// `HitKind()` of STD Listing 4: 0 front, 1 back.
    pub back: u32,
    /// Hit point in world space, scene units.
    pub position: Vec3,
    /// Hit point in the space of its object, before it moves and bends; filled only for methods that ask for
    /// it by [`Threshold::uses_object_space`].
    pub position_in_object: Vec3,
    /// Length that a pixel covers in the space of the object, along its longer axis; may be infinite. Filled
    /// together with [`Self::position_in_object`].
    pub footprint_in_object: f32,
}

/// Family of methods that keep or drop a hit by comparing its alpha with a threshold. The backend alone
/// decides, by [`keeps`], and shades the nearest hit kept.
pub trait Threshold: Sync {
    /// Whether the method wants to know where on its object a hit lies, which costs the backend some work a
    /// hit.
    fn uses_object_space(&self) -> bool {
        false
    }

    /// The threshold of a hit, in [0, 1).
    fn threshold(&self, site: &Site, tables: &Tables) -> f32;
}

/// The decision of STD Listings 3 and 4, with both ends exact: below [`MIN_ALPHA`] never kept, opaque always.
#[must_use]
#[inline]
pub fn keeps(alpha: f32, threshold: impl FnOnce() -> f32) -> bool {
    alpha >= MIN_ALPHA && (alpha >= 1.0 || alpha >= threshold())
}
