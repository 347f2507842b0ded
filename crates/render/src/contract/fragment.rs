//! Fragments and pixels as compositing methods see them.

/// Alpha below this is not there (STD Listing 2, `MIN_ALPHA`): it saves the shading of what nobody sees.
pub const MIN_ALPHA: f32 = 0.01;
/// What lies behind this visibility is not looked for (STD Listing 2, `MIN_VISIBILITY`).
pub const MIN_VISIBILITY: f32 = 0.001;
/// A front through which no more than this is seen counts as all there is to a pixel: its layers are not told
/// apart any further, and what lies behind is sampled as a part of it.
pub const DENSE_VISIBILITY: f32 = 1.0 / 32.0;

/// The samples of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Samples {
    /// How many, 1 to [`Self::MOST`].
    pub count: u32,
    /// Where they lie within the pixel.
    pub placement: Placement,
}

/// Where the samples of a pixel lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// All where the pixel's one ray goes through: a surface covers all of them or none.
    Centre,
    /// Spread evenly over the pixel, so that their mean is its box filter.
    Box,
    /// Spread over 2×2 pixels by the density of a Gaussian, so that their mean is the filter of ST section
    /// 3.5.
    Gaussian,
}

impl Samples {
    /// A mask has one bit a sample.
    pub const MOST: u32 = 64;
    /// One sample, where the pixel's ray goes through.
    pub const ONE: Self = Self { count: 1, placement: Placement::Centre };

    /// All samples as a mask.
    #[must_use]
    pub fn all(self) -> u64 {
        u64::MAX >> (Self::MOST - self.count)
    }
}

/// A pixel that a compositing method is about to fill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelSite {
    /// Column and row, from the upper left.
    pub pixel: [u32; 2],
    /// Index of the frame in its run.
    pub frame: u32,
    /// Seed of the run.
    pub seed: u32,
    /// No fragment of the frame is nearer or further than these, scene units along the view axis; both above
    /// 0.
    pub depth_range: [f32; 2],
}

/// The part of a triangle that a pixel sees, transparent and in front of everything opaque.
#[derive(Clone, Copy, Debug)]
pub struct Fragment<'a> {
    /// Opacity, of coloured glass to the channel that passes best, [`MIN_ALPHA`] to below 1, at the covered
    /// sample nearest to the pixel centre, where it is
    /// shaded, too. Ordered gatherings end with a fragment of 1, where something opaque is.
    pub alpha: f32,
    /// Samples that it covers, one bit each; never none.
    pub coverage: u64,
    /// Depth at each sample, scene units along the view axis; samples that are not covered hold anything.
    /// Only one where all samples lie in the centre.
    pub depths: &'a [f32],
    /// Index of the triangle in the scene: breaks ties of equal depths, so that no order of drawing shows.
    pub order: u32,
    /// `InstanceID()` of STD Listing 4.
    pub instance: u32,
    /// `GeometryIndex()` of STD Listing 4.
    pub geometry: u32,
    /// `PrimitiveIndex()` of STD Listing 4.
    pub primitive: u32,
    /// `HitKind()` of STD Listing 4: false front, true back.
    pub is_back: bool,
}

impl Fragment<'_> {
    /// Depth at a covered sample, with its tie-breaker: the order of all fragments there.
    #[must_use]
    #[inline]
    pub fn sort_key(&self, sample: usize) -> (f32, u32) {
        (self.depths[sample.min(self.depths.len() - 1)], self.order)
    }

    /// Depth where it is shaded.
    #[must_use]
    #[inline]
    pub fn depth(&self) -> f32 {
        self.depths[(self.coverage.trailing_zeros() as usize).min(self.depths.len() - 1)]
    }
}

/// What a method stores for a pixel on a GPU, beyond the colour and depth targets that all methods have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// So many bytes, whatever the scene.
    Bounded(u32),
    /// So many bytes a fragment: there is no bound.
    PerFragment(u32),
}
