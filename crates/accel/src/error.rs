//! Why there is no tree, or none to trust.

use crate::simd::SimdPath;

/// What can be wrong with a tree or with the path it shall run on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AccelError {
    /// The processor, or the architecture this was built for, lacks the path.
    #[error("this processor cannot run the {0} path; take `SimdPath::detect()` or `SimdPath::Portable`")]
    UnsupportedPath(SimdPath),
    /// A child points outside the arrays, or two parents share it.
    #[error(
        "node {node}, child {lane}: reference {child:#x} is out of range or shared; build the tree again"
    )]
    BrokenLink {
        /// Index of the parent node.
        node: u32,
        /// Which of its eight children.
        lane: usize,
        /// The reference as stored.
        child: u32,
    },
    /// A child's box is not a box (NaN, or its lower bound above its upper bound), or does not contain what
    /// lies below it.
    #[error("node {node}, child {lane}: its box does not contain what lies below it; build the tree again")]
    BrokenBox {
        /// Index of the parent node.
        node: u32,
        /// Which of its eight children.
        lane: usize,
    },
    /// A leaf holds other vertices than the triangle it names, or names none of them.
    #[error("leaf {leaf}: triangle {triangle} is not the one given; rebuild after triangles move")]
    StaleTriangle {
        /// Index of the leaf block.
        leaf: u32,
        /// The triangle it names.
        triangle: u32,
    },
    /// A triangle is in no leaf or in more than one.
    #[error("triangle {triangle} is in {leaves} leaves instead of one; build the tree again")]
    LostTriangle {
        /// Index of the triangle in the slice that the tree was built from.
        triangle: u32,
        /// How many leaves hold it.
        leaves: u32,
    },
    /// The tree is deeper than the traversal stack allows.
    #[error("the tree is {depth} levels deep, the traversal stack allows {limit}; build the tree again")]
    TooDeep {
        /// Levels of nodes that the tree has.
        depth: u32,
        /// Levels of nodes that a traversal allows.
        limit: u32,
    },
}
