//! How a backend meets a method: by its contract, not by its name.

use super::{
    ordered::OrderedCompositing, selection::Selection, threshold::Threshold, unordered::UnorderedCompositing,
};

/// A backend's reaction to each family.
pub trait Visitor {
    /// What comes of it.
    type Output;
    /// The method decides by a threshold for each hit.
    fn threshold(self, method: &impl Threshold) -> Self::Output;
    /// The method selects one fragment by the accumulated coverage.
    fn selection(self, method: &impl Selection) -> Self::Output;
    /// The method adds fragments up, front to back.
    fn ordered(self, method: &impl OrderedCompositing) -> Self::Output;
    /// The method adds fragments up in any order.
    fn unordered(self, method: &impl UnorderedCompositing) -> Self::Output;
}
