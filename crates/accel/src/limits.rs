//! Ranges that build, traversal and validation agree on.

/// Largest magnitude of a coordinate: areas, and their sums in the build's heuristic, still are an `f32`.
pub(crate) const COORDINATE_LIMIT: f32 = 1e12;

/// Largest component of a ray's direction: inverses and distances stay in the range of `f32`.
pub(crate) const SPEED_LIMIT: f32 = 1e18;
/// Least value of the largest component of a ray's direction, for the same reason as [`SPEED_LIMIT`].
pub(crate) const LEAST_SPEED: f32 = 1e-18;

/// Triangles from this index on are ignored: the build tags its references with the bits above.
pub(crate) const INDEX_LIMIT: usize = 1 << 30;

/// Levels of nodes that a tree may have: the build stays below it, and the traversal's stack is sized by it.
pub(crate) const LEVEL_LIMIT: u32 = 45;
