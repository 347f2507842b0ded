//! From vertex lists to triangles, lines and points (glTF 2.0, 3.7.2.1).

use crate::stroke::Strokes;

/// What a list of vertices is made into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Topology {
    Triangles(TrianglePattern),
    Strokes(StrokePattern),
}

/// Ways to make points and lines of a list of vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum StrokePattern {
    Points,
    /// Every two vertices are a line.
    Lines,
    /// Each vertex with the next, the last with the first.
    Loop,
    /// Each vertex with the next.
    Strip,
}

/// Ways to make triangles of a list of vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TrianglePattern {
    /// Every three vertices are a triangle.
    Triangles,
    /// Each vertex with the two before it, winding alternately.
    Strip,
    /// Each two neighbours with the first vertex.
    Fan,
}

impl Topology {
    /// From the primitive's `mode`, if it is a known one.
    pub(super) fn from_code(mode: u32) -> Option<Self> {
        Some(match mode {
            0 => Self::Strokes(StrokePattern::Points),
            1 => Self::Strokes(StrokePattern::Lines),
            2 => Self::Strokes(StrokePattern::Loop),
            3 => Self::Strokes(StrokePattern::Strip),
            4 => Self::Triangles(TrianglePattern::Triangles),
            5 => Self::Triangles(TrianglePattern::Strip),
            6 => Self::Triangles(TrianglePattern::Fan),
            _ => return None,
        })
    }
}

impl TrianglePattern {
    pub(super) fn triangle_count(self, vertex_count: usize) -> usize {
        match self {
            Self::Triangles => vertex_count / 3,
            Self::Strip | Self::Fan => vertex_count.saturating_sub(2),
        }
    }

    /// Vertices at the end that make no triangle.
    pub(super) fn leftover(self, vertex_count: usize) -> usize {
        match self {
            Self::Triangles => vertex_count % 3,
            Self::Strip | Self::Fan => 0,
        }
    }
}

/// The points or lines of `count` vertices, of which `vertex(at)` is the index.
pub(super) fn strokes(pattern: StrokePattern, count: usize, vertex: impl Fn(usize) -> u32) -> Strokes {
    let lines = |count: usize, ends: &dyn Fn(usize) -> [usize; 2]| {
        Strokes::Lines((0..count).map(|at| ends(at).map(&vertex)).collect())
    };
    match pattern {
        StrokePattern::Points => Strokes::Points((0..count).map(&vertex).collect()),
        StrokePattern::Lines => lines(count / 2, &|at| [2 * at, 2 * at + 1]),
        StrokePattern::Strip => lines(count.saturating_sub(1), &|at| [at, at + 1]),
        // Of two vertices the way back is the same line.
        StrokePattern::Loop if count < 3 => lines(count.saturating_sub(1), &|at| [at, at + 1]),
        StrokePattern::Loop => lines(count, &|at| [at, (at + 1) % count]),
    }
}

/// The triangles of `count` vertices, of which `vertex(at)` is the index.
pub(super) fn triangles(
    topology: TrianglePattern,
    count: usize,
    vertex: impl Fn(usize) -> u32,
) -> Vec<[u32; 3]> {
    let corners = |at: usize| match topology {
        TrianglePattern::Triangles => [3 * at, 3 * at + 1, 3 * at + 2],
        TrianglePattern::Strip => [at, at + 1 + at % 2, at + 2 - at % 2],
        TrianglePattern::Fan => [at + 1, at + 2, 0],
    };
    (0..topology.triangle_count(count)).map(|at| corners(at).map(&vertex)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(topology: TrianglePattern, count: usize) -> Vec<[u32; 3]> {
        triangles(topology, count, |at| 10 + at as u32)
    }

    #[test]
    fn each_topology_winds_as_the_specification_says() {
        assert_eq!(of(TrianglePattern::Triangles, 7), [[10, 11, 12], [13, 14, 15]]);
        assert_eq!(of(TrianglePattern::Strip, 5), [[10, 11, 12], [11, 13, 12], [12, 13, 14]]);
        assert_eq!(of(TrianglePattern::Fan, 5), [[11, 12, 10], [12, 13, 10], [13, 14, 10]]);
    }

    #[test]
    fn too_few_vertices_make_no_triangle() {
        for topology in [TrianglePattern::Triangles, TrianglePattern::Strip, TrianglePattern::Fan] {
            for count in 0..3 {
                assert!(of(topology, count).is_empty());
            }
        }
    }
}
