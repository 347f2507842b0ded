//! What a map's rays find: everything that stands in the light of a texel.

use glam::Vec3;
use rayon::prelude::*;

use super::{projection::Projection, technique::View};
use crate::contract::MIN_ALPHA;

/// A fragment in the light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blocker {
    /// Along the ray from the light, world units.
    pub(super) depth: f32,
    /// Index of its triangle in the frame.
    pub(super) triangle: u32,
    /// Share of the light that passes.
    pub(super) through: Vec3,
}

/// What a ray from the light meets up to the first opaque surface.
#[derive(Debug, Default)]
pub(super) struct Blockers {
    /// From the light on; equal depths in the order of their triangles. Sorted even where a technique could
    /// do without, so that sums have the same bits whatever the shape of the tree.
    pub(super) transparent: Vec<Blocker>,
    /// Depth of the first opaque surface; infinite without one.
    pub(super) opaque_depth: f32,
}

impl Blockers {
    /// Transmittance of all transparent ones.
    pub(super) fn through(&self) -> Vec3 {
        self.transparent.iter().map(|blocker| blocker.through).product()
    }

    /// Depths of the first and the last transparent one; an empty range at the far end without any.
    pub(super) fn range(&self) -> [f32; 2] {
        let depth = |blocker: Option<&Blocker>| blocker.map_or(f32::INFINITY, |blocker| blocker.depth);
        [depth(self.transparent.first()), depth(self.transparent.last())]
    }

    fn find(&mut self, view: &View<'_>, projection: &Projection, texel: usize) {
        let frame = view.stage.frame();
        self.transparent.clear();
        self.opaque_depth = f32::INFINITY;
        view.stage.bvh().traverse(&projection.ray(texel), |hit| {
            let width = projection.texel_side(texel, hit.t);
            let alpha = frame.opacity(hit.triangle, hit.u, hit.v, width);
            if alpha >= 1.0 {
                self.opaque_depth = self.opaque_depth.min(hit.t);
            } else if alpha >= MIN_ALPHA {
                let through = frame.light_through(hit.triangle, hit.u, hit.v, hit.front, alpha, width);
                self.transparent.push(Blocker { depth: hit.t, triangle: hit.triangle, through });
            }
            self.opaque_depth
        });
        let opaque_depth = self.opaque_depth;
        self.transparent.retain(|blocker| blocker.depth < opaque_depth);
        self.transparent
            .sort_unstable_by(|a, b| a.depth.total_cmp(&b.depth).then(a.triangle.cmp(&b.triangle)));
    }
}

/// What `record` appends of the blockers of each texel, in the order of the texels, whatever the number of
/// threads.
pub(super) fn record<T: Copy + Send>(
    view: &View<'_>,
    projection: &Projection,
    record: impl Fn(usize, &Blockers, &mut Vec<T>) + Sync,
) -> Vec<T> {
    let side = projection.side();
    let rows = (0..projection.texels() / side).into_par_iter().map(|row| {
        let mut blockers = Blockers::default();
        let mut recorded = Vec::new();
        for texel in row * side..(row + 1) * side {
            blockers.find(view, projection, texel);
            record(texel, &blockers, &mut recorded);
        }
        recorded
    });
    rows.collect::<Vec<_>>().concat()
}
