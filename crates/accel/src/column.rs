//! What a ray meets in its list of a light buffer: the test of the tree, block by block.

use crate::node::{Block, WIDTH};
use crate::placement::InWorld;
use crate::ray::Hit;
use crate::simd::lanes::Lanes;
use crate::traverse::{LaneHits, Shear};

/// What a ray may meet.
pub(crate) struct Column<'a> {
    pub(crate) shear: Shear,
    pub(crate) t_min: f32,
    /// Depth below which nothing is met.
    pub(crate) lowest: f32,
    /// Opaque ones, then all others: blocks and their furthest depths.
    pub(crate) runs: [(&'a [Block], &'a [f32]); 2],
}

/// The hits of a column, on the lanes of a path.
#[inline(always)]
pub(crate) fn scan<L: Lanes>(
    lanes: L,
    column: &Column<'_>,
    mut t_max: f32,
    mut visit: impl FnMut(Hit) -> f32,
) {
    let mut hits = LaneHits::NONE;
    for (blocks, tops) in column.runs {
        for (block, &top) in blocks.iter().zip(tops) {
            if top < column.lowest {
                break;
            }
            if !column.shear.hit(lanes, &InWorld, block, column.t_min, t_max, &mut hits) {
                continue;
            }
            let mut waiting = hits.lanes;
            while waiting != 0 {
                let lane = waiting.trailing_zeros() as usize % WIDTH;
                waiting &= waiting - 1;
                let hit = hits.hit(block, lane);
                if hit.t <= t_max {
                    t_max = t_max.min(visit(hit));
                }
            }
            if t_max < column.t_min {
                return;
            }
        }
    }
}
