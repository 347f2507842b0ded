//! The parameter that every built-in scene takes.

use sheer_core::parameter::{ParameterInfo, ParameterRange};

/// Stands last in the parameters of each scene.
pub(crate) const SEED: ParameterInfo = ParameterInfo {
    key: "seed",
    default: "0",
    range: ParameterRange::Count(0, u32::MAX),
    what: "another seed, another arrangement of the same scene",
};
