//! Checks a tree and measures it.

use glam::Vec3;

use crate::build::is_kept;
use crate::error::AccelError;
use crate::limits::{INDEX_LIMIT, LEVEL_LIMIT};
use crate::node::{Block, Child, Node, WIDTH};
use crate::tree::Tree;

/// Measures of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Nodes that the root reaches.
    pub node_count: u32,
    /// Leaf blocks of up to eight triangles.
    pub leaf_count: u32,
    /// Triangles in the leaf blocks.
    pub triangle_count: u32,
    /// Levels of nodes; 0 for a tree that is a single leaf.
    pub depth: u32,
    /// Nodes and leaves that a random line through the root's box is expected to visit (surface area
    /// heuristic).
    pub sah_cost: f64,
    /// Memory of the nodes and leaves.
    pub bytes: usize,
}

/// The measures of a sound tree, or its first fault: what [`crate::Bvh::validate`] promises.
///
/// Triangles from `static_count` on are numbered `shift` further on.
pub(crate) fn validate(
    tree: Tree<'_>,
    triangles: &[[Vec3; 3]],
    static_count: usize,
    shift: u32,
) -> Result<Stats, AccelError> {
    let mut walk = Walk {
        tree,
        triangles,
        static_count,
        shift,
        node_seen: vec![false; tree.nodes.len()],
        block_seen: vec![false; tree.blocks.len()],
        leaves_of: vec![0; triangles.len()],
        stats: Stats { bytes: size_of_val(tree.nodes) + size_of_val(tree.blocks), ..Stats::default() },
    };
    if let Some(root) = tree.root {
        walk.root(root)?;
    }
    for (index, (triangle, &leaves)) in triangles.iter().zip(&walk.leaves_of).enumerate() {
        if leaves != u32::from(index < INDEX_LIMIT && is_kept(triangle)) {
            return Err(AccelError::LostTriangle { triangle: index as u32, leaves });
        }
    }
    Ok(walk.stats)
}

struct Walk<'a> {
    tree: Tree<'a>,
    triangles: &'a [[Vec3; 3]],
    static_count: usize,
    shift: u32,
    node_seen: Vec<bool>,
    block_seen: Vec<bool>,
    leaves_of: Vec<u32>,
    stats: Stats,
}

/// A child still to be looked at, and the box its parent gives it.
struct Visit {
    child: Child,
    lower: Vec3,
    upper: Vec3,
    parent: u32,
    lane: usize,
    depth: u32,
}

impl Walk<'_> {
    /// Where the triangle of a number is; none that belongs to an instance.
    fn index(&self, number: u32) -> Option<usize> {
        if (number as usize) < self.static_count {
            return Some(number as usize);
        }
        number.checked_sub(self.shift).map(|index| index as usize).filter(|&index| index >= self.static_count)
    }

    fn root(&mut self, root: Child) -> Result<(), AccelError> {
        let (lower, upper) = (Vec3::from(self.tree.lower), Vec3::from(self.tree.upper));
        let mut waiting = vec![Visit { child: root, lower, upper, parent: u32::MAX, lane: 0, depth: 0 }];
        let root_area = half_area(lower, upper).max(f64::MIN_POSITIVE);
        while let Some(visit) = waiting.pop() {
            self.stats.sah_cost += half_area(visit.lower, visit.upper) / root_area;
            self.claim(&visit)?;
            if visit.child.is_block() {
                self.block(&visit)?;
            } else {
                self.node(&visit, &mut waiting)?;
            }
        }
        Ok(())
    }

    /// Each node and each block has one parent, which also rules out cycles.
    fn claim(&mut self, visit: &Visit) -> Result<(), AccelError> {
        let seen = if visit.child.is_block() { &mut self.block_seen } else { &mut self.node_seen };
        match seen.get_mut(visit.child.index()) {
            Some(seen) if !*seen => {
                *seen = true;
                Ok(())
            }
            _ => Err(AccelError::BrokenLink { node: visit.parent, lane: visit.lane, child: visit.child.0 }),
        }
    }

    fn node(&mut self, visit: &Visit, waiting: &mut Vec<Visit>) -> Result<(), AccelError> {
        let node: &Node = &self.tree.nodes[visit.child.index()];
        let depth = visit.depth + 1;
        if depth > LEVEL_LIMIT {
            return Err(AccelError::TooDeep { depth, limit: LEVEL_LIMIT });
        }
        self.stats.node_count += 1;
        self.stats.depth = self.stats.depth.max(depth);
        for (lane, &child) in node.children.iter().enumerate() {
            let (lower, upper) = (node.lower(lane), node.upper(lane));
            if child == Child::NONE {
                // No ray enters a box turned inside out.
                if lower != Vec3::INFINITY || upper != Vec3::NEG_INFINITY {
                    return Err(AccelError::BrokenLink { node: visit.child.0, lane, child: child.0 });
                }
                continue;
            }
            let parent = visit.child.0;
            if !(lower.cmple(upper).all() && visit.contains(lower, upper)) {
                return Err(AccelError::BrokenBox { node: parent, lane });
            }
            waiting.push(Visit { child, lower, upper, parent, lane, depth });
        }
        Ok(())
    }

    fn block(&mut self, visit: &Visit) -> Result<(), AccelError> {
        let block: &Block = &self.tree.blocks[visit.child.index()];
        self.stats.leaf_count += 1;
        for lane in (0..WIDTH).filter(|&lane| block.triangles[lane] != u32::MAX) {
            let triangle = block.triangles[lane];
            let vertices = [0, 1, 2].map(|vertex| block.vertex(lane, vertex));
            let index = self.index(triangle);
            if index.and_then(|index| self.triangles.get(index)) != Some(&vertices) {
                return Err(AccelError::StaleTriangle { leaf: visit.child.index() as u32, triangle });
            }
            self.leaves_of[index.expect("it has a triangle")] += 1;
            self.stats.triangle_count += 1;
            let [a, b, c] = vertices;
            if !visit.contains(a.min(b).min(c), a.max(b).max(c)) {
                return Err(AccelError::BrokenBox { node: visit.parent, lane: visit.lane });
            }
        }
        Ok(())
    }
}

impl Visit {
    /// False for a NaN on either side.
    fn contains(&self, lower: Vec3, upper: Vec3) -> bool {
        (self.lower.cmple(lower) & self.upper.cmpge(upper)).all()
    }
}

fn half_area(lower: Vec3, upper: Vec3) -> f64 {
    let size = (upper - lower).as_dvec3();
    size.x * size.y + size.y * size.z + size.z * size.x
}
