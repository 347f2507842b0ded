//! Keys that every method of a single shaded fragment takes, beside those of [`Hybrid`](super::Hybrid).

use sheer_core::{
    choice,
    coverage::Correction,
    parameter::{ParameterInfo, Values},
};

choice! {
    /// Which curve leads from opacity to coverage.
    enum CorrectionChoice {
        /// Coverage is opacity: [`Correction::NONE`].
        None = "none",
        /// The cubic of STD Eq. 5: [`Correction::DLSS`].
        Dlss = "dlss",
    }
}

/// The key for the correction of coverage (STD section 3.2.1), which every [`Threshold`](super::Threshold)
/// and [`Selection`](super::Selection) takes. The backend applies it to the opacity that is held against a
/// threshold, not to fragments that are composited exactly, nor to shadows.
pub const CORRECTION_PARAMETER: ParameterInfo = CorrectionChoice::parameter(
    "correction",
    CorrectionChoice::None,
    "opacity to coverage before the threshold; dlss: STD Eq. 5; on the command line also a file of `sheer calibrate`",
);

/// The correction that was asked for.
pub(crate) fn correction(values: &Values) -> Correction {
    match values.choice(CORRECTION_PARAMETER.key) {
        CorrectionChoice::None => Correction::NONE,
        CorrectionChoice::Dlss => Correction::DLSS,
    }
}
