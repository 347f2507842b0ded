//! What a frame costs: rays, fragments, milliseconds.

/// What a frame cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Camera rays, continuation rays among them.
    pub camera_rays: u64,
    /// Deep shadow rays, and rays that make shadow maps.
    pub shadow_rays: u64,
    /// Hits of camera rays that were tested or composited.
    pub hits: u64,
    /// How many fragments were shaded, which is the costly part.
    pub shaded: u64,
    /// Fragments that bounded memory had no room for, so that they were merged with others; of a hybrid,
    /// pixels whose exact fragments ran out before the visibility had fallen, so that one draw stands for
    /// more than it should.
    pub merged: u64,
}

impl std::ops::Add for Counters {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            camera_rays: self.camera_rays + other.camera_rays,
            shadow_rays: self.shadow_rays + other.shadow_rays,
            hits: self.hits + other.hits,
            shaded: self.shaded + other.shaded,
            merged: self.merged + other.merged,
        }
    }
}

/// A step of a compositing method and how long all threads together were at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepTime {
    /// `gather`, one of the method's passes, `composite`, or `filter`.
    pub name: &'static str,
    /// Milliseconds, summed over threads; of `filter`, as the clock has them.
    pub ms: f64,
}

/// What a frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timings {
    /// Animation and acceleration structure, milliseconds.
    pub build_ms: f64,
    /// Tracing and shading, shadow maps included.
    pub trace_ms: f64,
    /// Making shadow maps, a part of `trace_ms`.
    pub shadow_ms: f64,
    /// Adding up over time, which frame times leave out (STD section 4).
    pub resolve_ms: f64,
}

impl Timings {
    /// The whole pass including acceleration structure builds, without temporal anti-aliasing (STD section
    /// 4).
    #[must_use]
    pub fn frame_ms(&self) -> f64 {
        self.build_ms + self.trace_ms
    }
}
