//! From vertex lists to triangles (glTF 2.0, 3.7.2.1).

/// Ways to make triangles of a list of vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Topology {
    /// Every three vertices are a triangle.
    Triangles,
    /// Each vertex with the two before it, winding alternately.
    Strip,
    /// Each two neighbours with the first vertex.
    Fan,
}

impl Topology {
    /// From the primitive's `mode`; the error is the name of a mode without triangles, or nothing for an
    /// unknown one.
    pub(super) fn from_code(mode: u32) -> Result<Self, Option<&'static str>> {
        match mode {
            0 => Err(Some("points")),
            1 => Err(Some("lines")),
            2 => Err(Some("line loops")),
            3 => Err(Some("line strips")),
            4 => Ok(Self::Triangles),
            5 => Ok(Self::Strip),
            6 => Ok(Self::Fan),
            _ => Err(None),
        }
    }

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

/// The triangles of `count` vertices, of which `vertex(at)` is the index.
pub(super) fn triangles(topology: Topology, count: usize, vertex: impl Fn(usize) -> u32) -> Vec<[u32; 3]> {
    let corners = |at: usize| match topology {
        Topology::Triangles => [3 * at, 3 * at + 1, 3 * at + 2],
        Topology::Strip => [at, at + 1 + at % 2, at + 2 - at % 2],
        Topology::Fan => [at + 1, at + 2, 0],
    };
    (0..topology.triangle_count(count)).map(|at| corners(at).map(&vertex)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(topology: Topology, count: usize) -> Vec<[u32; 3]> {
        triangles(topology, count, |at| 10 + at as u32)
    }

    #[test]
    fn each_topology_winds_as_the_specification_says() {
        assert_eq!(of(Topology::Triangles, 7), [[10, 11, 12], [13, 14, 15]]);
        assert_eq!(of(Topology::Strip, 5), [[10, 11, 12], [11, 13, 12], [12, 13, 14]]);
        assert_eq!(of(Topology::Fan, 5), [[11, 12, 10], [12, 13, 10], [13, 14, 10]]);
    }

    #[test]
    fn too_few_vertices_make_no_triangle() {
        for topology in [Topology::Triangles, Topology::Strip, Topology::Fan] {
            for count in 0..3 {
                assert!(of(topology, count).is_empty());
            }
        }
    }
}
