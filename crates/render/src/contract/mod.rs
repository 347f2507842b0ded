//! What a transparency method is to the backends. A backend runs any method and names none.
//!
//! * [`Threshold`]: one shaded fragment a pixel. The method gives a threshold for each hit, the backend alone
//!   decides by [`keeps`].
//! * [`Selection`]: one shaded fragment a pixel, too, but one threshold for the whole ray, held against the
//!   coverage accumulated.
//! * [`OrderedCompositing`]: fragments are handed over front to back and the method adds them up.
//! * [`UnorderedCompositing`]: the same in the order in which the scene is drawn, in several passes and over
//!   several samples if the method asks for them.
//!
//! Coloured glass is none of a method's business: the alpha that it is told is that of the channel which
//! passes best, and what the other channels lose on top the backend takes of the light that it hands over
//! (docs/glass.md).
//!
//! [`MethodInfo`] is what lists say of a method and what a GPU needs to run it; [`Raster`] is how a GPU draws
//! it.

mod alignment;
mod family_keys;
mod fragment;
mod hybrid;
mod info;
mod ordered;
mod raster;
mod selection;
mod tables;
mod threshold;
mod unordered;
mod visitor;

pub(crate) use self::family_keys::correction;
pub use self::{
    alignment::{Alignment, AlignmentRule},
    family_keys::CORRECTION_PARAMETER,
    fragment::{
        DENSE_VISIBILITY, Fragment, MIN_ALPHA, MIN_VISIBILITY, Memory, PixelSite, Placement, Samples,
    },
    hybrid::Hybrid,
    info::{MethodInfo, ShaderConstant, ShaderTable, ShaderValue},
    ordered::{OrderedCompositing, Traversal},
    raster::{
        Binding, Blend, Multisample, NoRaster, Passes, Raster, Resource, SampleContent, Step, StepKind,
        TargetFormat,
    },
    selection::Selection,
    tables::{BLUE_NOISE_SIDE, Tables},
    threshold::{Site, Threshold, keeps},
    unordered::{LayerFilter, Retrace, UnorderedCompositing},
    visitor::Visitor,
};
