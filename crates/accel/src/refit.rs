//! A tree that follows its triangles: leaves and boxes are found again, its shape stays.
//!
//! A refit (Wald, Boulos and Shirley, *Ray Tracing Deformable Scenes Using Dynamic Bounding Volume
//! Hierarchies*, 2007) is one pass over the leaves and one over the nodes, where a build sorts everything on
//! each level. What it loses is quality: triangles that were neighbours when the tree was built part, and
//! boxes overlap. [`Watch`] says when a new tree pays.

use glam::Vec3;
use rayon::prelude::*;

use crate::build::{Bounds, Part};
use crate::node::{Block, Child, Node, WIDTH};

/// Blocks that a task renews at least: some 50 µs.
const LEAST_TASK: usize = 256;

/// Makes a part of a tree fit its triangles again, and says what it costs now. `renew` puts into each block
/// what is left of its triangles, where they are now, and returns their box. None if nothing is left.
///
/// `nodes` and `blocks` are those of the part, the first of which have the indices `first`; parents come
/// before their children.
pub(crate) fn refit(
    part: Part,
    nodes: &mut [Node],
    blocks: &mut [Block],
    first: [usize; 2],
    renew: impl Fn(&mut Block) -> Bounds + Send + Sync,
) -> Option<(Part, TreeCost)> {
    let [first_node, first_block] = first;
    let renew = |block: &mut Block| (renew(block), Leaf::new(block));
    let (mut of_blocks, mut leaves) = (Vec::new(), Vec::new());
    blocks.par_iter_mut().with_min_len(LEAST_TASK).map(renew).unzip_into_vecs(&mut of_blocks, &mut leaves);
    let mut of_nodes = vec![Bounds::EMPTY; nodes.len()];
    let bounds_of = |child: Child, of_nodes: &[Bounds]| {
        if child.is_block() {
            of_blocks[child.index() - first_block]
        } else {
            of_nodes[child.index() - first_node]
        }
    };
    for (index, node) in nodes.iter_mut().enumerate().rev() {
        for lane in 0..WIDTH {
            let child = node.children[lane];
            if child == Child::NONE {
                continue;
            }
            let bounds = bounds_of(child, &of_nodes);
            if bounds.is_empty() {
                node.set(lane, Vec3::INFINITY, Vec3::NEG_INFINITY, Child::NONE);
            } else {
                let (lower, upper) = bounds.corners();
                node.set(lane, lower.into(), upper.into(), child);
                of_nodes[index] = of_nodes[index].union(bounds);
            }
        }
    }
    let bounds = bounds_of(part.root, &of_nodes);
    (!bounds.is_empty()).then(|| (Part { bounds, ..part }, TreeCost::new(nodes, &leaves)))
}

/// What a leaf holds.
#[derive(Clone, Copy)]
struct Leaf {
    triangle_count: u32,
    /// Half the surface areas of the boxes of its triangles, added up.
    half_areas: f32,
}

impl Leaf {
    fn new(block: &Block) -> Self {
        let used = |lane: &usize| block.triangles[*lane] != u32::MAX;
        let half_area = |lane: usize| {
            Bounds::of_triangle(&[0, 1, 2].map(|vertex: usize| block.vertex(lane, vertex))).half_area()
        };
        (0..WIDTH).take_while(used).fold(Self { triangle_count: 0, half_areas: 0.0 }, |leaf, lane| Self {
            triangle_count: leaf.triangle_count + 1,
            half_areas: leaf.half_areas + half_area(lane),
        })
    }
}

/// How many triangles a part holds, and how many boxes of it a random line meets for each box of one of them
/// (surface area heuristic).
///
/// Relative to the triangles, not to the box around all: that grows with the first that goes astray, and
/// would hide what becomes of the others. Where they move apart, or grow, a new tree costs more, too, and one
/// is built now and then in vain.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TreeCost {
    triangle_count: usize,
    boxes_per_triangle: f64,
}

impl TreeCost {
    /// Of a part that has just been built, from its nodes and blocks.
    pub(crate) fn of(nodes: &[Node], blocks: &[Block]) -> Self {
        let leaves: Vec<Leaf> = blocks.par_iter().with_min_len(LEAST_TASK).map(Leaf::new).collect();
        Self::new(nodes, &leaves)
    }

    fn new(nodes: &[Node], leaves: &[Leaf]) -> Self {
        let children = nodes.iter().flat_map(|node| {
            let used = (0..WIDTH).filter(|&lane| node.children[lane] != Child::NONE);
            used.map(|lane| Bounds::of_child(node, lane).half_area())
        });
        let boxes: f64 = children.map(f64::from).sum();
        let triangles: f64 = leaves.iter().map(|leaf| f64::from(leaf.half_areas)).sum();
        Self {
            triangle_count: leaves.iter().map(|leaf| leaf.triangle_count as usize).sum(),
            boxes_per_triangle: boxes / triangles.max(f64::MIN_POSITIVE),
        }
    }
}

/// Says when a tree is to be built anew.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Watch {
    built: TreeCost,
    /// How many triangles may be gone, and how many may have come.
    most_arrivals: usize,
    /// Refits since.
    refits: u32,
}

impl Watch {
    /// How much more than when it was built a tree may cost.
    const MOST_COST: f64 = 1.1;
    /// One in so many triangles may have come since the tree was built, or gone.
    const ARRIVALS: usize = 16;
    /// Refits after which a tree is built anew in any case.
    const MOST_REFITS: u32 = 60;

    /// Keeps every tree.
    #[cfg(test)]
    pub(crate) const BLIND: Self = Self {
        built: TreeCost { triangle_count: 0, boxes_per_triangle: f64::INFINITY },
        most_arrivals: usize::MAX,
        refits: 0,
    };

    pub(crate) fn new(built: TreeCost) -> Self {
        Self { built, most_arrivals: built.triangle_count / Self::ARRIVALS, refits: 0 }
    }

    /// Whether the tree is to be kept after another refit, beside `arrivals` that have come since it was
    /// built.
    pub(crate) fn keeps(&mut self, now: TreeCost, arrivals: usize) -> bool {
        self.refits += 1;
        let gone = self.built.triangle_count.saturating_sub(now.triangle_count);
        self.refits <= Self::MOST_REFITS
            && gone.max(arrivals) <= self.most_arrivals
            && now.boxes_per_triangle <= Self::MOST_COST * self.built.boxes_per_triangle
    }
}
