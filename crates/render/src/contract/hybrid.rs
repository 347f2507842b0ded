//! Exact fragments in front of a stochastic ray.

use sheer_core::parameter::{ParameterInfo, ParameterRange, Values};

/// The hybrid of exact and stochastic (STD section 3.4): fragments are shaded and composited front to back
/// until the visibility has fallen to a share, then one stochastic ray stands for the rest. The backend wraps
/// it around any [`Threshold`](super::Threshold) or [`Selection`](super::Selection).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hybrid {
    /// Visibility from which on the stochastic ray takes over, 0 to 1: 0 is exact, 1 purely stochastic.
    pub visibility: f32,
    /// The most fragments that are composited before, however much is visible; `None` for no such limit. The
    /// paper's fall-back to a k-buffer where many faint layers would each be shaded; here the rest is
    /// sampled, so nothing is dropped.
    pub layers: Option<u32>,
}

impl Hybrid {
    /// No exact part at all.
    pub const NONE: Self = Self { visibility: 1.0, layers: None };
    /// Nothing but the exact part: the baseline.
    pub const EXACT: Self = Self { visibility: 0.0, layers: None };

    /// The keys for it.
    pub(crate) const PARAMETERS: &[ParameterInfo] = &[
        ParameterInfo {
            key: "hybrid",
            default: "1",
            range: ParameterRange::Real(0.0, 1.0),
            what: "exact until visibility falls to this, one stochastic ray for the rest; 0 is the baseline",
        },
        ParameterInfo {
            key: "layers",
            default: "0",
            range: ParameterRange::Count(0, 64),
            what: "with hybrid below 1: at most so many exact fragments; 0 for no limit",
        },
    ];

    pub(crate) fn new(values: &Values) -> Self {
        let layers = values.count("layers");
        Self { visibility: values.real("hybrid"), layers: (layers > 0).then_some(layers) }
    }
}
